// A world for tests of outlines against images: boards before a wall.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/registration/edge_profiles.h"

namespace tvl::test_edges {

inline constexpr double kWall_m = 35.0;  // behind everything

inline Camera TestCamera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 500.0;
  camera.cx_px = 400.0;
  camera.cy_px = 150.0;
  camera.width_px = 800;
  camera.height_px = 300;
  return camera;
}

inline Rigid3d GivenExtrinsics() {
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {R, Eigen::Vector3d(0.0, -0.08, -0.27)};
}

// Boards across the way, each of its own grey, before a wall.
struct Board {
  double x_m, y_min_m, y_max_m, z_min_m, z_max_m;
  float level;
};

class Scene {
 public:
  explicit Scene(uint64_t seed) : rng_(seed) {
    for (int i = 0; i < 22; ++i) {
      const double x = rng_.Uniform(6.0, 25.0), y = rng_.Uniform(-0.7, 0.7) * x;
      const double z = rng_.Uniform(-1.8, 0.5);
      boards_.push_back({x, y, y + rng_.Uniform(0.3, 2.5), -2.5, z,
                         static_cast<float>(rng_.Uniform(20.0, 230.0))});
    }
  }

  // The nearest surface along a ray from `origin`: distance along the ray and its grey level.
  std::pair<double, float> Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
    std::pair<double, float> nearest{(kWall_m - origin.x()) / ray.x(), 120.0f};
    for (const Board& board : boards_) {
      const double s = (board.x_m - origin.x()) / ray.x();
      const Eigen::Vector3d p = origin + s * ray;
      if (s < nearest.first && p.y() > board.y_min_m && p.y() < board.y_max_m &&
          p.z() > board.z_min_m && p.z() < board.z_max_m) {
        nearest = {s, board.level};
      }
    }
    return nearest;
  }

  cv::Mat See(const Rigid3d& T_cam_lidar) {
    const Camera camera = TestCamera();
    const Rigid3d T_lidar_cam = T_cam_lidar.Inverse();
    cv::Mat grey(camera.height_px, camera.width_px, CV_8U);
    for (int v = 0; v < grey.rows; ++v) {
      for (int u = 0; u < grey.cols; ++u) {
        const Eigen::Vector2d ray = camera.Unproject({u, v});
        const float level = Cast(T_lidar_cam.t(), T_lidar_cam.q() * ray.homogeneous()).second;
        grey.at<uint8_t>(v, u) = static_cast<uint8_t>(level + rng_.Uniform(0.0, 6.0));
      }
    }
    return grey;
  }

  // 64 rows 0.4 deg apart, columns 0.2 deg apart, 1 cm noise; the front quarter.
  SegmentedScan Scan() {
    SegmentedScan scan;
    scan.image.rows = 64;
    scan.image.columns = 1800;
    const size_t cells = 64 * 1800;
    scan.image.range_m.assign(cells, 0.0f);
    scan.image.point.assign(cells, RangeImage::kNoPoint);
    for (int row = 0; row < 64; ++row) {
      for (int column = 675; column < 1125; ++column) {
        const double azimuth = kPi - DegToRad(0.2 * column);
        const double elevation = DegToRad(2.0 - 0.4 * row);
        const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                                   std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        const double range_m = Cast(Eigen::Vector3d::Zero(), beam).first + 0.01 * rng_.Normal();
        const size_t cell = scan.image.Index(row, column);
        scan.image.range_m[cell] = static_cast<float>(range_m);
        scan.image.point[cell] = static_cast<int32_t>(scan.points.size());
        scan.points.push_back((range_m * beam).cast<float>());
        scan.ring.push_back(static_cast<uint16_t>(row));
        scan.label.push_back(kFirstClusterLabel);
      }
    }
    return scan;
  }

 private:
  Rng rng_;
  std::vector<Board> boards_;
};

}  // namespace tvl::test_edges
