// Where a visual track lies in the world, by its ray and the depth that the lidar gave it.
#pragma once

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct TrackPoint {
  Eigen::Vector3d p_world;
  Eigen::Matrix3d covariance_m2;  // world
};

// `sigma_rad` is the standard deviation across the ray; along it, the depth's own counts.
TrackPoint LocateTrack(const FeatureTrack& track, const VisualDepth& depth, double sigma_rad,
                       const Rigid3d& T_world_cam);

}  // namespace tvl
