// Looks at an input as a whole: what is in there and what is wrong with it.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/sensor/dataset.h"

namespace tvl {

// Smallest, middle and largest of some counts; zero if there are none.
struct CountRange {
  size_t min = 0, median = 0, max = 0;
};

// Faults of one kind.
struct FaultSummary {
  size_t count = 0;
  std::vector<std::string> first;  // messages of the first few
};

struct InspectReport {
  size_t frames = 0, scans = 0, images = 0;  // all, with a usable scan, with a usable image
  double duration_s = 0.0;                   // from the first stamp to the last
  double rate_hz = 0.0;                      // from the median time between frames; 0 if one frame
  double longest_gap_s = 0.0;                // between neighbouring frames
  CountRange points;                         // a scan
  CountRange rings;                          // full azimuth turns a scan
  std::string image_format;                  // of the first image, e.g. "1242x375, 8 bit, colour"
  bool has_intensity = false, has_rings = false, has_time_offsets = false;
  double truth_length_m = 0.0;                 // 0: no truth
  std::map<std::string, FaultSummary> faults;  // by ToString(kind)

  // Something can be built on it: the first scan is usable, and most of the others.
  bool usable = false;
  std::string unusable_reason;
};

// Reads every frame.
InspectReport Inspect(const Dataset& dataset, const Executor& executor);

// For people.
void PrintReport(const Dataset& dataset, const InspectReport& report, std::ostream& out);

}  // namespace tvl
