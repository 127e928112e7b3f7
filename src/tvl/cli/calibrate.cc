// tvl calibrate: finds where the camera points while driving, and writes a calibration that says
// so.
#include <oneapi/tbb/info.h>
#include <CLI/CLI.hpp>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/frame_range.h"
#include "tvl/cli/input.h"
#include "tvl/cli/interrupt.h"
#include "tvl/cli/output_folder.h"
#include "tvl/cli/progress.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/kitti_layout.h"
#include "tvl/io/rig.h"
#include "tvl/report/calibration_text.h"
#include "tvl/slam/options_io.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {
namespace {

// A camera that was farther off has disturbed the poses it was judged by, and its outlines were
// read beside where they are: the drive is gone through once more.
constexpr double kSecondPass_rad = 0.005;  // 0.3 deg

struct CalibrateArguments {
  std::string input, out, config, deskew = "auto", frames;
  InputOptions input_options;
  int threads = tbb::info::default_concurrency();
};

RunOptions MakeOptions(const CalibrateArguments& arguments) {
  RunOptions options;
  if (!arguments.config.empty()) options = LoadOptions(arguments.config);
  options.threads = arguments.threads;
  options.deskew = ParseDeskew(arguments.deskew);
  options.slam.loops.enabled = false;
  // The calibration is what is asked for, so it is doubted from the first frame on: poses that
  // follow a wrong camera hide its error from the tracks, and 0.9 deg to the side were called
  // 0.01 +- 0.06 deg.
  options.slam.extrinsics.doubt_significance = 1e-6;
  options.Check();
  TVL_CHECK_INPUT(options.slam.extrinsics.enabled && options.slam.use_camera)
      << arguments.config << ": the camera and extrinsics.enabled must be on to calibrate";
  return options;
}

RunResult Drive(const Dataset& dataset, const CalibrateArguments& arguments,
                const RunOptions& options, const char* pass) {
  const FrameRange range = ParseFrameRange(arguments.frames, dataset.size());
  DatasetSource source(dataset, range.begin, range.end);
  Progress progress(std::cerr, StderrIsTerminal(), "frames", range.end - range.begin);
  size_t done = 0;
  RunResult result = RunSlam(source, options, [&](const FrameResult&) {
    progress.Update(++done, pass);
    return !Interrupted();
  });
  if (result.failure) std::rethrow_exception(result.failure);
  TVL_CHECK_INPUT(!result.stopped) << "interrupted: nothing was written";
  return result;
}

// The whole error of the rotation against the calibration given, and what is known of it.
ExtrinsicEstimate AgainstGiven(const ExtrinsicEstimate& last, const Rigid3d& T_cam_lidar,
                               const Rigid3d& T_cam_lidar_given) {
  ExtrinsicEstimate estimate = last;
  const Eigen::Quaterniond applied = (T_cam_lidar * T_cam_lidar_given.Inverse()).q();
  estimate.applied_rad = LogSo3(applied);
  estimate.rotation_rad =
      LogSo3(ExpSo3(last.rotation_rad) * ExpSo3(last.applied_rad).conjugate() * applied);
  return estimate;
}

// With the camera where the drive says it sits, where that is significant. All cameras sit on one
// frame.
Calibration WithPlace(Calibration calibration, const CameraOffsetEstimate& offset) {
  constexpr double kSignificance = 3.0;
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double place_m = offset.translation_m[axis];
    const double least_m = kSignificance * offset.translation_sigma_m[axis];
    if (IsPlaceObserved(offset, axis) && std::abs(place_m) > least_m) moved_m[axis] = place_m;
  }
  const Rigid3d T_cam0_cam = calibration.T_cam0_lidar * calibration.T_cam_lidar.Inverse();
  calibration.T_cam_lidar =
      Rigid3d(Eigen::Quaterniond::Identity(), moved_m) * calibration.T_cam_lidar;
  calibration.T_cam0_lidar = T_cam0_cam * calibration.T_cam_lidar;
  return calibration;
}

