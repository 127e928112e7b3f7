// The image of a place from above: what stands on the ground.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tvl/loop/lidar_descriptor.h"

namespace tvl {

// The ground under the points on a square grid of `side` cells about the sensor: no higher than the
// lowest tenth of the points of its cell, rising no faster than ground_slope. Row by row, y then x.
// Cells hear of their neighbours' points, so those that hold a wall but no ground get it right.
// Infinite where there are no points at all.
std::vector<float> GroundHeights(const KeyframeCloud& cloud, int side,
                                 const LidarDescriptorOptions& options);

// Cells holding points between min_height_m and max_height_m above the ground, row by row.
std::vector<PlaceCell> StandingCells(const KeyframeCloud& cloud,
                                     const LidarDescriptorOptions& options);

// The cells as an image of `side` x `side` floats that spans the whole range, turned by yaw_rad
// about the sensor; every cell is spread over four pixels.
cv::Mat PlaceImage(const std::vector<PlaceCell>& cells, double yaw_rad, int side,
                   const LidarDescriptorOptions& options);

}  // namespace tvl
