#include "tvl/registration/edge_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

constexpr double kWall_m = 35.0;  // behind everything

Camera TestCamera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 500.0;
  camera.cx_px = 400.0;
  camera.cy_px = 150.0;
  camera.width_px = 800;
  camera.height_px = 300;
  return camera;
}

Rigid3d GivenExtrinsics() {
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

EdgeProfiles Read(const cv::Mat& grey, const SegmentedScan& scan, const Rigid3d& T_cam_lidar) {
  return FindEdgeProfiles(grey, scan, scan.points, TestCamera(), T_cam_lidar,
                          EdgeAlignmentOptions().max_edges);
}

// Some images tell; those read with what the first have told do not tell otherwise.
TEST(EdgeAlignment, FindsWhereTheCameraPoints) {
  for (const double size_deg : {0.0, 0.15, 0.5, 1.0}) {
    const Eigen::Vector3d error_rad = DegToRad(size_deg) * Eigen::Vector3d(0.6, -0.6, 0.53);
    const Rigid3d turn(ExpSo3(error_rad), Eigen::Vector3d::Zero());
    EdgeAlignment alignment{EdgeAlignmentOptions()};
    Eigen::Vector3d known_rad = Eigen::Vector3d::Zero();
    for (uint64_t seed = 1; seed <= 12; ++seed) {
      Scene scene(seed);
      const Rigid3d known(ExpSo3(known_rad), Eigen::Vector3d::Zero());
      alignment.Add(
          Read(scene.See(turn * GivenExtrinsics()), scene.Scan(), known * GivenExtrinsics()),
          known_rad);
      if (seed == 4) known_rad = alignment.estimate().rotation_rad;
    }
    const EdgeEstimate estimate = alignment.estimate();
    ASSERT_GE(estimate.images, 8) << size_deg;
    const Eigen::Vector3d left_rad = estimate.rotation_rad - error_rad;
    EXPECT_LT(std::abs(left_rad.x()), DegToRad(0.08)) << size_deg;
    EXPECT_LT(std::abs(left_rad.y()), DegToRad(0.04)) << size_deg;
    EXPECT_LT(std::abs(left_rad.z()), DegToRad(0.1)) << size_deg;
    const Eigen::Matrix3d covariance = estimate.information.inverse();
    EXPECT_LT(std::sqrt(covariance(1, 1)), DegToRad(0.1)) << "and knows it";
    EXPECT_LT(left_rad.dot(estimate.information * left_rad), 9.0) << size_deg;
  }
}

TEST(EdgeAlignment, SaysNothingOfImagesOfSomethingElse) {
  EdgeAlignment unrelated{EdgeAlignmentOptions()}, uniform{EdgeAlignmentOptions()},
      blind{EdgeAlignmentOptions()};
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Scene scene(seed), other(seed + 100);
    const SegmentedScan scan = scene.Scan();
    unrelated.Add(Read(other.See(GivenExtrinsics()), scan, GivenExtrinsics()),
                  Eigen::Vector3d::Zero());
    uniform.Add(Read(cv::Mat(300, 800, CV_8U, cv::Scalar(90)), scan, GivenExtrinsics()),
                Eigen::Vector3d::Zero());
    blind.Add(Read(cv::Mat(), scan, GivenExtrinsics()), Eigen::Vector3d::Zero());
    EXPECT_EQ(unrelated.estimate().images, 0) << seed;
  }
  EXPECT_EQ(uniform.estimate().images, 0);
  EXPECT_EQ(blind.estimate().images, 0);
}

TEST(EdgeAlignment, LooksAgainOnlyAfterSomeWay) {
  EdgeAlignment alignment{EdgeAlignmentOptions()};
  const auto at = [](double way_m) {
    return Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(way_m, 0.0, 0.0));
  };
  EXPECT_TRUE(alignment.IsDue(at(0.0)));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(alignment.IsDue(at(0.01 * i))) << "it stands";
  EXPECT_TRUE(alignment.IsDue(at(0.6)));
  EXPECT_FALSE(alignment.IsDue(at(1.6))) << "the next frame";
  EXPECT_TRUE(alignment.IsDue(at(2.6)));
}

TEST(EdgeAlignment, OptionsAreChecked) {
  EdgeAlignmentOptions options;
  options.max_images = 0;
  EXPECT_THROW(EdgeAlignment{options}, InputError);
  options = {};
  options.bias_up_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
