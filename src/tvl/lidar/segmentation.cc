#include "tvl/lidar/segmentation.h"

#include <utility>

namespace tvl {

void SegmentationOptions::Check() const {
  rings.Check();
  ground.Check();
  clusters.Check();
}

Segmentation SegmentScanWithEvidence(const LidarScan& scan, const LidarModel& model, Deskew deskew,
                                     const SegmentationOptions& options,
                                     SegmentationWorkspace* workspace) {
  SegmentationWorkspace own;
  SegmentationWorkspace& w = workspace != nullptr ? *workspace : own;
  w.geometry = ComputeScanGeometry(scan, std::move(w.geometry));
  w.rings =
      RecoverRings(scan, w.geometry, model, options.rings, &w.ring_memory, std::move(w.rings));
  RangeImageResult image = BuildRangeImage(scan, w.geometry, w.rings, model, deskew);
  const GroundResult ground = FindGround(image.scan, options.ground);
  ClusterResult clusters = FindClusters(image.scan, ground.is_ground, options.clusters);

  Segmentation out;
  out.scan = std::move(image.scan);
  out.scan.label = std::move(clusters.label);
  out.scan.clusters = clusters.clusters;
  SegmentationEvidence& e = out.evidence;
  e.rings_found = w.rings.rings_found;
  e.ring_source = w.rings.source;
  e.elevation_offset_rad = w.rings.elevation_offset_rad;
  e.elevation_rms_rad = w.rings.elevation_rms_rad;
  e.not_finite = image.not_finite;
  e.out_of_range = image.out_of_range;
  e.hidden = image.hidden;
  e.ground_seed = ground.seed;
  e.ground = ground.count;
  e.outliers = clusters.outliers;
  return out;
}

SegmentedScan SegmentScan(const LidarScan& scan, const LidarModel& model, Deskew deskew,
                          const SegmentationOptions& options, SegmentationWorkspace* workspace) {
  return SegmentScanWithEvidence(scan, model, deskew, options, workspace).scan;
}

}  // namespace tvl
