// Pinhole camera with optional lens distortion (the models of OpenCV).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace tvl {

// Coefficients in the order of OpenCV; those behind are zero.
enum class DistortionModel : uint8_t {
  kRadialTangential,  // k1, k2, p1, p2, k3; all zero: rectified images
  kRational,          // k1, k2, p1, p2, k3, k4, k5, k6
  // k1 .. k4 of OpenCV's cv::fisheye: theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9
  // takes the place of tan(theta), theta being the angle between ray and optical axis. Rays at 90
  // degrees and beyond have no normalised image point: they are neither made nor taken.
  kEquidistant,
};

// Camera frame: z forward, x right, y down. Pixels: centre of the top left pixel is (0, 0).
struct Camera {
  double fx_px = 0.0, fy_px = 0.0, cx_px = 0.0, cy_px = 0.0;
  int width_px = 0, height_px = 0;  // 0: not known until the first image
  std::array<double, 8> distortion{};
  DistortionModel distortion_model = DistortionModel::kRadialTangential;

  bool IsDistorted() const {
    if (distortion_model == DistortionModel::kEquidistant) return true;
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
