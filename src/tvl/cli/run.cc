// tvl run: the main job. Data in; trajectory, map and report out.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/input.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {
namespace {

struct RunArguments {
  std::string input, out, config, profile, deskew = "auto", frames;
  int threads = 1;
  bool no_loops = false, lidar_only = false;
};

std::optional<Deskew> ParseDeskew(const std::string& text) {
  if (text == "none") return Deskew::kNone;
  if (text == "cw") return Deskew::kClockwise;
  if (text == "ccw") return Deskew::kCounterClockwise;
  return std::nullopt;
}

void Run(const RunArguments& arguments) {
  cv::setNumThreads(arguments.threads);
  InputOptions input_options;
  input_options.profile = arguments.profile;
  const std::unique_ptr<Dataset> dataset = OpenInput(arguments.input, input_options);
  RunOptions options;
  options.threads = arguments.threads;
  options.deskew = ParseDeskew(arguments.deskew);
  options.slam.use_camera = !arguments.lidar_only;
  std::filesystem::create_directories(arguments.out);
  DatasetSource source(*dataset);
  const RunResult result = RunSlam(source, options, [](const FrameResult& frame) {
    std::cout << frame.id << " " << frame.T_world_lidar.t().transpose() << " odo "
              << frame.odometry.T_ref_body.t().transpose() << " p "
              << frame.odometry.evidence.planes << " e " << frame.odometry.evidence.edges << " v "
              << frame.odometry.evidence.visual << " it " << frame.odometry.evidence.iterations
              << " map p " << frame.map_step.estimate.evidence.planes << " e "
              << frame.map_step.estimate.evidence.edges << " v "
              << frame.map_step.estimate.evidence.visual << " it "
              << frame.map_step.estimate.evidence.iterations << " rms "
              << frame.map_step.estimate.evidence.plane_rms_m << " ratio "
              << frame.map_step.translation_ratio << " " << frame.map_step.rotation_ratio
              << " ms vis " << frame.times.vision_ms << " seg " << frame.times.segmentation_ms
              << " feat " << frame.times.features_ms << " dep " << frame.times.depth_ms << " odo "
              << frame.times.odometry_ms << " map " << frame.times.map_step_ms << " upd "
              << frame.times.map_update_ms << "\n";
    return true;
  });
  Trajectory trajectory;
  for (const FrameResult& f : result.frames) {
    trajectory.push_back({f.id, f.stamp, f.T_world_lidar});
  }
  WriteKittiPoses(arguments.out + "/trajectory_kitti.txt",
                  ToKittiPoses(trajectory, dataset->setup().calibration.T_cam0_lidar));
  WriteTumTrajectory(arguments.out + "/trajectory_tum.txt", trajectory);
  std::cout << "deskew " << ToString(result.deskew.deskew) << " " << ToString(result.deskew.verdict)
            << " " << result.deskew.reason << "\n";
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* run = app.add_subcommand("run", "Run SLAM: trajectory, map and report into a folder");
  run->add_option("input", arguments->input, "folder or sim:PRESET?...")->required();
  run->add_option("--out", arguments->out, "folder for the results")->required();
  run->add_option("--profile", arguments->profile, "lidar profile");
  run->add_option("--deskew", arguments->deskew, "auto|none|cw|ccw");
  run->add_option("--threads", arguments->threads, "threads");
  run->add_flag("--lidar-only", arguments->lidar_only, "do not use the camera");
  run->callback([arguments] { Run(*arguments); });
}

}  // namespace tvl
