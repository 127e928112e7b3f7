// The road as it should look in the next image. At speed a patch of road grows by a third from one
// image to the next, more than optical flow of unchanging patches can follow; warped by the motion
// of the road's plane it keeps its shape, and only the error of the prediction is left to find.
#pragma once

#include <opencv2/core/matx.hpp>
#include <optional>

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// The plane of the tracks that lie on the ground: inverse_m . p_cam = 1 for its points, m^-1. Empty
// if there are fewer than 10 of them or they do not lie on one plane.
std::optional<Eigen::Vector3d> FitGroundPlane(const FeatureTracks& tracks,
                                              const VisualDepths& depths);

// Takes pixels of the plane in the previous image to the current one. For a camera without
// distortion.
cv::Matx33d PlaneHomography(const Eigen::Vector3d& inverse_m, const Rigid3d& T_cur_prev,
                            const Camera& camera);

}  // namespace tvl
