// How a recording stores its scans, found out from the points alone: which points lie on one ring,
// which ring is the topmost, and what units and times the numbers are in. Found once, from the
// first scans, and the same for the whole recording.
#pragma once

#include <string>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/lidar/point_times.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"
#include "tvl/sensor/raw_scan.h"

namespace tvl {

enum class ScanOrder {
  kRingNumbers,    // the points carry the number of their beam
  kOrganised,      // rows or columns of an organised cloud are the beams
  kRingAfterRing,  // stored one ring after the other
  kElevations,  // any order, such as firing after firing: the elevations of the beams stand apart
  kSlices,      // no beams, or none that can be told apart: slices of equal elevation
};
const char* ToString(ScanOrder order);

struct ScanLayout {
  ScanOrder order = ScanOrder::kRingAfterRing;
  LidarModel lidar;  // the profile that fits the scans, else with beams as measured
  // kRingNumbers: row of each ring number; kOrganised: of each line. -1: no points are expected.
  std::vector<int> row_of_line;
  bool lines_are_columns = false;  // kOrganised: the beams are the columns of the cloud
  bool lowest_first = false;       // kRingAfterRing
  double metres_per_unit = 1.0;    // 0.001 where coordinates are millimetres
  double intensity_per_unit = 1.0;
  PointTimes times = PointTimes::kNone;
  double s_per_time_unit = 1.0;
  bool is_clockwise = false;  // kFromOrder: azimuth falls with time, seen from above
  // Evidence: rms of the measured elevations against the profile's beams; 0 without a profile.
  double profile_rms_rad = 0.0;
  int measured_beams = 0;
  std::vector<std::string> notes;     // what was found, a sentence each
  std::vector<std::string> warnings;  // what does not fit
};

struct LayoutHints {
  // The sensor as the user names it; no name: not known. It is used even where it does not fit,
  // with a warning.
  LidarModel lidar;
  bool is_given_by_user = false;
  std::vector<LidarModel> profiles;  // to compare the beams with
  double period_s = 0.1;             // between scans, by the stamps
};

struct ScanSample {
  const RawScan* scan = nullptr;
  Timestamp stamp;
};

// `samples`: the first usable scans, three are enough. Throws InputError if none of them has a
// point.
ScanLayout RecogniseLayout(const std::vector<ScanSample>& samples, const LayoutHints& hints);

// A scan as the stages work with it: points with a return in metres, ring = row of layout.lidar
// (empty for kRingAfterRing and kSlices, whose rows are found in every scan anew), and times in
// seconds after `stamp` where there are any.
LidarScan ApplyLayout(const RawScan& scan, const ScanLayout& layout, Timestamp stamp);

}  // namespace tvl
