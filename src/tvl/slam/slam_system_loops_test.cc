// Loops as the whole system uses them: what is applied, when, and what it does to the map.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>

#include "tvl/slam/slam_system.h"
#include "tvl/slam/test_drive.h"
#include "tvl/slam/test_return_drive.h"

namespace tvl {
namespace {

using synthetic::ReturnDrive;
using synthetic::Twist;

constexpr int kLag = 6;

SlamOptions OptionsOfReturn() {
  SlamOptions options;
  options.use_camera = false;
  options.mapping.local_map.keep_path_m = 20.0;  // on the way back the way there has been left
  options.loops.lag_keyframes = kLag;
  options.loops.separation.min_time_s = 3.0;
  options.loops.separation.min_path_m = 140.0;  // loops by the street alone: the square stays
  options.loops.verification.source.keyframes_back = 5;
  return options;
}

int Accepted(const LoopReport& report) {
  return static_cast<int>(
      std::count_if(report.records.begin(), report.records.end(),
                    [](const LoopRecord& r) { return r.outcome == LoopOutcome::kAccepted; }));
}

std::vector<Rigid3d> WorldPoses(const Map& map) {
  std::vector<Rigid3d> poses;
  for (const Keyframe& keyframe : map.keyframes) poses.push_back(keyframe.T_world_lidar);
  return poses;
}

// A run that can be looked at after each frame.
struct Playback {
  explicit Playback(const SlamOptions& options = OptionsOfReturn(), bool in_background = false)
      : system(drive.setup(), Deskew::kNone, options, in_background) {}

  bool Next() {
    if (frames.size() == ReturnDrive::kFrames) return false;
    frames.push_back(system.ProcessFrame(drive.Frame(frames.size()), Executor(1)));
    poses.push_back(WorldPoses(system.map()));
    return true;
  }
  size_t last() const { return frames.size() - 1; }
  // Of the last frame's pose, by the street.
  double Error_m() const {
    return (frames.back().T_world_lidar.t() - ReturnDrive::Truth(last()).t()).norm();
  }

