#include "tvl/lidar/feature_extraction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/geometry/voxel_thinning.h"
#include "tvl/lidar/scan_geometry.h"

namespace tvl {
namespace {

float EdgeThreshold(float range_m, float noise_m, const LaserFeatureOptions& options) {
  return std::max(static_cast<float>(options.min_edge_curvature), noise_m / range_m);
}

// What can be picked from one subregion of a row; indices into the row.
struct Candidates {
  std::vector<int> edges, planes;
};

// Picks features of one row.
class RowPicker {
 public:
  RowPicker(const SegmentedScan& scan, const LidarModel& model, const LaserFeatureOptions& options)
      : scan_(scan),
        options_(options),
        noise_m_(static_cast<float>(options.edge_noise_sigmas * 1.05 * model.range_sigma_m)) {
    planar_.reserve(scan.size()), planar_c_.reserve(scan.size());
  }

  // Points [begin, end) of the scan are the row. Appends to the features, but for F_lf.
  void Pick(size_t begin, size_t end, LaserFeatures* features) {
    begin_ = begin;
    LoadRow(end);
    const double column_rad = 2.0 * kPi / scan_.image.columns;
    curvature_ = ComputeCurvature(row_, column_rad, options_.curvature);
    taken_as_edge_.assign(curvature_.size(), 0);
    taken_as_plane_.assign(curvature_.size(), 0);
    const float region_rad = static_cast<float>(2.0 * kPi / options_.subregions);
    size_t i = 0;
    for (int region = 0; region < options_.subregions; ++region) {
      const bool last = region + 1 == options_.subregions;
      const float region_end = static_cast<float>(region + 1) * region_rad;
      candidates_.edges.clear(), candidates_.planes.clear();
      for (; i < curvature_.size() && (last || row_.angle_rad[i] < region_end); ++i) Classify(i);
      PickEdges(features);
      PickPlanes(features);
    }
  }

  // F_lf: one of the planar points of all rows a voxel. After the last Pick.
  std::vector<LaserFeature> LessFlat() const {
    std::vector<LaserFeature> features;
    for (const uint32_t k : MiddleOfEachVoxel(scan_.points, planar_, options_.less_flat_voxel_m)) {
      features.push_back(Feature(planar_[k], planar_c_[k]));
    }
    return features;
  }

 private:
  void LoadRow(size_t end) {
    const size_t n = end - begin_;
    row_.range_m.resize(n), row_.angle_rad.resize(n);
    for (size_t i = 0; i < n; ++i) {
      const Eigen::Vector3f& p = scan_.points[begin_ + i];
      row_.range_m[i] = std::sqrt(p.x() * p.x() + p.y() * p.y() + p.z() * p.z());
      row_.angle_rad[i] = static_cast<float>(kPi) - FastAtan2(p.y(), p.x());
    }
  }

  void Classify(size_t i) {
    const PointCurvature& point = curvature_[i];
    const int32_t label = scan_.label[begin_ + i];
    if (point.window == 0 || point.unreliable || label == kLabelOutlier) return;
    if (point.c < EdgeThreshold(row_.range_m[i], noise_m_, options_)) {
      candidates_.planes.push_back(static_cast<int>(i));
    } else if (label != kLabelGround) {
      candidates_.edges.push_back(static_cast<int>(i));
    }
  }

  LaserFeature Feature(size_t p, float c) const {
    return {scan_.points[p],    scan_.time_offset_s[p], c,
            scan_.intensity[p], scan_.ring[p],          scan_.label[p]};
  }
  LaserFeature Feature(int i) const {
    return Feature(begin_ + static_cast<size_t>(i), curvature_[static_cast<size_t>(i)].c);
  }

  // Keeps later picks away from `i`; the ring is closed.
  void Take(int i, std::vector<uint8_t>* taken) const {
    const int n = static_cast<int>(taken->size());
    const int reach = std::min<int>(curvature_[static_cast<size_t>(i)].window, n / 2);
    for (int j = i - reach; j <= i + reach; ++j) (*taken)[static_cast<size_t>((j + n) % n)] = 1;
  }

