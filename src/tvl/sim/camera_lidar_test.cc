// The two simulated sensors see one world: lidar depth carried from one image into the next with
// the true motion lands where tracking finds it.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tvl/sim/sim_dataset.h"

namespace tvl::sim {
namespace {

// Depth of the lidar point that falls on each pixel; 0 where there is none.
cv::Mat DepthImage(const SensorFrame& frame, const Calibration& calibration, cv::Size size) {
  cv::Mat depth(size, CV_32F, cv::Scalar(0));
  for (const Eigen::Vector3f& p_lidar : frame.scan->points) {
    const Eigen::Vector3d p_cam = calibration.T_cam_lidar * p_lidar.cast<double>();
    if (p_cam.z() < 1.0) continue;
    const Eigen::Vector2d px = calibration.camera.Project(p_cam.hnormalized());
    const cv::Point at(static_cast<int>(std::lround(px.x())),
                       static_cast<int>(std::lround(px.y())));
    if (!cv::Rect({0, 0}, size).contains(at)) continue;
    float& value = depth.at<float>(at);
    if (value == 0.0F || p_cam.z() < value) value = static_cast<float>(p_cam.z());
  }
  return depth;
}

// Depth at a pixel from a plane through its surroundings (1/z is linear in the image of a plane),
// 0 where they are no plane or empty.
double DepthAt(const cv::Mat& depth, const cv::Point2f& px) {
  const cv::Rect window(cvRound(px.x) - 5, cvRound(px.y) - 5, 11, 11);
  if ((window & cv::Rect({0, 0}, depth.size())) != window) return 0.0;
  std::vector<Eigen::Vector3d> rows;
  std::vector<double> inverse;
  for (int i = 0; i < window.area(); ++i) {
    const int x = window.x + i % window.width;
    const int y = window.y + i / window.width;
    const auto z = static_cast<double>(depth.at<float>(y, x));
    if (z == 0.0) continue;
    rows.emplace_back(1.0, x - static_cast<double>(px.x), y - static_cast<double>(px.y));
    inverse.push_back(1.0 / z);
  }
  if (rows.size() < 5) return 0.0;
  Eigen::MatrixX3d A(rows.size(), 3);
  for (size_t i = 0; i < rows.size(); ++i) A.row(static_cast<Eigen::Index>(i)) = rows[i];
  const Eigen::Map<Eigen::VectorXd> b(inverse.data(), static_cast<Eigen::Index>(inverse.size()));
  if (A.col(2).maxCoeff() - A.col(2).minCoeff() < 3.0) return 0.0;  // one ring only
  const Eigen::Vector3d plane = A.colPivHouseholderQr().solve(b);
  const double residual = (A * plane - b).cwiseAbs().maxCoeff();
  return residual > 0.005 * plane[0] ? 0.0 : 1.0 / plane[0];
}

TEST(SimulatedSensors, LidarDepthAgreesWithTracks) {
  SimOptions options;
  options.clean = true;
  options.seed = 5;
  options.frames = 80;
  const SimDataset data(options);
  const Calibration& calibration = data.setup().calibration;
  const SensorFrame a = data.Frame(60);
  const SensorFrame b = data.Frame(61);
  const std::vector<Rigid3d> truth = data.Truth_T_first_cam0();
  const Rigid3d T_b_a = truth[61].Inverse() * truth[60];
  EXPECT_GT(T_b_a.t().norm(), 0.3);

  std::vector<cv::Point2f> corners, in_a, expected;
  cv::goodFeaturesToTrack(a.image, corners, 1500, 0.01, 6.0);
  const cv::Mat depth = DepthImage(a, calibration, a.image.size());
  for (const cv::Point2f& px : corners) {
    const double z = DepthAt(depth, px);
    if (z == 0.0) continue;
    const Eigen::Vector2d n = calibration.camera.Unproject({px.x, px.y});
    const Eigen::Vector3d p_b = T_b_a * Eigen::Vector3d(z * n.x(), z * n.y(), z);
    const Eigen::Vector2d to = calibration.camera.Project(p_b.hnormalized());
    if (to.x() < 12 || to.y() < 12 || to.x() > 1228 || to.y() > 363) continue;
    in_a.push_back(px);
    expected.emplace_back(static_cast<float>(to.x()), static_cast<float>(to.y()));
  }
  ASSERT_GT(in_a.size(), 100U);
  std::vector<cv::Point2f> found = expected;
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(a.image, b.image, in_a, found, status, error, {15, 15}, 1,
                           {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  // Perspective changes over a metre of driving: single tracks are a third of a pixel off, but
  // not in one direction.
  std::vector<double> errors_px;
  cv::Point2d mean;
  int close = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    const cv::Point2f error_px = found[i] - expected[i];
    errors_px.push_back(status[i] != 0 ? cv::norm(error_px) : 10.0);
    if (errors_px.back() > 1.5) continue;
    mean += cv::Point2d(error_px);
    ++close;
  }
  std::sort(errors_px.begin(), errors_px.end());
  EXPECT_LT(errors_px[errors_px.size() / 2], 0.5);
  EXPECT_LT(cv::norm(mean) / close, 0.12);
}

}  // namespace
}  // namespace tvl::sim
