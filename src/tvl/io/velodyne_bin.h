// Scans in KITTI's .bin format: float32 x y z intensity a point, nothing else.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"
#include "tvl/sensor/sensor_frame.h"

namespace tvl {

// What a whole scan of this recording is like. Points are stored ring after ring from the top, so
// that a file that was cut off lacks turns of the azimuth and ends too high.
struct ScanExpectation {
  // Rings of the sensor, 0 if not known.
  int rings = 0;
  // Elevation of the lowest beam, rad; used if rings are known.
  double lowest_beam_rad = 0.0;
  // Median number of points of the recording's files, 0 if not known.
  size_t typical_points = 0;
  // A scan is truncated below these shares. Upper beams that see only sky cost an intact scan some
  // 10 rings of 64; half the points vanish in the open.
  double min_ring_share = 0.7;
  double min_point_share = 0.3;
  // Or if its last points lie this far above the lowest beam: 12 rings of an HDL-64E. Real scans
  // end 0.6 to 1.1 deg above it.
  double max_end_above_rad = 0.105;
};

ScanExpectation ExpectationFor(const LidarModel& lidar, size_t typical_points);

struct ScanRead {
  std::shared_ptr<const LidarScan> scan;  // null: unusable, the faults say why
  std::vector<FrameFault> faults;         // name the file
  int turns = 0;                          // CountAzimuthTurns: the number of rings, less one
};

// Reads a scan; ring and time_offset_s stay empty. Points that are not finite or further than 10 km
// are dropped and reported. Never throws for bad data.
ScanRead ReadVelodyneBin(const std::string& path, const ScanExpectation& expected);

// Full turns of the azimuth about z along the stored order (net, so that jitter at the seam does
// not count): one less than the rings, in a file that stores them one after the other.
int CountAzimuthTurns(const std::vector<Eigen::Vector3f>& points);

// Writes points and intensity (0 where the scan has none). The write is atomic.
void WriteVelodyneBin(const std::string& path, const LidarScan& scan);

}  // namespace tvl
