// What the order of a scan's points tells: whether they are stored ring after ring, or as a
// spinning lidar measures them, one firing after the other.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tvl/sensor/raw_scan.h"

namespace tvl {

// Of a scan stored one ring after the other: the azimuth goes round once a ring, always the same
// way, and the elevation rises or falls over the scan as a whole.
struct RingOrder {
  bool lowest_first = false;
  // Of each degree of azimuth, from -180: how often the elevation steps there as from one ring to
  // the next.
  std::vector<double> start_score;
};

// Empty where the points are stored in another order. Points nearer than `min_range` (in the unit
// of the scan) are left out.
std::optional<RingOrder> FindRingOrder(const RawScan& scan, float min_range);

// Azimuth at which the rings of a recording's scans begin, -pi to pi.
double RingStart_rad(const std::vector<RingOrder>& orders);

// Turns of the azimuth from the first point to the last, positive counter-clockwise, where it goes
// round evenly: about 1 for a sweep in the order it was measured. 0 where it does not.
double StoredTurns(const RawScan& scan, float min_range);

// Seconds from the middle of the sweep to the instant each of the points `kept` (indices,
// increasing) was measured, by its azimuth. For scans stored as they were measured.
std::vector<float> TimesFromOrder(const RawScan& scan, const std::vector<uint32_t>& kept,
                                  bool is_clockwise, double sweep_s);

}  // namespace tvl
