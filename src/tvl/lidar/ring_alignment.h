// Which beams a scan's rings belong to, where some are missing.
#pragma once

#include <vector>

namespace tvl {

// Where a ring's points lie: a typical one of them, by its horizontal distance and height.
struct RingProfile {
  double distance_m = 0.0, height_m = 0.0;
};

// Rows, in rising order, that rings (topmost first) belong to, given the beams' elevations. Rows
// may stay empty; where there are more rings than beams some share a row. Allowed for are a common
// offset of the elevation and a common height of the beams' origin over the sensor's: in KITTI's
// scans beams start 0.20 m (upper block) and 0.12 m (lower block) above the origin, so that a ring
// seen at 5 m appears 2 deg too high. The smallest of both that fit are taken, and
// as few empty rows before the last ring as possible: files are cut off at their end.
struct RingAlignment {
  std::vector<int> row;  // one a ring
  double offset_rad = 0.0;
  double origin_height_m = 0.0;
  double rms_rad = 0.0;
};
RingAlignment AlignRingsToBeams(const std::vector<RingProfile>& rings,
                                const std::vector<double>& beam_elevation_rad);

}  // namespace tvl