void WriteCalibration(const std::string& input, const std::string& out,
                      const Calibration& calibration) {
  const bool is_simulated = input.rfind("sim:", 0) == 0;
  if (is_simulated) {
    WriteOdometryCalibration(out, KittiCalibrationOf(calibration));
    return;
  }
  if (!LooksLikeKitti(input)) {
    Rig rig;
    rig.camera = calibration.camera;
    rig.T_cam_lidar = calibration.T_cam_lidar;
    WriteAtomically(out, [&](std::ostream& file) { file << DumpRig(rig); });
    return;
  }
  const KittiLayout layout = FindKittiLayout(input);
  KittiCalibration kitti = layout.calibration;
  kitti.T_cam0_lidar = calibration.T_cam0_lidar;
  if (layout.is_raw) {
    WriteRawExtrinsics(out, kitti);
  } else {
    WriteOdometryCalibration(out, kitti);
  }
}

void Calibrate(const CalibrateArguments& arguments) {
  CatchInterrupts();
  cv::setNumThreads(arguments.threads);
  const RunOptions options = MakeOptions(arguments);
  InputOptions input_options = arguments.input_options;
  input_options.first_frame = FirstFrame(arguments.frames);
  const std::shared_ptr<const Dataset> dataset = OpenInput(arguments.input, input_options);
  TVL_CHECK_INPUT(dataset->setup().has_camera)
      << arguments.input << ": no images: there is no camera to calibrate";
  for (const std::string& warning : dataset->setup().warnings) {
    std::cerr << "tvl: warning: " << warning << "\n";
  }
  RunResult result = Drive(*dataset, arguments, options, "first pass");
  if (result.extrinsics.applied_rad.norm() > kSecondPass_rad) {
    SensorSetup setup = dataset->setup();
    setup.calibration = result.calibration;
    setup.calibration.rotation_covariance.setZero();
    result = Drive(ReconfiguredDataset(dataset, setup), arguments, options, "second pass");
  }
  const ExtrinsicEstimate estimate = AgainstGiven(result.extrinsics, result.calibration.T_cam_lidar,
                                                  dataset->setup().calibration.T_cam_lidar);
  const double prior_rad = options.slam.extrinsics.prior_rad;
  TVL_CHECK_INPUT(IsObserved(estimate, 0, prior_rad) || IsObserved(estimate, 1, prior_rad))
      << arguments.input
      << ": where the camera points cannot be told from this drive: " << estimate.windows
      << " stretches of way could be compared and outlines in " << estimate.edge_images
      << " images; it takes some ten metres of way through a scene with "
      << "upright things, in daylight";
  const Calibration found = WithPlace(result.calibration, estimate.offset);
  WriteCalibration(arguments.input, arguments.out, found);
  const double moved_m = (found.T_cam_lidar.t() - result.calibration.T_cam_lidar.t()).norm();
  std::cout << CalibrationText(estimate, prior_rad);
  if (moved_m > 0.0) std::cout << "moved by " << std::setprecision(3) << moved_m << " m\n";
  std::cout << "written to " << arguments.out << "\n";
}

}  // namespace

void AddCalibrateCommand(CLI::App& app) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* calibrate =
      app.add_subcommand("calibrate", "Where the camera points, found from a drive");
  calibrate
      ->add_option("input", arguments->input,
                   "sequence folder (KITTI odometry or raw layout) with images, or "
                   "sim:PRESET?seed=7&frames=200; some ten metres of way, better a hundred")
      ->required();
  calibrate
      ->add_option("--out", arguments->out,
                   "file to write: calib.txt (P0..P3, Tr) in the odometry layout, "
                   "calib_velo_to_cam.txt (R, T) for a raw drive, else a rig.yaml for --rig")
      ->required();
  calibrate->add_option("--config", arguments->config, "YAML file with options");
  AddInputOptions(calibrate, &arguments->input_options);
  calibrate->add_option("--deskew", arguments->deskew, "as in tvl run")
      ->check(CLI::IsMember({"auto", "none", "cw", "ccw"}))
      ->capture_default_str();
  calibrate->add_option("--threads", arguments->threads, "threads to work with")
      ->check(CLI::PositiveNumber)
      ->default_str("all cores");
  calibrate->add_option("--frames", arguments->frames, "A:B: frames A to B-1 only");
  calibrate->callback([arguments] { Calibrate(*arguments); });
}

}  // namespace tvl
