// Which beams a scan's rings belong to, where some are missing.
#pragma once

#include <vector>

namespace tvl {

// Where a ring's points lie: a typical one of them, by its horizontal distance and height.
struct RingProfile {
  double distance_m = 0.0, height_m = 0.0;
};

// Rows, in rising order, that rings (topmost first) belong to. Rows may stay empty; where there are
// more rings than beams some share a row.
struct RingAlignment {
  std::vector<int> row;  // one a ring
  double offset_rad = 0.0;
  double origin_height_m = 0.0;
  double rms_rad = 0.0;
};

// By the beams' nominal elevations. Allowed for are a common offset of the elevation and a common
// height of the beams' origin over the sensor's: in KITTI's scans beams start 0.20 m (upper block)
// and 0.12 m (lower block) above the origin, so that a ring seen at 5 m appears 2 deg too high. The
// smallest of both that fit are taken. Rings are missing at one end only: at the lower one (the
// file was cut off) or, if the lowest ring looks about as far down as the lowest beam, at the upper
// one (upper beams looked at the sky), whichever fits better.
RingAlignment AlignRingsToBeams(const std::vector<RingProfile>& rings,
                                const std::vector<double>& beam_elevation_rad);

// By the rings of another scan of the same sensor, one a row, of which none was missing: real beams
// are off their nominal elevations by more than their distance from each other. Rings may be
// missing at either end.
RingAlignment AlignRingsToScan(const std::vector<RingProfile>& rings,
                               const std::vector<RingProfile>& complete);

}  // namespace tvl
