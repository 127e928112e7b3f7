#include "tvl/cli/input.h"

#include "tvl/base/check.h"
#include "tvl/io/kitti_dataset.h"
#include "tvl/io/profile.h"

namespace tvl {
namespace {

std::unique_ptr<Dataset> OpenSimulation(const std::string& spec) {
  throw InputError(spec + ": this tvl was built without the simulator (Embree was not found)");
}

}  // namespace

std::unique_ptr<Dataset> OpenInput(const std::string& spec, const InputOptions& options) {
  if (spec.rfind("sim:", 0) == 0) return OpenSimulation(spec);
  const LidarModel lidar = LoadProfile(options.profile.empty() ? "kitti" : options.profile);
  KittiOptions kitti;
  kitti.camera = options.camera;
  kitti.first_frame = options.first_frame;
  kitti.require_first_scan = options.require_first_scan;
  return std::make_unique<KittiDataset>(spec, lidar, kitti);
}

}  // namespace tvl