  ReturnDrive drive;
  SlamSystem system;
  std::vector<FrameResult> frames;
  std::vector<std::vector<Rigid3d>> poses;  // of all keyframes in the world, after each frame
};

// Of the way back, where the street alone is seen.
double WorstError_m(const Trajectory& trajectory) {
  double worst_m = 0.0;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (!ReturnDrive::IsBack(i) || ReturnDrive::Along_m(i) > 35.0) continue;
    const Rigid3d T = trajectory[0].T_world_lidar.Inverse() * trajectory[i].T_world_lidar;
    worst_m = std::max(worst_m, (T.t() - ReturnDrive::Truth(i).t()).norm());
  }
  return worst_m;
}

// Of the walls that rays from a pose meet, the share that the map has within 15 cm.
double ShareInMap(const synthetic::World& street, const Rigid3d& T_odom_lidar,
                  const LocalMap& map) {
  int walls = 0, found = 0;
  for (const double elevation : {-0.06, -0.03, 0.0, 0.03, 0.06}) {
    for (int column = 0; column < 360; ++column) {
      const Eigen::Vector3d ray = T_odom_lidar.q() * synthetic::Ray(DegToRad(column), elevation);
      const double range = street.Range(T_odom_lidar.t(), ray);
      if (range > 20.0) continue;
      const Eigen::Vector3d p = T_odom_lidar.t() + range * ray;
      const Surfel* surfel = map.planes().Find(p);
      ++walls;
      found += surfel != nullptr && (p - surfel->mean).norm() < 0.6 &&
               std::abs(surfel->axis.dot(p - surfel->mean)) < 0.15;
    }
  }
  return static_cast<double>(found) / walls;
}

TEST(SlamSystemLoops, ARevisitComesHomeWithoutAJumpOrASecondWall) {
  Playback run;
  int looks = 0;
  while (run.Next()) {
    // The odometry frame never jumps, whatever is accepted and fetched into the local map: 1.5 m.
    const Rigid3d error =
        ReturnDrive::Driven(run.last()).Inverse() * run.frames.back().T_odom_lidar;
    ASSERT_LT(error.t().norm(), 0.3) << "frame " << run.last();
    if (run.last() == 0) continue;
    const Rigid3d step =
        run.frames[run.last() - 1].T_odom_lidar.Inverse() * run.frames.back().T_odom_lidar;
    const Rigid3d driven =
        ReturnDrive::Driven(run.last() - 1).Inverse() * ReturnDrive::Driven(run.last());
    ASSERT_LT((step.t() - driven.t()).norm(), 0.05) << "frame " << run.last();
    // What earlier passes saw lies where it is seen now, not where the odometry had it then.
    if (run.system.local_map().connected() < 12 || ReturnDrive::Along_m(run.last()) < 15.0)
      continue;
    const Rigid3d& T_odom_lidar = run.frames.back().T_odom_lidar;
    const LocalMap& map = run.system.local_map();
    EXPECT_GT(ShareInMap(run.drive.street(), T_odom_lidar, map), 0.6) << "frame " << run.last();
    EXPECT_LT(ShareInMap(run.drive.street_as_mapped(), T_odom_lidar, map), 0.1);
    ++looks;
  }
  EXPECT_GT(looks, 2);
  EXPECT_LT(run.Error_m(), 0.1);  // at once, without Finish()
  run.system.Finish();
  EXPECT_GE(Accepted(run.system.loops()), 10);
  EXPECT_EQ(run.system.loop_fault(), "");
  EXPECT_LT(WorstError_m(run.system.trajectory()), 0.1);
  EXPECT_GT(WorstError_m(WorldTrajectory(run.system.odometry_path(),
                                         WithoutLoops(run.system.map().keyframes))),
            1.3);
}

void ExpectSame(const std::vector<Rigid3d>& a, const std::vector<Rigid3d>& b, size_t keyframe) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_LT((a[i].t() - b[i].t()).norm(), 1e-9) << i << " as of keyframe " << keyframe;
    ASSERT_LT((a[i].q().coeffs() - b[i].q().coeffs()).norm(), 1e-9) << i;
  }
}

double FurthestApart_m(const std::vector<Rigid3d>& a, const std::vector<Rigid3d>& b) {
  double furthest_m = 0.0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    furthest_m = std::max(furthest_m, (a[i].t() - b[i].t()).norm());
  }
  return furthest_m;
}

// The poses with a correction of the oldest; the others follow by the odometry.
void Correct(const LoopUpdate& update, const Map& map, std::vector<Rigid3d>* poses) {
  if (update.T_world_lidar.empty()) return;
  const size_t known = update.T_world_lidar.size(), all = poses->size();
  *poses = update.T_world_lidar;
  for (size_t i = known; i < all; ++i) {
    poses->push_back(poses->back() * map.keyframes[i].T_prev_cur);
  }
}

// Such that the second look finds something: keyframes are compared with old ones close by only,
// the more the longer the path, and so the first of the way back have to wait for those that
// follow.
SlamOptions OptionsOfNearness() {
  SlamOptions options = OptionsOfReturn();
  options.loops.use_lidar = false;
  options.loops.drift.vicinity_floor_m = 2.2;
  options.loops.drift.vicinity_share = 0.0165;
  return options;
}

