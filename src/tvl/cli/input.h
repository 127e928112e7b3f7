// INPUT of the commands: a folder, or a simulated drive.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tvl/sensor/dataset.h"

namespace tvl {

struct InputOptions {
  // Built-in name or YAML file. Empty: what the input suggests, `kitti` for folders in a KITTI
  // layout; a simulated drive knows its own sensor.
  std::string profile;
  // KITTI folders: 0..3, or -1 for the lowest camera that has images.
  int camera = -1;
  // A rig.yaml (io/rig.h): what the recording does not say, or says wrongly. Empty: none.
  std::string rig;
  // Bags: topics of the scans and the images. Empty: found by their types.
  std::string lidar_topic, image_topic;
  // The frame the command begins with; its scan must be usable unless require_first_scan is off.
  size_t first_frame = 0;
  bool require_first_scan = true;
};

// A dataset whose sensors are described by another setup than its own.
class ReconfiguredDataset : public Dataset {
 public:
  ReconfiguredDataset(std::shared_ptr<const Dataset> dataset, SensorSetup setup)
      : dataset_(std::move(dataset)), setup_(std::move(setup)) {}
  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return dataset_->size(); }
  SensorFrame Frame(size_t index) const override { return dataset_->Frame(index); }
  Timestamp Stamp(size_t index) const override { return dataset_->Stamp(index); }
  std::vector<Rigid3d> Truth_T_first_cam0() const override {
    return dataset_->Truth_T_first_cam0();
  }

 private:
  std::shared_ptr<const Dataset> dataset_;
  SensorSetup setup_;
};

// What --deskew says; empty for auto. The command line has refused anything else.
std::optional<Deskew> ParseDeskew(const std::string& text);

// Adds --profile, --rig, --lidar-topic and --image-topic to a command; `options` must outlive it.
void AddInputOptions(CLI::App* command, InputOptions* options);

// INPUT in the help of the commands.
inline constexpr const char* kInputHelp =
    "recording: a folder of scans (KITTI layouts, .bin, .pcd, .ply, .las), a ROS bag (.bag, .db3, "
    ".mcap), see docs/inputs.md; or sim:PRESET?seed=7&frames=1000";

// `spec`: see kInputHelp.
// Throws InputError naming what is wrong. Warnings are in setup().warnings.
std::unique_ptr<Dataset> OpenInput(const std::string& spec, const InputOptions& options = {});

}  // namespace tvl
