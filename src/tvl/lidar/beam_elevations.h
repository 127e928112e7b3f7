// The elevations of a lidar's beams, measured from the points of a few scans.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/sensor/raw_scan.h"

namespace tvl {

// Elevation of a point above the horizon of the sensor, rad.
float Elevation_rad(const Eigen::Vector3f& p);

// A point with a return: finite and at least `min_range` from the origin, in the unit of the scan.
bool IsReturn(const Eigen::Vector3f& p, float min_range);

// Points of one line (ring, or row or column of an organised cloud), summed up.
struct LineElevation {
  size_t points = 0;
  double median_rad = 0.0;
  double range = 20.0;       // median, in the unit of the scan
  double scatter_rad = 0.0;  // median absolute deviation
};

// One entry a line, of the farther half of its points: where beams start beside the sensor's
// origin near points appear too high. `line_of` has an entry a point, -1 for points to leave out.
std::vector<LineElevation> MeasureLines(const std::vector<const RawScan*>& scans,
                                        const std::vector<std::vector<int>>& line_of, int lines);

// Elevations that the points of the scans cluster at, topmost first. Empty where they do not: no
// beams, or beams whose points stray too far.
std::vector<double> FindElevationClusters(const std::vector<const RawScan*>& scans,
                                          float min_range);

}  // namespace tvl
