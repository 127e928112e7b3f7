// The map from above (paper Fig. 13).
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/map/map_cloud.h"

namespace tvl {

// The cloud coloured by height over the driven line where it passes closest (blue low, green, red
// high), the driven line white, a scale bar; fitted to at most 1600 x 1200 px. `p_world` are the
// positions driven through, m. Works for an empty cloud too. 8-bit BGR.
cv::Mat DrawMap(const MapCloud& map, const std::vector<Eigen::Vector3d>& p_world);

}  // namespace tvl
