#include "tvl/geometry/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace tvl {
namespace {

Camera KittiLike() {
  Camera camera;
  camera.fx_px = camera.fy_px = 720.0;
  camera.cx_px = 610.0;
  camera.cy_px = 173.0;
  return camera;
}

TEST(Camera, ProjectsByHand) {
  const Eigen::Vector2d px = KittiLike().Project({0.5, -0.1});
  EXPECT_DOUBLE_EQ(px.x(), 970.0);
  EXPECT_DOUBLE_EQ(px.y(), 101.0);
}

TEST(Camera, UnprojectUndoesDistortion) {
  Camera camera = KittiLike();
  camera.distortion = {-0.37, 0.2, 0.0009, 0.0018, -0.07};
  for (const Eigen::Vector2d& n :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.6, 0.2), Eigen::Vector2d(-0.7, -0.2)}) {
    EXPECT_LT((camera.Unproject(camera.Project(n)) - n).norm(), 1e-6);
  }
}

// What a wide camera of a robot has, from OpenCV's calibration of one: 8 coefficients.
Camera RationalCamera() {
  Camera camera = KittiLike();
  camera.distortion_model = DistortionModel::kRational;
  camera.distortion = {0.42, -2.1, 0.0007, -0.0004, 1.3, 0.31, -1.92, 1.21};
  return camera;
}

Camera FisheyeCamera() {
  Camera camera = KittiLike();
  camera.fx_px = camera.fy_px = 300.0;
  camera.distortion_model = DistortionModel::kEquidistant;
  camera.distortion = {-0.013, 0.021, -0.017, 0.004};
  return camera;
}

std::vector<cv::Point3d> RaysUpTo(double most) {
  std::vector<cv::Point3d> rays;
  for (double x = -most; x <= most; x += most / 7.0) {
    for (double y = -most; y <= most; y += most / 5.0) rays.emplace_back(x, y, 1.0);
  }
  rays.emplace_back(0.0, 0.0, 1.0);
  return rays;
}

cv::Mat MatrixOf(const Camera& c) {
  return (cv::Mat_<double>(3, 3) << c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
}

void ExpectSamePixels(const Camera& camera, const std::vector<cv::Point3d>& rays,
                      const std::vector<cv::Point2d>& pixels) {
  ASSERT_EQ(pixels.size(), rays.size());
  for (size_t k = 0; k < rays.size(); ++k) {
    const Eigen::Vector2d px = camera.Project({rays[k].x, rays[k].y});
    EXPECT_NEAR(px.x(), pixels[k].x, 1e-6);
    EXPECT_NEAR(px.y(), pixels[k].y, 1e-6);
    EXPECT_LT((camera.Project(camera.Unproject(px)) - px).norm(), 1e-6);
    const Eigen::Vector2d n(rays[k].x, rays[k].y);
    EXPECT_LT((camera.Unproject(px) - n).norm(), 1e-9 * (1.0 + n.squaredNorm()));
  }
}

TEST(Camera, RationalModelIsOpenCvs) {
  const Camera camera = RationalCamera();
  const std::vector<cv::Point3d> rays = RaysUpTo(0.8);
  const std::vector<double> k(camera.distortion.begin(), camera.distortion.end());
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(rays, cv::Vec3d(), cv::Vec3d(), MatrixOf(camera), k, pixels);
  ExpectSamePixels(camera, rays, pixels);
}

TEST(Camera, EquidistantModelIsOpenCvs) {
  const Camera camera = FisheyeCamera();
  const std::vector<cv::Point3d> rays = RaysUpTo(5.0);  // 82 degrees at the corners
  const std::vector<double> k(camera.distortion.begin(), camera.distortion.begin() + 4);
  std::vector<cv::Point2d> pixels;
  cv::fisheye::projectPoints(rays, pixels, cv::Vec3d(), cv::Vec3d(), MatrixOf(camera), k);
  ExpectSamePixels(camera, rays, pixels);
}

TEST(Camera, EquidistantModelDistortsWithoutCoefficientsAndEndsAtTheHorizon) {
  Camera camera = FisheyeCamera();
  camera.distortion = {};
  EXPECT_TRUE(camera.IsDistorted());
  EXPECT_NEAR(camera.Project({1.0, 0.0}).x(), camera.cx_px + 300.0 * std::atan(1.0), 1e-9);
  const Eigen::Vector2d beyond = camera.Unproject({camera.cx_px + 300.0 * 2.0, camera.cy_px});
  EXPECT_TRUE(beyond.allFinite());
  EXPECT_GT(beyond.x(), 50.0);
}

}  // namespace
}  // namespace tvl
