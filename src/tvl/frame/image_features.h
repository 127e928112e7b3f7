// Corners of one image with binary descriptors: what visual loop detection compares (paper 6.2).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace tvl {

// 256 comparisons, bit i of the i-th in word i / 64.
using BinaryDescriptor = std::array<uint64_t, 4>;

// Structure of arrays, all of the same length. 60 bytes a feature, 30 kB a keyframe of 500.
struct ImageFeatures {
  std::vector<Eigen::Vector2f> px_cam;   // in the image as delivered (distorted), px
  std::vector<Eigen::Vector2f> ray_cam;  // normalised, undistorted image point (z = 1)
  std::vector<float> depth_m;            // z in the camera frame; 0 where the lidar does not know
  std::vector<BinaryDescriptor> descriptors;

  size_t size() const { return descriptors.size(); }
};

}  // namespace tvl
