// What an input yields: one time-synchronised image and scan.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "tvl/base/ids.h"
#include "tvl/base/time.h"
#include "tvl/sensor/lidar_scan.h"

namespace tvl {

// Something wrong with the data of one frame. The frame is still delivered, without the bad part.
struct FrameFault {
  enum class Kind {
    kMissingScan,
    kTruncatedScan,  // fewer rings than the sensor has, or not a whole number of points
    kEmptyScan,
    kInvalidPoints,  // NaN, infinite or absurd numbers: dropped
    kOddScan,        // of another shape than the sensor's: its rings cannot be told
    kMissingImage,
    kUnreadableImage,
    kBlackImage,
    kWrongSizeImage,
    kTimeNotIncreasing,
    kIrregularTime,   // a stamp between two turns of the lidar: not believed
    kTimeGap,         // more than one turn after the frame before
    kRepeatedScan,    // equal to the scan before: left out
    kRepeatedImage,   // equal to an image before, though the scan is new: left out
    kOddCalibration,  // that cannot be meant for the images: inverted, or they were resized
  };
  Kind kind;
  std::string message;  // names the file or frame
};

// Short name of a fault, e.g. "truncated_scan": the key it is counted under in run.json.
const char* ToString(FrameFault::Kind kind);

// The fault for which a frame has no scan; null where none says so.
const FrameFault* FaultOfScan(const std::vector<FrameFault>& faults);

// A pose belongs to the instant of the stamp, and a compensated scan is compensated to it: the
// middle of the sweep. The image may have been taken at another time.
struct SensorFrame {
  FrameId id = 0;
  Timestamp stamp;
  std::shared_ptr<const LidarScan> scan;  // null: absent or unusable
  cv::Mat image;                          // empty: absent or unusable; 8 or 16 bit, 1 or 3 channels
  double image_delay_s = 0.0;  // from the stamp to the instant the image was taken, as recorded
  std::vector<FrameFault> faults;
};

}  // namespace tvl
