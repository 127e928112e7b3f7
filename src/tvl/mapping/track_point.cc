#include "tvl/mapping/track_point.h"

namespace tvl {

TrackPoint LocateTrack(const FeatureTrack& track, const VisualDepth& depth, double sigma_rad,
                       const Rigid3d& T_world_cam) {
  const Eigen::Vector3d ray = track.ray_cam.homogeneous();
  const double across_m = depth.depth_m * sigma_rad;
  const Eigen::Matrix3d covariance_cam = across_m * across_m * Eigen::Matrix3d::Identity() +
                                         depth.sigma_m * depth.sigma_m * ray * ray.transpose();
  return {T_world_cam * (depth.depth_m * ray),
          T_world_cam.R() * covariance_cam * T_world_cam.R().transpose()};
}

}  // namespace tvl
