// Depth of visual features from the labelled scan (paper 4.4, Fig. 6 and 7).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/depth/depth_options.h"
#include "tvl/depth/normalised_grid.h"
#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/segmented_scan.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

// One entry a track, in order. `p_lidar` holds the points of `scan` (same length and order) moved
// to the image instant, m; ring and label come from `scan`. T_cam_lidar is that of the camera the
// tracks come from. Throws Error for lengths that differ. Pure; thread-safe.
//
// Differs from the paper in four places, each for a reason: planes behind the camera are rejected
// (Eq. 2 takes the absolute value), five or more foreground points are fitted by least squares
// (three noisy points tilt), grazing planes are carried as uncertain rather than dropped (4.4.4
// drops all ground beyond 9.4 m), and a depth outside those of its foreground is rejected.
//
// The standard deviation along the ray, for a range noise s_r, n foreground points with distance
// rms e to the plane, angle a between ray and plane, and focal length f:
//   sigma^2 = (s_r / sin a)^2 + (d sigma_px / (f tan a))^2 + (leverage e^2) / sin^2 a.
VisualDepths AssociateDepth(const FeatureTracks& tracks,
                            const std::vector<Eigen::Vector3f>& p_lidar, const SegmentedScan& scan,
                            const Camera& camera, const Rigid3d& T_cam_lidar,
                            const LidarModel& lidar, const DepthOptions& options = {});

// The points of a scan in front of the camera and inside `bounds`. Outliers are left out unless the
// options keep them; points beyond the depth limit plus 20 % neither are surfaces we could use.
std::vector<ProjectedPoint> ProjectScan(const std::vector<Eigen::Vector3f>& p_lidar,
                                        const SegmentedScan& scan, const Rigid3d& T_cam_lidar,
                                        const NormalisedRect& bounds, const DepthOptions& options);

// The foreground of a neighbourhood: the points of the label whose median depth is least (paper
// 4.4.2).
std::vector<ProjectedPoint> SelectForeground(std::vector<ProjectedPoint> neighbours);

}  // namespace tvl
