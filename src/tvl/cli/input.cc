#include "tvl/cli/input.h"

#include "tvl/base/check.h"
#include "tvl/io/kitti_dataset.h"
#include "tvl/io/profile.h"

#ifdef TVL_WITH_SIM
#include "tvl/sim/sim_dataset.h"
#endif

namespace tvl {
namespace {

// A dataset whose lidar is described by another profile than its own.
class ReprofiledDataset : public Dataset {
 public:
  ReprofiledDataset(std::unique_ptr<const Dataset> dataset, const LidarModel& lidar)
      : dataset_(std::move(dataset)), setup_(dataset_->setup()) {
    setup_.lidar = lidar;
  }
  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return dataset_->size(); }
  SensorFrame Frame(size_t index) const override { return dataset_->Frame(index); }
  Timestamp Stamp(size_t index) const override { return dataset_->Stamp(index); }
  std::vector<Rigid3d> Truth_T_first_cam0() const override {
    return dataset_->Truth_T_first_cam0();
  }

 private:
  std::unique_ptr<const Dataset> dataset_;
  SensorSetup setup_;
};

std::unique_ptr<Dataset> OpenSimulation(const std::string& spec) {
#ifdef TVL_WITH_SIM
  return sim::OpenSimulation(spec);
#else
  throw InputError(spec + ": this tvl was built without the simulator (Embree was not found)");
#endif
}

}  // namespace

std::unique_ptr<Dataset> OpenInput(const std::string& spec, const InputOptions& options) {
  if (spec.rfind("sim:", 0) == 0) {
    std::unique_ptr<Dataset> simulation = OpenSimulation(spec);
    if (options.profile.empty()) return simulation;
    return std::make_unique<ReprofiledDataset>(std::move(simulation), LoadProfile(options.profile));
  }
  const LidarModel lidar = LoadProfile(options.profile.empty() ? "kitti" : options.profile);
  KittiOptions kitti;
  kitti.camera = options.camera;
  kitti.first_frame = options.first_frame;
  kitti.require_first_scan = options.require_first_scan;
  return std::make_unique<KittiDataset>(spec, lidar, kitti);
}

}  // namespace tvl
