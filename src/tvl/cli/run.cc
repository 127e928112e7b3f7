// tvl run: the main job. Data in; trajectory, map and report out.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/frame_range.h"
#include "tvl/cli/input.h"
#include "tvl/cli/interrupt.h"
#include "tvl/cli/progress.h"
#include "tvl/cli/version.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/point_cloud_io.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/report/map_picture.h"
#include "tvl/report/run_report.h"
#include "tvl/slam/options_io.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

constexpr double kMapVoxel_m = 0.1;  // of the exported map: finer than a beam's footprint at 60 m

struct RunArguments {
  std::string input, out, config, profile, deskew = "auto", frames;
  int threads = 1;
  bool no_loops = false, lidar_only = false;
};

std::optional<Deskew> ParseDeskew(const std::string& text) {
  for (const Deskew deskew : {Deskew::kNone, Deskew::kClockwise, Deskew::kCounterClockwise}) {
    if (text == ToString(deskew)) return deskew;
  }
  return std::nullopt;  // auto; the command line has refused anything else
}

RunOptions MakeOptions(const RunArguments& arguments) {
  RunOptions options;
  if (!arguments.config.empty()) options = LoadOptions(arguments.config);
  options.threads = arguments.threads;
  if (arguments.deskew != "auto") options.deskew = ParseDeskew(arguments.deskew);
  if (arguments.lidar_only) options.slam.use_camera = false;
  if (arguments.no_loops) options.slam.loops.enabled = false;
  options.Check();
  return options;
}

double PeakMemory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void WriteResults(const fs::path& out, const RunResult& result, const RunContext& context) {
  const Trajectory& trajectory = result.trajectory;
  WriteKittiPoses((out / "trajectory_kitti.txt").string(),
                  ToKittiPoses(trajectory, context.setup.calibration.T_cam0_lidar));
  WriteTumTrajectory((out / "trajectory_tum.txt").string(), trajectory);
  const MapCloud cloud = BuildMapCloud(result.map, kMapVoxel_m);
  WritePcd((out / "map.pcd").string(), cloud);
  WritePly((out / "map.ply").string(), cloud);
  std::vector<Eigen::Vector3d> p_world;
  for (const StampedPose& pose : trajectory) p_world.push_back(pose.T_world_lidar.t());
  const cv::Mat picture = DrawMap(cloud, p_world);
  WriteAtomicallyByName((out / "map.png").string(), [&](const std::string& temporary) {
    TVL_CHECK(cv::imwrite(temporary, picture)) << temporary << ": cannot be written";
  });
  WriteAtomically((out / "resolved.yaml").string(),
                  [&](std::ostream& file) { file << context.options_yaml; });
  const nlohmann::json report = MakeRunReport(result, context);
  WriteAtomically((out / "run.json").string(),
                  [&](std::ostream& file) { file << report.dump(1) << "\n"; });
}

void PrintSummary(const RunResult& result, const RunContext& context, const std::string& out) {
  const auto count = [&](auto predicate) {
    return std::count_if(result.frames.begin(), result.frames.end(), predicate);
  };
  const auto predicted =
      count([](const FrameResult& f) { return f.status == FrameStatus::kPredicted; });
  const auto faulty = count([](const FrameResult& f) { return !f.faults.empty(); });
  std::cout << result.frames.size() << " frames, " << result.map.keyframes.size() << " keyframes, "
            << context.wall_s << " s, peak memory " << context.peak_memory_mib << " MiB\n"
            << "motion compensation: " << ToString(result.deskew.deskew) << " ("
            << ToString(result.deskew.verdict) << ": " << result.deskew.reason << ")\n";
  if (faulty > 0) std::cout << faulty << " frames with faults, see run.json\n";
  if (predicted > 0) std::cout << predicted << " frames bridged by prediction\n";
  std::cout << TimingTable(result) << "results in " << out << "\n";
  if (result.stopped) std::cout << "interrupted: the results are complete up to here\n";
}

RunResult RunWithProgress(const Dataset& dataset, const RunArguments& arguments,
                          const RunOptions& options) {
  const FrameRange range = ParseFrameRange(arguments.frames, dataset.size());
  DatasetSource source(dataset, range.begin, range.end);
  Progress progress(std::cerr, StderrIsTerminal(), "frames", range.end - range.begin);
  size_t done = 0;
  return RunSlam(source, options, [&](const FrameResult& frame) {
    for (const FrameFault& fault : frame.faults) {
      std::cerr << (StderrIsTerminal() ? "\r\033[K" : "") << "tvl: " << fault.message << "\n";
    }
    progress.Update(++done, ToString(frame.status));
    return !Interrupted();
  });
}

void Run(const RunArguments& arguments) {
  const Stopwatch watch;
  CatchInterrupts();
  cv::setNumThreads(arguments.threads);
  const RunOptions options = MakeOptions(arguments);
  InputOptions input_options;
  input_options.profile = arguments.profile;
  input_options.first_frame = FirstFrame(arguments.frames);
  const std::unique_ptr<Dataset> dataset = OpenInput(arguments.input, input_options);
  if (!dataset->setup().has_camera && options.slam.use_camera) {
    std::cerr << "tvl: " << arguments.input << ": no images: running lidar-only\n";
  }
  fs::create_directories(arguments.out);
  const RunResult result = RunWithProgress(*dataset, arguments, options);
  const RunContext context{
      Version(),         arguments.input,          dataset->setup(), DumpOptions(options),
      arguments.threads, 1e-3 * watch.ElapsedMs(), PeakMemory_mib()};
  WriteResults(arguments.out, result, context);
  PrintSummary(result, context, arguments.out);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* run = app.add_subcommand("run", "Run SLAM: trajectory, map and report into a folder");
  run->add_option(
         "input", arguments->input,
         "sequence folder (KITTI odometry or raw layout), or sim:PRESET?seed=7&frames=1000")
      ->required();
  run->add_option("--out", arguments->out,
                  "folder for trajectory_kitti.txt, trajectory_tum.txt, map.pcd, map.ply, map.png, "
                  "run.json, resolved.yaml")
      ->required();
  run->add_option("--config", arguments->config, "YAML file with options, see docs/options.md");
  run->add_option("--profile", arguments->profile,
                  "lidar: a built-in profile (kitti, none) or a YAML file; default: what the "
                  "input suggests");
  run->add_option("--deskew", arguments->deskew,
                  "spin of a raw scan seen from above, or none for compensated scans; auto: what "
                  "the input says, else decided from its first frames")
      ->check(CLI::IsMember({"auto", "none", "cw", "ccw"}))
      ->capture_default_str();
  run->add_option("--threads", arguments->threads, "threads to work with; never changes results")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  run->add_flag("--no-loops", arguments->no_loops, "odometry and local map only, no loops closed");
  run->add_flag("--lidar-only", arguments->lidar_only, "leave the camera out");
  run->add_option("--frames", arguments->frames, "A:B: frames A to B-1 only; either may be empty");
  run->callback([arguments] { Run(*arguments); });
}

}  // namespace tvl
