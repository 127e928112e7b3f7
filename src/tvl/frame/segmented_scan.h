// A scan sorted into a range image and labelled; what segmentation hands on (paper 4.2).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tvl {

// Rows are rings (0 topmost), columns azimuth from +pi (behind, left end) falling to -pi, so that
// the picture looks as the camera sees it: left is left, the middle column faces forward.
struct RangeImage {
  static constexpr int32_t kNoPoint = -1;
  int rows = 0, columns = 0;
  std::vector<float> range_m;  // rows * columns, row-major; 0 where there is no point
  std::vector<int32_t> point;  // index into SegmentedScan::points, kNoPoint where there is none

  size_t Index(int row, int column) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns) + static_cast<size_t>(column);
  }
};

// Labels of SegmentedScan::label.
inline constexpr int32_t kLabelOutlier = 0;  // small cluster: unreliable, excluded
inline constexpr int32_t kLabelGround = 1;
inline constexpr int32_t kFirstClusterLabel = 2;

// Points of the scan that landed in the range image (the nearest of those that share a cell),
// calibrated (vertical correction) but not moved.
struct SegmentedScan {
  std::vector<Eigen::Vector3f> points;  // p_lidar, m
  std::vector<float> intensity;         // 0..1
  std::vector<float> time_offset_s;     // relative to the frame's stamp; all 0 if compensated
  std::vector<uint16_t> ring;           // row
  std::vector<int32_t> label;           // kLabel..., clusters from kFirstClusterLabel
  RangeImage image;
  int clusters = 0;  // kept clusters; labels run to kFirstClusterLabel + clusters

  size_t size() const { return points.size(); }
};

}  // namespace tvl
