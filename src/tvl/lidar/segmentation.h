// From a raw scan to a labelled one (paper 4.2): rings, range image, ground, clusters.
#pragma once

#include "tvl/frame/segmented_scan.h"
#include "tvl/lidar/clusters.h"
#include "tvl/lidar/ground.h"
#include "tvl/lidar/range_image.h"
#include "tvl/lidar/ring_recovery.h"
#include "tvl/lidar/scan_geometry.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"

namespace tvl {

struct SegmentationOptions {
  RingRecoveryOptions rings;
  GroundOptions ground;
  ClusterOptions clusters;

  void Check() const;
};

// How a scan came out; counts of points unless said otherwise.
struct SegmentationEvidence {
  int rings_found = 0;
  RingSource ring_source = RingSource::kOneToOne;
  double elevation_offset_rad = 0, elevation_rms_rad = 0;  // RingSource::kAligned only
  int not_finite = 0, out_of_range = 0, hidden = 0;
  GroundSeed ground_seed;
  int ground = 0, outliers = 0;
};

struct Segmentation {
  SegmentedScan scan;
  SegmentationEvidence evidence;
};

// Kept from scan to scan of one sensor: storage, and what earlier scans tell of which rings are
// missing. Not for two threads at once.
struct SegmentationWorkspace {
  ScanGeometry geometry;
  RingAssignment rings;
  RingMemory ring_memory;
};

// Throws InputError for a scan whose rings cannot be told (see RecoverRings). A scan without a
// usable point gives an empty result. Deterministic; thread-safe with a workspace a thread.
SegmentedScan SegmentScan(const LidarScan& scan, const LidarModel& model, Deskew deskew,
                          const SegmentationOptions& options,
                          SegmentationWorkspace* workspace = nullptr);

// The same with its evidence.
Segmentation SegmentScanWithEvidence(const LidarScan& scan, const LidarModel& model, Deskew deskew,
                                     const SegmentationOptions& options,
                                     SegmentationWorkspace* workspace = nullptr);

}  // namespace tvl
