#include "tvl/lidar/planar_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/geometry/voxel_hash.h"
#include "tvl/geometry/voxel_thinning.h"

namespace tvl {
namespace {

// Sums over the points of a voxel, relative to its centre so that single precision suffices.
struct Moments {
  float count = 0.0F;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f outer = Eigen::Matrix3f::Zero();
};

class Neighbourhoods {
 public:
  Neighbourhoods(const SegmentedScan& scan, double edge_m) : edge_m_(edge_m) {
    voxels_.Reserve(scan.size() / 4);
    for (const Eigen::Vector3f& p : scan.points) {
      const VoxelKey key = KeyOf(p);
      Moments& m = voxels_[key];
      const Eigen::Vector3f d = p - key.Centre(edge_m_).cast<float>();
      m.count += 1.0F;
      m.sum += d;
      m.outer += d * d.transpose();
    }
  }

  // Eigenvalues of the covariance around p, ascending, m^2; `count` gets the number of points.
  Eigen::Vector3f Variances(const Eigen::Vector3f& p, float* count) const {
    const VoxelKey centre = KeyOf(p);
    Moments all;
    for (int32_t x = -1; x <= 1; ++x) {
      for (int32_t y = -1; y <= 1; ++y) {
        for (int32_t z = -1; z <= 1; ++z) {
          const Moments* m = voxels_.Find({centre.x + x, centre.y + y, centre.z + z});
          if (m == nullptr) continue;
          const Eigen::Vector3f shift =
              static_cast<float>(edge_m_) *
              Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
          all.outer += m->outer + shift * m->sum.transpose() + m->sum * shift.transpose() +
                       m->count * shift * shift.transpose();
          all.sum += m->sum + m->count * shift;
          all.count += m->count;
        }
      }
    }
    *count = all.count;
    if (all.count < 3.0F) return Eigen::Vector3f::Zero();
    const Eigen::Vector3f mean = all.sum / all.count;
    const Eigen::Matrix3f covariance = all.outer / all.count - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
    eigen.computeDirect(covariance, Eigen::EigenvaluesOnly);
    return eigen.eigenvalues().cwiseMax(0.0F);
  }

 private:
  VoxelKey KeyOf(const Eigen::Vector3f& p) const { return VoxelKey::Of(p.cast<double>(), edge_m_); }

  double edge_m_;
  VoxelHash<Moments> voxels_;
};

LaserFeature FeatureOf(const SegmentedScan& scan, uint32_t i, float curvature) {
  return {scan.points[i],    scan.time_offset_s[i], curvature,
          scan.intensity[i], scan.ring[i],          scan.label[i]};
}

}  // namespace

void PlanarPointOptions::Check() const {
  TVL_CHECK_INPUT(voxel_m > 0.0) << "planar_points.voxel_m: must be positive";
  TVL_CHECK_INPUT(coarse_voxel_m >= voxel_m) << "planar_points.coarse_voxel_m: less than voxel_m";
  TVL_CHECK_INPUT(neighbourhood_m > 0.0) << "planar_points.neighbourhood_m: must be positive";
  TVL_CHECK_INPUT(min_neighbours >= 3) << "planar_points.min_neighbours: must be at least 3";
  TVL_CHECK_INPUT(max_thickness_m > 0.0) << "planar_points.max_thickness_m: must be positive";
}

LaserFeatures FindPlanarPoints(const SegmentedScan& scan, const PlanarPointOptions& options) {
  std::vector<uint32_t> candidates;
  candidates.reserve(scan.size());
  for (uint32_t i = 0; i < scan.size(); ++i) {
    if (scan.label[i] != kLabelOutlier) candidates.push_back(i);
  }
  const Neighbourhoods neighbourhoods(scan, options.neighbourhood_m);
  LaserFeatures features;
  std::vector<Eigen::Vector3f> surface;  // where the scatter says that there is one
  std::vector<uint32_t> surface_point;
  for (const uint32_t k : MiddleOfEachVoxel(scan.points, candidates, options.voxel_m)) {
    const uint32_t i = candidates[k];
    float count = 0.0F;
    const Eigen::Vector3f variance_m2 = neighbourhoods.Variances(scan.points[i], &count);
    const float thickness_m = std::sqrt(variance_m2[0]);
    const bool tells = count >= static_cast<float>(options.min_neighbours);
    if (tells && thickness_m > static_cast<float>(options.max_thickness_m)) continue;
    features.less_flat.push_back(FeatureOf(scan, i, thickness_m));
    if (!tells) continue;
    surface.push_back(scan.points[i]);
    surface_point.push_back(static_cast<uint32_t>(features.less_flat.size() - 1));
  }
  for (const uint32_t k : MiddleOfEachVoxel(surface, options.coarse_voxel_m)) {
    features.flat.push_back(features.less_flat[surface_point[k]]);
  }
  return features;
}

}  // namespace tvl
