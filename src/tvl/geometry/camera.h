// Pinhole camera with optional radial-tangential distortion (the model of OpenCV).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace tvl {

// Camera frame: z forward, x right, y down. Pixels: centre of the top left pixel is (0, 0).
struct Camera {
  double fx_px = 0.0, fy_px = 0.0, cx_px = 0.0, cy_px = 0.0;
  int width_px = 0, height_px = 0;  // 0: not known until the first image
  // k1, k2, p1, p2, k3; all zero: rectified images.
  std::array<double, 5> distortion{};

  bool IsDistorted() const {
    for (const double d : distortion) {
      if (d != 0.0) return true;
    }
    return false;
  }
  // Normalised image point (z = 1, undistorted) to pixel, with distortion.
  Eigen::Vector2d Project(const Eigen::Vector2d& normalised) const;
  // Pixel to normalised image point, undistorted.
  Eigen::Vector2d Unproject(const Eigen::Vector2d& px_cam) const;
};

}  // namespace tvl
