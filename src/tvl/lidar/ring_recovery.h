// Which ring each point of a scan belongs to (paper 4.2; formats such as KITTI's .bin do not say).
//
// Such scans are stored ring after ring, the topmost first; within a ring the azimuth goes round
// once, starting straight ahead. A ring ends where the azimuth passes the start again. In 75 real
// scans (KITTI odometry, KITTI raw, KITTI-360) all 64 rings are found so. Elevation alone cannot
// tell rings apart: nearby points of one HDL-64 ring scatter by 0.5-1.5 deg, beams lie 0.33 deg
// apart. It is only used, as a median over a ring, to find out which rings are missing: on the open
// road the upper ones, which look at the sky.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/lidar/ring_alignment.h"
#include "tvl/lidar/scan_geometry.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"

namespace tvl {

struct RingRecoveryOptions {
  // Steps against the sense of storage up to this size stay within the ring: compensation for
  // motion moves nearby points back by up to 7 deg (KITTI odometry 00).
  double max_backstep_rad = 0.2;
  // Points nearer than this are the sensor's own "no return" entries: they say nothing.
  double min_range_m = 0.1;

  void Check() const;
};

enum class RingSource {
  kGiven,     // LidarScan::ring
  kOneToOne,  // as many rings found as the sensor has beams (or the beams are not known)
  kAligned,   // another number: assigned to rows by elevation, in order (see ring_alignment.h)
  kSlices,    // the sensor has no beams: slices of equal elevation
};

struct RingAssignment {
  std::vector<uint16_t> row;  // one a point of the scan
  int rows = 0;               // of the range image: beams of the model, else the highest row + 1
  RingSource source = RingSource::kOneToOne;
  // Evidence.
  int rings_found = 0;                // distinct rings
  double elevation_offset_rad = 0.0;  // kAligned: measured minus modelled elevation, common part
  double origin_height_m = 0.0;    // kAligned: of the beams over the sensor's origin, common part
  double elevation_rms_rad = 0.0;  // kAligned: what remains
};

// What earlier scans of a sensor showed.
struct RingMemory {
  std::vector<RingProfile> complete;  // the rings of a scan with as many as there are beams
  int scans = 0;                      // complete ones so far
};

// `geometry` belongs to `scan`. Throws InputError if a given ring lies outside the sensor's beams,
// if the points are plainly not stored ring after ring, or for more rings than any lidar has.
// Where rings are missing, `memory` helps to tell which; complete scans are kept in it. `reuse`
// hands in storage.
RingAssignment RecoverRings(const LidarScan& scan, const ScanGeometry& geometry,
                            const LidarModel& model, const RingRecoveryOptions& options,
                            RingMemory* memory = nullptr, RingAssignment reuse = {});

}  // namespace tvl
