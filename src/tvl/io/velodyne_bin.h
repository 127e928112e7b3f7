// Scans in KITTI's .bin format: float32 x y z intensity a point, nothing else.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"
#include "tvl/sensor/sensor_frame.h"

namespace tvl {

// What a whole scan of this recording is like.
struct ScanExpectation {
  // Rings of the sensor, 0 if not known. Points are stored ring after ring, so that a scan with far
  // fewer turns of the azimuth is cut off.
  int rings = 0;
  // Median number of points of the recording's files, 0 if not known.
  size_t typical_points = 0;
  // A scan is truncated below these shares. Upper beams that see only sky, or low ones behind the
  // own car, cost an intact scan some 15 rings of 64 at most; half the points vanish in the open.
  double min_ring_share = 0.7;
  double min_point_share = 0.3;
};

struct ScanRead {
  std::shared_ptr<const LidarScan> scan;  // null: unusable, the faults say why
  std::vector<FrameFault> faults;         // name the file
  int rings = 0;                          // full turns of the azimuth
};

// Reads a scan; ring and time_offset_s stay empty. Points that are not finite or further than 10 km
// are dropped and reported. Never throws for bad data.
ScanRead ReadVelodyneBin(const std::string& path, const ScanExpectation& expected);

// Full turns of the azimuth about z along the stored order (net, so that jitter at the seam does
// not count): the number of rings, in a file that stores them one after the other.
int CountAzimuthTurns(const std::vector<Eigen::Vector3f>& points);

// Writes points and intensity (0 where the scan has none). The write is atomic.
void WriteVelodyneBin(const std::string& path, const LidarScan& scan);

}  // namespace tvl
