// Loop closing when odometry is bad. Drives with the lidar alone, adds drift to the links between
// keyframes, and closes loops among what results; prints what was found and the error before and
// after.
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "tvl/cli/input.h"
#include "tvl/eval/absolute_error.h"
#include "tvl/eval/loop_evaluation.h"
#include "tvl/slam/slam_system.h"

namespace {

using namespace tvl;  // NOLINT(google-build-using-namespace)

// Per metre driven.
struct Drift {
  double yaw_rad = 0.0;                          // about the lidar's z axis
  double x_share = 0.0, y_share = 0.0, z_share = 0.0;  // m, along the odometry frame's axes
};

// The motion between two poses of the odometry frame, with drift.
Rigid3d MotionWithDrift(const Rigid3d& T_odom_prev, const Rigid3d& T_odom_cur, const Drift& drift) {
  const double length_m = (T_odom_cur.t() - T_odom_prev.t()).norm();
  Vector6d turn = Vector6d::Zero();
  turn[2] = length_m * drift.yaw_rad;
  const Eigen::Vector3d shift_m =
      length_m * Eigen::Vector3d(drift.x_share, drift.y_share, drift.z_share);
  return T_odom_prev.Inverse() * Rigid3d(T_odom_cur.q(), T_odom_cur.t() + shift_m) *
         Rigid3d::Exp(turn);
}

// Keyframes as loop closing corrects them.
class DriftingDrive {
 public:
  DriftingDrive(const Calibration& calibration, const Map& map, const Drift& drift)
      : map_(map), drift_(drift), closer_(LoopOptions(), calibration, map.store) {}

  void AddNewestKeyframe() {
    Keyframe keyframe = map_.keyframes.back();
    if (map_.keyframes.size() > 1) {
      const Keyframe& previous = map_.keyframes[map_.keyframes.size() - 2];
      keyframe.T_prev_cur =
          MotionWithDrift(previous.T_odom_lidar, keyframe.T_odom_lidar, drift_);
      motions_.push_back(keyframe.T_prev_cur);
    }
    T_corrected_.push_back(T_corrected_.empty() ? Rigid3d()
                                                : T_corrected_.back() * motions_.back());
    Apply(closer_.Process(keyframe, *map_.store->Get(keyframe.id.index)));
  }
  void Finish() {
    Apply(closer_.LookAgain());
    Apply(closer_.Polish());
  }

  std::vector<Rigid3d> T_drifting() const {
    std::vector<Rigid3d> poses(1);
    for (const Rigid3d& motion : motions_) poses.push_back(poses.back() * motion);
    return poses;
  }
  const std::vector<Rigid3d>& T_corrected() const { return T_corrected_; }
  const LoopReport& report() const { return closer_.report(); }

 private:
  void Apply(const LoopUpdate& update) {
    if (update.T_world_lidar.empty()) return;
    for (size_t i = 0; i < T_corrected_.size(); ++i) {
      T_corrected_[i] = i < update.T_world_lidar.size() ? update.T_world_lidar[i]
                                                        : T_corrected_[i - 1] * motions_[i - 1];
    }
  }

  const Map& map_;
  Drift drift_;
  LoopCloser closer_;
  std::vector<Rigid3d> motions_, T_corrected_;
};

double Rmse_m(const std::vector<TrueKeyframe>& truth, const std::vector<Rigid3d>& estimate) {
  std::vector<Rigid3d> T_true;
  for (const TrueKeyframe& keyframe : truth) T_true.push_back(keyframe.T_world_lidar);
  return SummariseErrors(PositionErrors_m(T_true, estimate, AlignPositions(T_true, estimate)))
      .rmse_m;
}

void Run(const std::string& input, int threads, const Drift& drift) {
  const std::unique_ptr<Dataset> dataset = OpenInput(input);
  const std::vector<Rigid3d> truth = dataset->Truth_T_first_cam0();
  TVL_CHECK_INPUT(truth.size() == dataset->size()) << input << ": has no truth for every frame";
  const Rigid3d T_cam0_lidar = dataset->setup().calibration.T_cam0_lidar;
  SlamOptions options;
  options.use_camera = options.loops.enabled = false;
  SlamSystem system(dataset->setup(), dataset->setup().deskew.value_or(Deskew::kNone), options);
  DriftingDrive drive(dataset->setup().calibration, system.map(), drift);
  const Executor executor(threads);
  std::vector<TrueKeyframe> true_keyframes;
  for (size_t k = 0; k < dataset->size(); ++k) {
    if (!system.ProcessFrame(dataset->Frame(k), executor).is_keyframe) continue;
    const Keyframe& keyframe = system.map().keyframes.back();
    true_keyframes.push_back({keyframe.stamp, keyframe.path_m, truth[k] * T_cam0_lidar});
    drive.AddNewestKeyframe();
  }
  drive.Finish();
  std::cout << input << ": " << true_keyframes.size() << " keyframes, ATE "
            << Rmse_m(true_keyframes, drive.T_drifting()) << " m with the drift, "
            << Rmse_m(true_keyframes, drive.T_corrected()) << " m with loops\n"
            << ToText(EvaluateLoops(drive.report().records, true_keyframes));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Loop closing when odometry is bad");
  std::string input;
  int threads = 2;
  Drift drift;
  app.add_option("input", input, "A folder with truth, or sim:PRESET?key=value&...")->required();
  app.add_option("--threads", threads, "Of the odometry, default 2");
  app.add_option("--yaw", drift.yaw_rad, "rad per metre driven");
  app.add_option("--x", drift.x_share, "Metres per metre driven");
  app.add_option("--y", drift.y_share, "Metres per metre driven");
  app.add_option("--z", drift.z_share, "Metres per metre driven; 0.01: climbs 1 m every 100 m");
  CLI11_PARSE(app, argc, argv);
  try {
    Run(input, threads, drift);
  } catch (const std::exception& error) {
    std::cerr << "loops_with_drift: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