TEST(SlamSystemLoops, WhatWasFoundIsAppliedLagKeyframesLaterToAllPoses) {
  Playback run(OptionsOfNearness()), beside(OptionsOfNearness(), true);
  std::vector<std::vector<Rigid3d>> after_keyframe;
  while (run.Next() && beside.Next()) {
    if (run.frames.back().is_keyframe) after_keyframe.push_back(run.poses.back());
    // In the background all is the same to the bit.
    ASSERT_EQ(run.frames.back().T_odom_lidar.t(), beside.frames.back().T_odom_lidar.t());
    ASSERT_EQ(run.frames.back().T_world_lidar.t(), beside.frames.back().T_world_lidar.t());
    ASSERT_EQ(run.system.local_map().connected(), beside.system.local_map().connected());
  }
  run.system.Finish();
  beside.system.Finish();

  // The same keyframes by hand.
  const Map& map = run.system.map();
  LoopCloser closer(OptionsOfNearness().loops, run.drive.setup().calibration, map.store);
  std::vector<LoopUpdate> updates;
  std::vector<Rigid3d> expected;
  for (size_t n = 0; n < map.keyframes.size(); ++n) {
    const Keyframe& keyframe = map.keyframes[n];
    updates.push_back(closer.Process(keyframe, *map.store->Get(keyframe.id.index)));
    expected.push_back(n == 0 ? Rigid3d() : expected.back() * keyframe.T_prev_cur);
    if (n >= kLag) Correct(updates[n - kLag], map, &expected);
    ExpectSame(expected, after_keyframe[n], n);
  }
  const size_t before = closer.report().records.size();
  const LoopUpdate second_look = closer.LookAgain();
  ASSERT_GT(closer.report().records.size(), before) << "nothing left for the second look to find";
  const LoopUpdate polished = closer.Polish();
  EXPECT_GT(FurthestApart_m(second_look.T_world_lidar, polished.T_world_lidar), 1e-4)
      << "nothing left for the polish to do";
  ExpectSame(polished.T_world_lidar, WorldPoses(map), map.keyframes.size());
  ExpectSame(WorldPoses(beside.system.map()), WorldPoses(map), map.keyframes.size());
}

// The nameless file of the only keyframe store in this process, as it can be opened.
std::string SpillFile() {
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    const std::filesystem::path target = std::filesystem::read_symlink(entry, error);
    if (target.string().find("/tvl_keyframes_") != std::string::npos) return entry.path().string();
  }
  return "";
}

// Where each payload begins in the file: eight arrays, each after its length.
std::vector<std::streamoff> BeginsInFile(const Map& map) {
  std::vector<std::streamoff> begins = {0};
  for (const Keyframe& keyframe : map.keyframes) {
    const size_t bytes = SizeOf(*map.store->Get(keyframe.id.index)) + 8 * sizeof(uint64_t);
    begins.push_back(begins.back() + static_cast<std::streamoff>(bytes));
  }
  begins.resize(begins.size() - 2);  // the newest is in memory
  return begins;
}

void OverwriteLengths(const std::string& file, const std::vector<std::streamoff>& begins,
                      uint64_t length) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  for (const std::streamoff begin : begins) {
    stream.seekp(begin);
    stream.write(reinterpret_cast<const char*>(&length), sizeof length);
  }
  ASSERT_TRUE(stream.good());
}

struct Breakdown {
  const char* name;
  // With the local map fetching keyframes of earlier passes the frame itself meets the fault.
  // Without only the loop search does, and the system hears of it kLag keyframes later: here when
  // all frames are through.
  bool fetches;
  size_t frame;
};
void PrintTo(const Breakdown& breakdown, std::ostream* os) { *os << breakdown.name; }

class SlamSystemWithoutStore : public ::testing::TestWithParam<Breakdown> {
 protected:
  static SlamOptions Options() {
    SlamOptions options = OptionsOfReturn();
    options.mapping.store.memory_mib = 0.0;
    if (!GetParam().fetches) options.mapping.local_map.connected_radius_m = 0.0;
    return options;
  }
};

