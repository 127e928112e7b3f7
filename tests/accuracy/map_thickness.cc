#include "map_thickness.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tvl {

void ThicknessMeter::Add(const std::vector<Eigen::Vector3f>& p_lidar,
                         const Rigid3d& T_world_lidar) {
  for (const Eigen::Vector3f& p : p_lidar) {
    const double range_m = static_cast<double>(p.norm());
    if (!(range_m > options_.min_range_m && range_m < options_.max_range_m)) continue;
    const Eigen::Vector3d p_world = T_world_lidar * p.cast<double>();
    const VoxelKey key = VoxelKey::Of(p_world, options_.voxel_m);
    Moments& voxel = voxels_[key];
    const Eigen::Vector3d d = p_world - key.Centre(options_.voxel_m);
    ++voxel.points;
    voxel.scans += voxel.last_scan != scan_;
    voxel.last_scan = scan_;
    voxel.sum += d;
    voxel.squares += d * d.transpose();
  }
  ++scan_;
}

Thickness ThicknessMeter::Result() const {
  Thickness result;
  double squares_m2 = 0.0, points = 0.0;
  for (const auto& entry : voxels_.entries()) {
    const Moments& voxel = entry.value;
    if (voxel.points < options_.min_points || voxel.scans < options_.min_scans) continue;
    ++result.filled_voxels;
    const double n = voxel.points;
    const Eigen::Vector3d mean = voxel.sum / n;
    const Eigen::Matrix3d scatter = voxel.squares / n - mean * mean.transpose();
    const Eigen::Vector3d values =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly)
            .eigenvalues();
    if (values[0] > options_.max_flatness * values[1]) continue;
    if (values[1] < (1.0 - options_.max_linearity) * values[2]) continue;
    ++result.planar_voxels;
    squares_m2 += n * std::max(0.0, values[0]);
    points += n;
  }
  if (points > 0.0) result.rms_m = std::sqrt(squares_m2 / points);
  return result;
}

}  // namespace tvl
