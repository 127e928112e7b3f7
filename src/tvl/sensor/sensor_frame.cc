#include "tvl/sensor/sensor_frame.h"

namespace tvl {

const char* ToString(FrameFault::Kind kind) {
  switch (kind) {
    case FrameFault::Kind::kMissingScan:
      return "missing_scan";
    case FrameFault::Kind::kTruncatedScan:
      return "truncated_scan";
    case FrameFault::Kind::kEmptyScan:
      return "empty_scan";
    case FrameFault::Kind::kInvalidPoints:
      return "invalid_points";
    case FrameFault::Kind::kOddScan:
      return "odd_scan";
    case FrameFault::Kind::kMissingImage:
      return "missing_image";
    case FrameFault::Kind::kUnreadableImage:
      return "unreadable_image";
    case FrameFault::Kind::kBlackImage:
      return "black_image";
    case FrameFault::Kind::kWrongSizeImage:
      return "wrong_size_image";
    case FrameFault::Kind::kTimeNotIncreasing:
      return "time_not_increasing";
    case FrameFault::Kind::kIrregularTime:
      return "irregular_time";
    case FrameFault::Kind::kTimeGap:
      return "time_gap";
    case FrameFault::Kind::kRepeatedScan:
      return "repeated_scan";
    case FrameFault::Kind::kOddCalibration:
      return "odd_calibration";
    case FrameFault::Kind::kRepeatedImage:
      return "repeated_image";
  }
  return "unknown";
}

const FrameFault* FaultOfScan(const std::vector<FrameFault>& faults) {
  using Kind = FrameFault::Kind;
  for (const FrameFault& fault : faults) {
    if (fault.kind == Kind::kMissingScan || fault.kind == Kind::kTruncatedScan ||
        fault.kind == Kind::kEmptyScan || fault.kind == Kind::kOddScan) {
      return &fault;
    }
  }
  return nullptr;
}

}  // namespace tvl
