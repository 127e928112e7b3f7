// A simulated drive as a Dataset: the same frames as `tvl simulate` writes, without the disk.
#pragma once

#include <memory>
#include <string>

#include "tvl/sensor/dataset.h"
#include "tvl/sim/drive.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/sensors.h"
#include "tvl/sim/sim_options.h"

namespace tvl::sim {

// Frames are made when asked for, any one at a time. Const and thread-safe.
class SimDataset : public Dataset {
 public:
  // Plans the drive and builds the town. Throws InputError for bad options.
  explicit SimDataset(const SimOptions& options);
  ~SimDataset() override;

  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return static_cast<size_t>(drive_.frames); }
  SensorFrame Frame(size_t index) const override;
  Timestamp Stamp(size_t index) const override;
  std::vector<Rigid3d> Truth_T_first_cam0() const override;

  const SimOptions& options() const { return options_; }
  const Drive& drive() const { return drive_; }
  const Scene& scene() const;
  // Way from the first frame to the last.
  double Length_m() const;
  // True pose of the lidar in the world of the scene, at the stamp of a frame.
  Rigid3d Truth_T_world_lidar(size_t index) const;

 private:
  struct Sensors;
  SimOptions options_;
  SensorSetup setup_;
  Drive drive_;
  std::unique_ptr<const Sensors> sensors_;
};

// From "sim:PRESET?key=value&...", see ParseSimUri.
std::unique_ptr<Dataset> OpenSimulation(const std::string& uri);

}  // namespace tvl::sim
