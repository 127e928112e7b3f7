// Keeps one feature a voxel.
#pragma once

#include <vector>

#include "tvl/frame/laser_features.h"

namespace tvl {

// The first feature of each voxel of the given edge length (grid aligned to the lidar frame), in
// the order they came. Coordinates within +-100,000 voxels. Throws Error for a size <= 0.
std::vector<LaserFeature> ThinByVoxel(const std::vector<LaserFeature>& features, double voxel_m);

}  // namespace tvl