  void PickEdges(LaserFeatures* features) {
    std::vector<int>& edges = candidates_.edges;
    std::sort(edges.begin(), edges.end(), [&](int a, int b) {
      const float ca = curvature_[static_cast<size_t>(a)].c;
      const float cb = curvature_[static_cast<size_t>(b)].c;
      return ca != cb ? ca > cb : a < b;
    });
    int picked = 0;
    for (const int i : edges) {
      if (picked == options_.less_sharp_per_subregion) break;
      if (taken_as_edge_[static_cast<size_t>(i)]) continue;
      if (picked < options_.sharp_per_subregion) features->sharp.push_back(Feature(i));
      features->less_sharp.push_back(Feature(i));
      Take(i, &taken_as_edge_);
      ++picked;
    }
  }

  void PickPlanes(LaserFeatures* features) {
    for (const int i : candidates_.planes) {
      const size_t p = begin_ + static_cast<size_t>(i);
      planar_.push_back(static_cast<uint32_t>(p));
      planar_c_.push_back(curvature_[static_cast<size_t>(i)].c);
    }
    const std::vector<int>& planes = candidates_.planes;
    plane_c_.resize(planes.size());
    for (int picked = 0; picked < options_.flat_per_subregion && !planes.empty(); ++picked) {
      for (size_t k = 0; k < planes.size(); ++k) {
        const size_t i = static_cast<size_t>(planes[k]);
        plane_c_[k] = taken_as_plane_[i] ? kTaken : curvature_[i].c;
      }
      const Eigen::Map<const Eigen::ArrayXf> c(plane_c_.data(),
                                               static_cast<Eigen::Index>(plane_c_.size()));
      const float least = c.minCoeff();
      if (least == kTaken) break;
      const auto best = std::find(plane_c_.begin(), plane_c_.end(), least) - plane_c_.begin();
      features->flat.push_back(Feature(planes[static_cast<size_t>(best)]));
      Take(planes[static_cast<size_t>(best)], &taken_as_plane_);
    }
  }

  static constexpr float kTaken = std::numeric_limits<float>::infinity();
  const SegmentedScan& scan_;
  const LaserFeatureOptions& options_;
  const float noise_m_;
  std::vector<uint32_t> planar_;  // points of all rows, indices into the scan ...
  std::vector<float> planar_c_;   // ... and their curvature
  size_t begin_ = 0;
  RingPoints row_;
  std::vector<PointCurvature> curvature_;
  std::vector<uint8_t> taken_as_edge_, taken_as_plane_;
  Candidates candidates_;
  std::vector<float> plane_c_;  // of candidates_.planes, kTaken where not to be had
};

}  // namespace

void LaserFeatureOptions::Check() const {
  curvature.Check();
  TVL_CHECK_INPUT(min_edge_curvature > 0.0) << "features.min_edge_curvature: must be positive";
  TVL_CHECK_INPUT(edge_noise_sigmas >= 0.0) << "features.edge_noise_sigmas: must not be negative";
  TVL_CHECK_INPUT(subregions >= 1) << "features.subregions: must be positive";
  TVL_CHECK_INPUT(sharp_per_subregion >= 0) << "features.sharp_per_subregion: must not be negative";
  TVL_CHECK_INPUT(less_sharp_per_subregion >= sharp_per_subregion)
      << "features.less_sharp_per_subregion: must be at least sharp_per_subregion";
  TVL_CHECK_INPUT(flat_per_subregion >= 0) << "features.flat_per_subregion: must not be negative";
  TVL_CHECK_INPUT(less_flat_voxel_m > 0.0) << "features.less_flat_voxel_m: must be positive";
}

float EdgeThreshold(float range_m, const LidarModel& model, const LaserFeatureOptions& options) {
  return EdgeThreshold(
      range_m, static_cast<float>(options.edge_noise_sigmas * 1.05 * model.range_sigma_m), options);
}

LaserFeatures ExtractLaserFeatures(const SegmentedScan& scan, const LidarModel& model,
                                   const LaserFeatureOptions& options) {
  TVL_CHECK(scan.label.size() == scan.size() && scan.ring.size() == scan.size());
  LaserFeatures features;
  RowPicker picker(scan, model, options);
  for (size_t begin = 0; begin < scan.size();) {
    size_t end = begin + 1;
    while (end < scan.size() && scan.ring[end] == scan.ring[begin]) ++end;
    picker.Pick(begin, end, &features);
    begin = end;
  }
  features.less_flat = picker.LessFlat();
  return features;
}

}  // namespace tvl
