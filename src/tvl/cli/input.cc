#include "tvl/cli/input.h"

#include "tvl/base/check.h"
#include "tvl/io/kitti_dataset.h"
#include "tvl/io/profile.h"
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
LayoutHints HintsOf(const InputOptions& options) {
  LayoutHints hints;
  if (!options.profile.empty()) {
    hints.lidar = LoadProfile(options.profile);
    hints.is_given_by_user = hints.lidar.rows() > 0;
    return hints;
  }
  hints.lidar = LoadProfile("kitti");
  for (const std::string& name : ProfileNames()) hints.profiles.push_back(LoadProfile(name));
  return hints;
}

}  // namespace

std::optional<Deskew> ParseDeskew(const std::string& text) {
  for (const Deskew deskew : {Deskew::kNone, Deskew::kClockwise, Deskew::kCounterClockwise}) {
    if (text == ToString(deskew)) return deskew;
  }
  return std::nullopt;
}

std::unique_ptr<Dataset> OpenInput(const std::string& spec, const InputOptions& options) {
  if (spec.rfind("sim:", 0) == 0) {
    std::unique_ptr<Dataset> simulation = OpenSimulation(spec);
    if (options.profile.empty()) return simulation;
    SensorSetup setup = simulation->setup();
    setup.lidar = LoadProfile(options.profile);
    return std::make_unique<ReconfiguredDataset>(std::move(simulation), std::move(setup));
  }
  KittiOptions kitti;
  kitti.recognise = HintsOf(options);
  kitti.camera = options.camera;
  kitti.first_frame = options.first_frame;
  kitti.require_first_scan = options.require_first_scan;
  return std::make_unique<KittiDataset>(spec, kitti.recognise->lidar, kitti);
}

}  // namespace tvl