TEST_P(SlamSystemWithoutStore, TheSearchEndsAndNothingElse) {
  Playback run(Options());
  while (run.frames.size() < GetParam().frame) run.Next();
  const int accepted = Accepted(run.system.loops());
  ASSERT_GE(accepted, 6);
  ASSERT_EQ(run.system.local_map().connected() > 3U, GetParam().fetches);
  const std::string file = SpillFile();
  const std::vector<std::streamoff> begins = BeginsInFile(run.system.map());
  OverwriteLengths(file, begins, ~uint64_t{0});  // no vector is that long: not one of our errors
  bool is_first = true;
  while (run.Next()) {
    ASSERT_LT(run.Error_m(), 0.1) << "frame " << run.last();
    EXPECT_EQ(run.system.loop_fault().empty(), !GetParam().fetches);
    if (!is_first || !run.frames.back().is_keyframe) continue;
    OverwriteLengths(file, begins, 1000000);  // from now on it fails with other words
    is_first = false;
  }
  run.system.Finish();
  EXPECT_NE(run.system.loop_fault().find("vector"), std::string::npos)
      << "not the first fault: " << run.system.loop_fault();
  EXPECT_TRUE(run.system.loop_search_broke()) << "no InputError: nothing that is said of a file";
  EXPECT_EQ(run.system.local_map().connected(), 0U) << "of a graph that nobody keeps up";
  EXPECT_GE(Accepted(run.system.loops()), accepted) << "the report says what was closed";
  EXPECT_LT(WorstError_m(run.system.trajectory()), 0.1) << "what was closed stays";
}

INSTANTIATE_TEST_SUITE_P(Met, SlamSystemWithoutStore,
                         ::testing::Values(Breakdown{"by the frame", true, 115},
                                           Breakdown{"by the search", false, 123}));

// A disk that fails is no defect of the program.
TEST(SlamSystemLoops, AFileThatCannotBeReadBackIsNoDefect) {
  SlamOptions options = OptionsOfReturn();
  options.mapping.store.memory_mib = 0.0;
  Playback run(options);
  while (run.frames.size() < 115) run.Next();
  const int nothing = open("/dev/null", O_RDWR);
  dup2(nothing, std::stoi(std::filesystem::path(SpillFile()).filename().string()));
  close(nothing);
  while (run.Next()) ASSERT_LT(run.Error_m(), 0.1) << "frame " << run.last();
  run.system.Finish();
  EXPECT_NE(run.system.loop_fault().find("cannot be read back"), std::string::npos);
  EXPECT_FALSE(run.system.loop_search_broke());
}

TEST(SlamSystemLoops, KeyframesCarryTheCovarianceOfAllFramesBetweenThem) {
  synthetic::DriveOptions drive_options;
  drive_options.frames = 16;
  const synthetic::Drive drive(drive_options);
  SlamOptions options;
  options.use_camera = false;
  options.mapping.keyframes.min_translation_m = 2.5;
  options.mapping.keyframes.dense_keyframes = 0;
  SlamSystem system(drive.setup(), Deskew::kNone, options);
  std::vector<FrameResult> frames;
  for (size_t i = 0; i < drive.size(); ++i) {
    frames.push_back(system.ProcessFrame(drive.Frame(i), Executor(1)));
  }
  const std::vector<Keyframe>& keyframes = system.map().keyframes;
  ASSERT_GE(keyframes.size(), 4U);
  for (size_t k = 1; k < keyframes.size(); ++k) {
    const auto begin = static_cast<size_t>(keyframes[k - 1].frame);
    const auto end = static_cast<size_t>(keyframes[k].frame);
    EXPECT_GE(end, begin + 3);
    // What the frames add to the map's own error, each seen from the keyframe, and noise at the
    // ends.
    Matrix6d sum = frames[end].noise_covariance;
    for (size_t i = begin + 1; i <= end; ++i) {
      const Matrix6d adjoint =
          (frames[end].T_odom_lidar.Inverse() * frames[i].T_odom_lidar).Adjoint();
      sum += adjoint * frames[i].walk_covariance * adjoint.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Matrix6d> beyond(keyframes[k].covariance - sum);
    EXPECT_GT(beyond.eigenvalues()[0], -1e-9) << "keyframe " << k << ": noise and bias come on top";
  }
}

}  // namespace
}  // namespace tvl
