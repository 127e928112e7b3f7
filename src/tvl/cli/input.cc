#include "tvl/cli/input.h"

#include <filesystem>

#include "tvl/base/check.h"
#include "tvl/io/cloud/cloud_folder.h"
#include "tvl/io/kitti/kitti_360.h"
#include "tvl/io/kitti/kitti_object.h"
#include "tvl/io/kitti_dataset.h"
#include "tvl/io/profile.h"
#include "tvl/io/recorded_dataset.h"
#include "tvl/io/rig.h"
#include "tvl/io/ros/bag_recording.h"
#include "tvl/slam/deskew_decision.h"

#ifdef TVL_WITH_SIM
#include "tvl/sim/sim_dataset.h"
#endif

namespace tvl {
namespace {

std::unique_ptr<Dataset> OpenSimulation(const std::string& spec) {
#ifdef TVL_WITH_SIM
  return sim::OpenSimulation(spec);
#else
  throw InputError(spec + ": this tvl was built without the simulator (Embree was not found)");
#endif
}

// What the user says of the lidar, or the profiles to choose from.
LayoutHints HintsOf(const InputOptions& options, const Rig& rig) {
  LayoutHints hints;
  if (rig.lidar || !options.profile.empty()) {
    hints.lidar = rig.lidar ? *rig.lidar : LoadProfile(options.profile);
    hints.is_given_by_user = hints.lidar.rows() > 0;
    return hints;
  }
  hints.lidar = LoadProfile("kitti");
  for (const std::string& name : ProfileNames()) hints.profiles.push_back(LoadProfile(name));
  return hints;
}

// What is not in one of the layouts that KittiDataset reads; empty if nothing is recognised.
std::optional<Recording> OpenRecording(const std::string& spec, const BagOptions& topics) {
  if (LooksLikeKitti(spec)) return std::nullopt;
  if (LooksLikeBag(spec)) return OpenBag(spec, topics);
  if (LooksLikeKitti360(spec)) return OpenKitti360(spec);
  if (LooksLikeKittiObject(spec)) return OpenKittiObject(spec);
  if (LooksLikeCloudFolder(spec)) return OpenCloudFolder(spec);
  return std::nullopt;
}

// What is there, but nothing that any reader knows.
void CheckIsKitti(const std::string& spec) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path path(spec);
  TVL_CHECK_INPUT(!fs::exists(path, ignored) || fs::is_directory(path / "velodyne", ignored) ||
                  fs::is_directory(path / "velodyne_points", ignored))
      << spec << ": no recording that tvl knows: neither scans (.bin, .pcd, .ply, .las) nor a bag "
      << "(.bag, .db3, .mcap) nor a KITTI layout; see docs/inputs.md";
}

// The topics asked for: on the command line, else by the rig.
BagOptions TopicsOf(const InputOptions& options, const Rig& rig) {
  return {options.lidar_topic.empty() ? rig.lidar_topic : options.lidar_topic,
          options.image_topic.empty() ? rig.image_topic : options.image_topic};
}

std::unique_ptr<Dataset> OpenKitti(const std::string& spec, const InputOptions& options,
                                   const Rig& rig) {
  CheckIsKitti(spec);
  KittiOptions kitti;
  kitti.recognise = HintsOf(options, rig);
  kitti.camera = options.camera;
  kitti.first_frame = options.first_frame;
  kitti.require_first_scan = options.require_first_scan;
  auto dataset = std::make_unique<KittiDataset>(spec, kitti.recognise->lidar, kitti);
  if (!rig.camera && !rig.T_cam_lidar) return dataset;
  SensorSetup setup = dataset->setup();
  if (rig.camera) setup.calibration.camera = *rig.camera;
  if (rig.T_cam_lidar) setup.calibration.T_cam_lidar = *rig.T_cam_lidar;
  return std::make_unique<ReconfiguredDataset>(std::move(dataset), std::move(setup));
}

}  // namespace

std::optional<Deskew> ParseDeskew(const std::string& text) {
  for (const Deskew deskew : {Deskew::kNone, Deskew::kClockwise, Deskew::kCounterClockwise}) {
    if (text == ToString(deskew)) return deskew;
  }
  return std::nullopt;
}

void AddInputOptions(CLI::App* command, InputOptions* options) {
  std::string names;
  for (const std::string& name : ProfileNames()) names += (names.empty() ? "" : ", ") + name;
  command->add_option(
      "--profile", options->profile,
      "lidar: a built-in profile (" + names +
          ") or a YAML file; default: the one that fits the scans, else as measured");
  command->add_option("--rig", options->rig,
                      "YAML file with intrinsics, extrinsics, lidar and topics that the recording "
                      "does not tell, see docs/inputs.md; tvl inspect --write-rig begins one");
  command->add_option("--lidar-topic", options->lidar_topic,
                      "topic of the scans, where a bag has several");
  command->add_option("--image-topic", options->image_topic,
                      "topic of the images, where a bag has several");
}

std::unique_ptr<Dataset> OpenInput(const std::string& spec, const InputOptions& options) {
  if (spec.rfind("sim:", 0) == 0) {
    std::unique_ptr<Dataset> simulation = OpenSimulation(spec);
    if (options.profile.empty()) return simulation;
    SensorSetup setup = simulation->setup();
    setup.lidar = LoadProfile(options.profile);
    return std::make_unique<ReconfiguredDataset>(std::move(simulation), std::move(setup));
  }
  TVL_CHECK_INPUT(options.rig.empty() || options.profile.empty())
      << "--rig and --profile: the rig may say what the profile does, give one of them";
  const Rig rig = options.rig.empty() ? Rig() : LoadRig(options.rig);
  std::optional<Recording> recording = OpenRecording(spec, TopicsOf(options, rig));
  if (!recording) return OpenKitti(spec, options, rig);
  if (rig.camera) recording->camera = rig.camera;
  if (rig.T_cam_lidar) recording->T_cam_lidar = rig.T_cam_lidar;
  RecordedOptions recorded;
  recorded.hints = HintsOf(options, rig);
  recorded.first_frame = options.first_frame;
  recorded.require_first_scan = options.require_first_scan;
  return std::make_unique<RecordedDataset>(std::move(*recording), recorded);
}

}  // namespace tvl
