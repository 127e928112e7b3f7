// What a source may hand on and no later stage could work with is taken out of a frame.
#pragma once

#include "tvl/sensor/dataset.h"
#include "tvl/sensor/sensor_frame.h"

namespace tvl {

// The frame without points that are not finite, lie beyond 10 km or were measured at another time
// than the sweep; without a scan whose arrays differ in length; and without an image of another
// size or kind than the camera's. Each is added to the faults.
SensorFrame WithoutOddData(SensorFrame frame, const SensorSetup& setup);

}  // namespace tvl
