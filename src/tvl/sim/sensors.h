// The sensors of the simulated vehicle.
#pragma once

#include "tvl/sensor/dataset.h"
#include "tvl/sim/lidar_sensor.h"
#include "tvl/sim/sim_options.h"

namespace tvl::sim {

// Sensors like those of KITTI odometry 00: HDL-64E (kitti profile) and camera 0, 1241 x 376; or a
// lidar of 16 or 32 beams in the same place. Only the HDL-64E needs a vertical correction, and none
// without errors (options.clean).
SensorSetup SensorsFor(const SimOptions& options);

// Firings, range and errors of that lidar: the same noise for any number of beams.
LidarSensorOptions LidarErrorsFor(const SimOptions& options);

}  // namespace tvl::sim
