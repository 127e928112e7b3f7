// INPUT of the commands: a folder, or a simulated drive.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tvl/sensor/dataset.h"

namespace tvl {

struct InputOptions {
  // Built-in name or YAML file. Empty: what the input suggests, `kitti` for folders in a KITTI
  // layout; a simulated drive knows its own sensor.
  std::string profile;
  // KITTI folders: 0..3, or -1 for the lowest camera that has images.
  int camera = -1;
  // The frame the command begins with; its scan must be usable unless require_first_scan is off.
  size_t first_frame = 0;
  bool require_first_scan = true;
};

// `spec`: a folder in the KITTI odometry or raw layout, or `sim:PRESET?key=value&...`.
// Throws InputError naming what is wrong. Warnings are in setup().warnings.
std::unique_ptr<Dataset> OpenInput(const std::string& spec, const InputOptions& options = {});

}  // namespace tvl
