// tvl show: a picture of what one stage makes of one frame.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/input.h"
#include "tvl/io/atomic_file.h"
#include "tvl/lidar/deskew.h"
#include "tvl/report/depth_picture.h"
#include "tvl/report/features_picture.h"
#include "tvl/report/map_picture.h"
#include "tvl/report/segments_picture.h"
#include "tvl/report/tracks_picture.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {
namespace {

// Frames worked on before the shown one, so that tracks have a length and the motion is known.
constexpr size_t kLeadFrames = 5;
constexpr double kMapVoxel_m = 0.1;

struct ShowArguments {
  std::string input, out;
  InputOptions input_options;
  std::string stage = "tracks", deskew = "auto";
  size_t frame = 0;
};

const std::map<std::string, Deskew> kDeskewNames = {
    {"none", Deskew::kNone}, {"cw", Deskew::kClockwise}, {"ccw", Deskew::kCounterClockwise}};

std::optional<Deskew> GivenDeskew(const ShowArguments& arguments) {
  const auto given = kDeskewNames.find(arguments.deskew);
  if (given == kDeskewNames.end()) return std::nullopt;
  return given->second;
}

// What the user, else the input says; a few frames are too few to decide by.
Deskew ChooseDeskew(const ShowArguments& arguments, const SensorSetup& setup) {
  return GivenDeskew(arguments).value_or(setup.deskew.value_or(setup.default_deskew));
}

// The points of a frame at its stamp, as depth association got them.
std::vector<Eigen::Vector3f> PointsForDepth(const FrameTrace& trace) {
  const SegmentedScan& scan = trace.frame.scan;
  return DeskewPoints(scan.points, scan.time_offset_s, trace.motion.T_prev_cur,
                      trace.motion.period_s);
}

std::string Faults(const SensorFrame& frame) {
  std::string text;
  for (const FrameFault& fault : frame.faults) text += ": " + fault.message;
  return text;
}

cv::Mat DrawStage(const std::string& stage, const SensorFrame& frame, const FrameTrace& trace,
                  const SensorSetup& setup) {
  const PreprocessedFrame& data = trace.frame;
  if (stage == "tracks" || stage == "depth") {
    TVL_CHECK_INPUT(data.has_image)
        << "frame " << frame.id << " has no usable image" << Faults(frame);
  }
  if (stage == "tracks") return DrawTracks(frame.image, data.tracks);
  TVL_CHECK_INPUT(data.has_scan) << "frame " << frame.id << " has no usable scan" << Faults(frame);
  if (stage == "segments") return DrawSegments(data.scan);
  if (stage == "features") {
    return DrawFeatures(frame.image, data.features, data.tracks, data.depths, setup.calibration);
  }
  return DrawDepths(frame.image, data.tracks, data.depths, PointsForDepth(trace),
                    setup.calibration.camera, setup.calibration.T_cam_lidar);
}

cv::Mat DrawOneFrame(const ShowArguments& arguments, const Dataset& dataset) {
  const SlamOptions options;
  const Executor executor(1);
  SlamSystem system(dataset.setup(), ChooseDeskew(arguments, dataset.setup()), options);
  SensorFrame frame;
  FrameTrace trace;
  for (size_t k = arguments.frame - std::min(kLeadFrames, arguments.frame); k <= arguments.frame;
       ++k) {
    frame = dataset.Frame(k);
    system.ProcessFrame(frame, executor, &trace);
  }
  return DrawStage(arguments.stage, frame, trace, system.setup());
}

cv::Mat DrawMapUpTo(const ShowArguments& arguments, const Dataset& dataset) {
  DatasetSource source(dataset, 0, arguments.frame + 1);
  RunOptions options;
  options.deskew = GivenDeskew(arguments);
  const RunResult result = RunSlam(source, options, [](const FrameResult&) { return true; });
  std::vector<Eigen::Vector3d> driven;
  for (const StampedPose& pose : result.trajectory) driven.push_back(pose.T_world_lidar.t());
  return DrawMap(BuildMapCloud(result.map, kMapVoxel_m), driven);
}

void Show(const ShowArguments& arguments) {
  TVL_CHECK_INPUT(cv::haveImageWriter(arguments.out))
      << "--out " << arguments.out << ": want the name of a picture, such as tracks.png";
  InputOptions input = arguments.input_options;
  input.require_first_scan = false;
  const std::unique_ptr<Dataset> dataset = OpenInput(arguments.input, input);
  TVL_CHECK_INPUT(arguments.frame < dataset->size())
      << "--frame " << arguments.frame << ": " << arguments.input << " has frames 0 to "
      << dataset->size() - 1;
  const cv::Mat picture = arguments.stage == "map" ? DrawMapUpTo(arguments, *dataset)
                                                   : DrawOneFrame(arguments, *dataset);
  WriteAtomicallyByName(arguments.out, [&](const std::string& temporary) {
    TVL_CHECK_INPUT(cv::imwrite(temporary, picture)) << arguments.out << ": cannot be written";
  });
  std::cout << "wrote " << arguments.out << " (" << picture.cols << "x" << picture.rows << ")\n";
}

}  // namespace

void AddShowCommand(CLI::App& app) {
  auto* command = app.add_subcommand("show", "A picture of what a stage makes of a frame");
  const auto arguments = std::make_shared<ShowArguments>();
  command->add_option("input", arguments->input, "A folder, or sim:PRESET?key=value&...")
      ->required();
  command->add_option("--frame", arguments->frame, "Which frame, from 0; map: the last one used")
      ->required();
  command
      ->add_option("--stage", arguments->stage,
                   "tracks (paper Fig. 3), segments (4), features (5), depth (7) or map (13)")
      ->check(CLI::IsMember({"tracks", "segments", "features", "depth", "map"}))
      ->required();
  command->add_option("--out", arguments->out, "The picture, e.g. tracks.png")->required();
  AddInputOptions(command, &arguments->input_options);
  command->add_option("--deskew", arguments->deskew, "auto: what the input says, else its default")
      ->check(CLI::IsMember({"auto", "none", "cw", "ccw"}));
  command->callback([arguments] { Show(*arguments); });
}

}  // namespace tvl
