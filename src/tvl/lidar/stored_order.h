// What the order of a scan's points tells: whether they are stored ring after ring, or as a
// spinning lidar measures them, one firing after the other.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/sensor/raw_scan.h"

namespace tvl {

// A file stored ring after ring goes from the top of the field of view to the bottom (or back) once
// in all, and does so only where a ring ends and the next begins. The changes of elevation from
// each point to the next, summed by azimuth, therefore add up to the whole field of view at that
// azimuth, and to nothing elsewhere.
struct RingBreak {
  double azimuth_rad = 0.0;  // where rings begin
  bool lowest_first = false;
  // Of the field of view: what is passed there, near 1, and the most that is passed within 5 deg
  // elsewhere, near 0. In another order neither is so.
  double share = 0.0, share_elsewhere = 1.0;
};

// Points nearer than `min_range` (in the unit of the scan) are left out.
RingBreak FindRingBreak(const RawScan& scan, float min_range);

// Turns of the azimuth from the first point to the last, positive counter-clockwise, where it goes
// round evenly: about 1 for a sweep in the order it was measured. 0 where it does not.
double StoredTurns(const RawScan& scan, float min_range);

// Seconds from the middle of the sweep to the instant each of the points `kept` (indices,
// increasing) was measured, by its azimuth. For scans stored as they were measured.
std::vector<float> TimesFromOrder(const RawScan& scan, const std::vector<uint32_t>& kept,
                                  bool is_clockwise, double sweep_s);

}  // namespace tvl
