// Finds data that was delivered before: a driver that hands out its last buffer again, a scan
// listed for each of several images, an image that has frozen. Such data says nothing of the
// present.
#pragma once

#include <cstdint>

#include "tvl/sensor/sensor_frame.h"

namespace tvl {

// A number that differs between any two measurements of a real sensor, whose noise never repeats
// itself. 0 for no data.
uint64_t Fingerprint(const LidarScan& scan);
uint64_t Fingerprint(const cv::Mat& image);

struct Repetition {
  bool scan = false, image = false;  // equal to the last one there was
};

// Remembers the last scan and image. A value.
class RepetitionCheck {
 public:
  Repetition Check(const SensorFrame& frame);

 private:
  uint64_t last_scan_ = 0, last_image_ = 0;
};

}  // namespace tvl
