// Visual features with and without depth over the image (paper Fig. 7).
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

// Features with depth as discs coloured by it, red (near) to blue (50 m), a black rim where the
// standard deviation exceeds 5 % of the depth; features without depth as grey rings; the lidar's
// points faint in the same colours. `p_lidar` are the points at the image instant, m. The bar below
// counts the outcomes. 8-bit BGR, as wide as the image.
cv::Mat DrawDepths(const cv::Mat& image, const FeatureTracks& tracks, const VisualDepths& depths,
                   const std::vector<Eigen::Vector3f>& p_lidar, const Camera& camera,
                   const Rigid3d& T_cam_lidar);

}  // namespace tvl
