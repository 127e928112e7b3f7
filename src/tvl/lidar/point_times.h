// What the times of a scan's points mean: their unit, and what they are counted from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/sensor/raw_scan.h"

namespace tvl {

enum class PointTimes {
  kNone,        // not given and not to be had from the order
  kAfterStamp,  // a field, counted from the scan's stamp (negative: before it)
  kAbsolute,    // a field, counted as the stamps are
  kOwnClock,    // a field, counted from elsewhere: its earliest value is taken to be the stamp
  kFromOrder,   // points are stored as measured: azimuth tells when within the sweep
};

struct PointTimeMeaning {
  PointTimes times = PointTimes::kNone;
  double s_per_unit = 1.0;
  std::string text;  // a sentence: what was found, or why the field is not used
};

// From the field `time` of the scans and their stamps. A scan takes 5 ms to 0.6 s, which tells
// seconds from milli-, micro- and nanoseconds.
PointTimeMeaning RecogniseTimes(const std::vector<const RawScan*>& scans,
                                const std::vector<Timestamp>& stamps, float min_range);

}  // namespace tvl
