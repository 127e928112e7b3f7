// tvl run: the main job. Data in; trajectory, map and report out.
#include <oneapi/tbb/info.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
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
#include "tvl/cli/output_folder.h"
#include "tvl/cli/progress.h"
#include "tvl/cli/version.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/g2o.h"
#include "tvl/io/point_cloud_io.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/report/loop_picture.h"
#include "tvl/report/loop_report.h"
#include "tvl/report/map_picture.h"
#include "tvl/report/run_report.h"
#include "tvl/slam/options_io.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

constexpr double kMapVoxel_m = 0.1;  // of the exported map: finer than a beam's footprint at 60 m
constexpr size_t kPlaces = 3;        // drawn before and after (paper Fig. 14)

struct RunArguments {
  std::string input, out, config, deskew = "auto", frames;
  InputOptions input_options;
  int threads = tbb::info::default_concurrency();  // the cores this process may use
  bool no_loops = false, lidar_only = false;
};

RunOptions MakeOptions(const RunArguments& arguments) {
  RunOptions options;
  if (!arguments.config.empty()) options = LoadOptions(arguments.config);
  options.threads = arguments.threads;
  options.deskew = ParseDeskew(arguments.deskew);
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

void WritePicture(const fs::path& path, const cv::Mat& picture) {
  WriteAtomicallyByName(path.string(), [&](const std::string& temporary) {
    TVL_CHECK(cv::imwrite(temporary, picture)) << temporary << ": cannot be written";
  });
}

// The poses as if no loop had been closed, as KITTI has them.
std::vector<Rigid3d> OdometryPoses(const RunResult& result, const Rigid3d& T_cam0_lidar) {
  return ToKittiPoses(WorldTrajectory(result.odometry, WithoutLoops(result.map.keyframes)),
                      T_cam0_lidar);
}

void WriteLoops(const fs::path& out, const RunResult& result, const RunContext& context) {
  WriteAtomically((out / "loops.csv").string(),
                  [&](std::ostream& file) { file << LoopTable(result.loops, context.truth); });
  const PoseGraph graph = FinalGraph(result.loops);
  if (!graph.T_world.empty()) WriteG2o((out / "graph.g2o").string(), graph);
  WritePicture(out / "loops.png", DrawLoops(result.map.keyframes, result.loops));
  int place = 0;
  for (const size_t i : MostTelling(result.map.keyframes, result.loops, kPlaces)) {
    WritePicture(out / ("loop_place_" + std::to_string(++place) + ".png"),
                 DrawPlace(result.map, result.loops.records[i]));
  }
}

// Of the whole input, beside the results, for `tvl evaluate`.
void WriteTruth(const fs::path& out, const Dataset& dataset) {
  const std::vector<Rigid3d> T_first_cam0 = dataset.Truth_T_first_cam0();
  if (T_first_cam0.empty()) return;
  WriteKittiPoses((out / "truth_kitti.txt").string(), T_first_cam0);
}

// What took longest to find first.
void WriteResults(const fs::path& out, const RunResult& result, const RunContext& context) {
  const Trajectory& trajectory = result.trajectory;
  const Rigid3d& T_cam0_lidar = result.calibration.T_cam0_lidar;
  WriteKittiPoses((out / "trajectory_kitti.txt").string(), ToKittiPoses(trajectory, T_cam0_lidar));
  WriteKittiPoses((out / "odometry_kitti.txt").string(), OdometryPoses(result, T_cam0_lidar));
  WriteTumTrajectory((out / "trajectory_tum.txt").string(), trajectory);
  WriteAtomically((out / "resolved.yaml").string(),
                  [&](std::ostream& file) { file << context.options_yaml; });
  const nlohmann::json report = MakeRunReport(result, context);
  WriteAtomically((out / "run.json").string(),
                  [&](std::ostream& file) { file << report.dump(1) << "\n"; });
  if (!result.loops.times.empty()) WriteLoops(out, result, context);
  const MapCloud cloud = BuildMapCloud(result.map, kMapVoxel_m);
  WritePcd((out / "map.pcd").string(), cloud);
  WritePly((out / "map.ply").string(), cloud);
  std::vector<Eigen::Vector3d> p_world;
  for (const StampedPose& pose : trajectory) p_world.push_back(pose.T_world_lidar.t());
  WritePicture(out / "map.png", DrawMap(cloud, p_world));
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
  if (!result.loops.times.empty()) std::cout << LoopSummary(result.loops);
  if (!result.loops.times.empty() && !context.truth.empty()) {
    std::cout << ToText(EvaluateLoops(result.loops.records, context.truth));
  }
  if (!result.loop_fault.empty()) {
    std::cout << "the loop search ended early: " << result.loop_fault << "\n";
  }
  std::cout << ExtrinsicsText(result.extrinsics);
  if (faulty > 0) std::cout << faulty << " frames with faults, see run.json\n";
  if (predicted > 0) std::cout << predicted << " frames bridged by prediction\n";
  const std::string store_fault = result.map.store->fault();
  if (!store_fault.empty()) std::cout << store_fault << ": kept in memory\n";
  std::cout << TimingTable(result) << "results in " << out << "\n";
  if (result.stopped) {
    std::cout << (result.failure ? "ended early" : "interrupted")
              << ": the results are complete up to here"
              << (result.loops.times.empty() ? "\n" : ", without the second look for loops\n");
  }
}

// The keyframes' true poses; empty where the input does not know them.
std::vector<TrueKeyframe> TruthOf(const Dataset& dataset, const RunResult& result) {
  const std::vector<Rigid3d> T_first_cam0 = dataset.Truth_T_first_cam0();
  const Rigid3d& T_cam0_lidar = dataset.setup().calibration.T_cam0_lidar;
  std::vector<TrueKeyframe> truth;
  for (const Keyframe& keyframe : result.map.keyframes) {
    const auto frame = static_cast<size_t>(keyframe.frame);
    if (frame >= T_first_cam0.size()) return {};
    truth.push_back({keyframe.stamp, keyframe.path_m, T_first_cam0[frame] * T_cam0_lidar});
  }
  return truth;
}

RunResult RunWithProgress(const Dataset& dataset, const RunArguments& arguments,
                          const RunOptions& options) {
  const FrameRange range = ParseFrameRange(arguments.frames, dataset.size());
  DatasetSource source(dataset, range.begin, range.end);
  Progress progress(std::cerr, StderrIsTerminal(), "frames", range.end - range.begin);
  size_t done = 0;
  return RunSlam(
      source, options,
      [&](const FrameResult& frame) {
        for (const FrameFault& fault : frame.faults) {
          std::cerr << (StderrIsTerminal() ? "\r\033[K" : "") << "tvl: " << fault.message << "\n";
        }
        progress.Update(++done, ToString(frame.status));
        return !Interrupted();
      },
      [] { return !Interrupted(); });
}

void Run(const RunArguments& arguments) {
  const Stopwatch watch;
  CatchInterrupts();
  cv::setNumThreads(arguments.threads);
  const RunOptions options = MakeOptions(arguments);
  InputOptions input_options = arguments.input_options;
  input_options.first_frame = FirstFrame(arguments.frames);
  const std::unique_ptr<Dataset> dataset = OpenInput(arguments.input, input_options);
  PrepareOutputFolder(arguments.out);
  for (const std::string& warning : dataset->setup().warnings) {
    std::cerr << "tvl: warning: " << warning << "\n";
  }
  const RunResult result = RunWithProgress(*dataset, arguments, options);
  const RunContext context{
      Version(),         arguments.input,          dataset->setup(), DumpOptions(options),
      arguments.threads, 1e-3 * watch.ElapsedMs(), PeakMemory_mib(), TruthOf(*dataset, result)};
  RemoveOldResults(arguments.out);
  WriteTruth(arguments.out, *dataset);
  WriteResults(arguments.out, result, context);
  PrintSummary(result, context, arguments.out);
  if (result.failure) std::rethrow_exception(result.failure);
  if (result.loop_search_broke) {
    throw Error("the loop search ended early: " + result.loop_fault + "; results are in " +
                arguments.out);
  }
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* run = app.add_subcommand("run", "Run SLAM: trajectory, map and report into a folder");
  run->add_option("input", arguments->input, kInputHelp)->required();
  run->add_option(
         "--out", arguments->out,
         "folder for trajectory_kitti.txt, trajectory_tum.txt, odometry_kitti.txt "
         "(before loops correct it), map.pcd, map.ply, map.png, loops.csv, graph.g2o, loops.png, "
         "loop_place_*.png, run.json, resolved.yaml, and truth_kitti.txt where the truth is known; "
         "those of an earlier run are replaced")
      ->required();
  run->add_option("--config", arguments->config, "YAML file with options, see docs/options.md");
  AddInputOptions(run, &arguments->input_options);
  run->add_option("--deskew", arguments->deskew,
                  "spin of a raw scan seen from above, or none for compensated scans; auto: what "
                  "the input says, else decided from its first frames")
      ->check(CLI::IsMember({"auto", "none", "cw", "ccw"}))
      ->capture_default_str();
  run->add_option("--threads", arguments->threads, "threads to work with; never changes results")
      ->check(CLI::PositiveNumber)
      ->default_str("all cores");
  run->add_flag("--no-loops", arguments->no_loops, "odometry and local map only, no loops closed");
  run->add_flag("--lidar-only", arguments->lidar_only, "leave the camera out");
  run->add_option("--frames", arguments->frames, "A:B: frames A to B-1 only; either may be empty");
  run->callback([arguments] { Run(*arguments); });
}

}  // namespace tvl
