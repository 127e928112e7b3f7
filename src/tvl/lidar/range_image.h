// Sorts a scan into a range image (paper 4.2): rows are rings, columns azimuth.
#pragma once

#include "tvl/frame/segmented_scan.h"
#include "tvl/lidar/ring_recovery.h"
#include "tvl/lidar/scan_geometry.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"

namespace tvl {

struct RangeImageResult {
  SegmentedScan scan;  // all labels kLabelOutlier
  // What became of the other points of the scan.
  int not_finite = 0;
  int out_of_range = 0;  // outside the model's range limits
  int hidden = 0;        // shared a cell with a nearer point
};

// Points outside the range limits and non-finite ones are dropped, the nearest of those in one
// cell is kept. The points of the result are ordered by row, then column (left to right), so that
// one row's points lie side by side; they carry the model's vertical correction. Time offsets are
// the scan's own, else azimuth and spin give them (the stamp is the instant the sensor faces
// forward, +-pi are half a sweep away); all zero for Deskew::kNone.
// `geometry` and `rings` belong to `scan`. `reuse` hands in memory.
RangeImageResult BuildRangeImage(const LidarScan& scan, const ScanGeometry& geometry,
                                 const RingAssignment& rings, const LidarModel& model,
                                 Deskew deskew, SegmentedScan reuse = {});

// Seconds from the stamp at which a spinning sensor faces `azimuth_rad`.
inline float TimeOffset_s(float azimuth_rad, Deskew deskew, double sweep_s) {
  if (deskew == Deskew::kNone) return 0.0f;
  const float s_per_rad = static_cast<float>(sweep_s / (2.0 * 3.14159265358979323846));
  return deskew == Deskew::kCounterClockwise ? azimuth_rad * s_per_rad : -azimuth_rad * s_per_rad;
}

}  // namespace tvl
