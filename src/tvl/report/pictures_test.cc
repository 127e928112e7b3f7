// The pictures of tracks, depth, segments, features and maps: that what they promise is there.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/report/canvas.h"
#include "tvl/report/depth_picture.h"
#include "tvl/report/features_picture.h"
#include "tvl/report/map_picture.h"
#include "tvl/report/segments_picture.h"
#include "tvl/report/top_view.h"
#include "tvl/report/tracks_picture.h"

namespace tvl {
namespace {

cv::Vec3b At(const cv::Mat& picture, int x, int y) { return picture.at<cv::Vec3b>(y, x); }

bool IsNear(const cv::Vec3b& pixel, const cv::Scalar& colour) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(pixel[k] - colour[k]) > 30.0) return false;
  }
  return true;
}

cv::Mat GreyImage() { return cv::Mat(200, 400, CV_8U, cv::Scalar(90)); }

FeatureTrack TrackAt(double x_px, double y_px, int length) {
  FeatureTrack track;
  track.length = length;
  track.px_cam = {x_px, y_px};
  track.px_cam_prev = {x_px - 20.0, y_px};
  track.ray_cam = {(x_px - 200.0) / 300.0, (y_px - 100.0) / 300.0};
  return track;
}

Calibration TestCalibration() {
  Calibration calibration;
  calibration.camera.fx_px = calibration.camera.fy_px = 300.0;
  calibration.camera.cx_px = 200.0;
  calibration.camera.cy_px = 100.0;
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  calibration.T_cam_lidar = Rigid3d(R, Eigen::Vector3d::Zero());
  return calibration;
}

TEST(Pictures, ColourScales) {
  EXPECT_EQ(GreenToRed(0.0), cv::Scalar(0, 255, 0));
  EXPECT_EQ(GreenToRed(1.0), cv::Scalar(0, 0, 255));
  EXPECT_EQ(GreenToRed(7.0), GreenToRed(1.0));
  EXPECT_EQ(NearToFar(0.0), cv::Scalar(0, 0, 255));
  EXPECT_EQ(NearToFar(1.0), cv::Scalar(255, 0, 0));
}

TEST(Pictures, TracksAreColouredByLengthWithTheirVelocity) {
  FeatureTracks tracks;
  tracks.tracks = {TrackAt(100, 50, 1), TrackAt(200, 120, 40)};
  const cv::Mat picture = DrawTracks(GreyImage(), tracks);
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_EQ(picture.cols, 400);
  EXPECT_TRUE(IsNear(At(picture, 100, 50), GreenToRed(0.0)));
  EXPECT_TRUE(IsNear(At(picture, 200, 120), GreenToRed(1.0)));
  EXPECT_GT(At(picture, 212, 120)[0], 150) << "a blue line ahead";
  EXPECT_TRUE(IsNear(At(picture, 300, 30), cv::Scalar::all(90)));
}

TEST(Pictures, DepthsAreColouredAndMissingOnesGrey) {
  FeatureTracks tracks;
  tracks.tracks = {TrackAt(100, 50, 2), TrackAt(200, 120, 2)};
  const VisualDepths depths = {{DepthStatus::kOk, 50.0, 0.1}, {DepthStatus::kGrazing, 0.0, 0.0}};
  const std::vector<Eigen::Vector3f> points = {{50.0f, -16.6f, 0.0f}, {-5.0f, 0.0f, 0.0f}};
  const Calibration calibration = TestCalibration();
  const cv::Mat picture =
      DrawDepths(GreyImage(), tracks, depths, points, calibration.camera, calibration.T_cam_lidar);
  EXPECT_TRUE(IsNear(At(picture, 100, 50), NearToFar(1.0)));
  EXPECT_TRUE(IsNear(At(picture, 200, 123), cv::Scalar::all(150)));
  EXPECT_GT(At(picture, 300, 100)[0], At(picture, 300, 100)[2]) << "the lidar's point, faint";
  EXPECT_THROW(
      DrawDepths(GreyImage(), tracks, {}, points, calibration.camera, calibration.T_cam_lidar),
      Error);
}

TEST(Pictures, TopViewPutsForwardUpOrEastRight) {
  const TopView forward({100, 100}, 1.0, {50.0, 50.0}, TopView::Orientation::kForwardUp);
  EXPECT_EQ(forward.Pixel(0, 0), Eigen::Vector2d(50, 50));
  EXPECT_EQ(forward.Pixel(20, 10), Eigen::Vector2d(40, 30)) << "ahead is up, left is left";
  const TopView map({100, 100}, 2.0, {-10.0, 30.0}, TopView::Orientation::kEastRight);
  EXPECT_EQ(map.Pixel(0, 0), Eigen::Vector2d(20, 60));
  EXPECT_EQ(map.Pixel(5, 10), Eigen::Vector2d(30, 40));
}

TEST(Pictures, SegmentsByLabel) {
  SegmentedScan scan;
  scan.points = {{20.0f, 10.0f, -1.7f}, {30.0f, 0.0f, 0.0f}, {10.0f, -20.0f, 0.0f}};
  scan.label = {kLabelGround, kFirstClusterLabel, kLabelOutlier};
  scan.clusters = 1;
  scan.image.rows = 2;
  scan.image.columns = 4;
  scan.image.point = {-1, 1, -1, -1, -1, 0, 2, -1};
  scan.image.range_m = {0, 30, 0, 0, 0, 22, 22, 0};
  const cv::Mat picture = DrawSegments(scan);
  const int strip = 6;  // two rows of three pixels above
  EXPECT_TRUE(IsNear(At(picture, 450, 1), GreenToRed(0.0)));
  EXPECT_TRUE(IsNear(At(picture, 600, strip + 200), GreenToRed(0.0)));
  EXPECT_GT(At(picture, 500, strip + 300)[1], 100);  // ground
  EXPECT_GT(At(picture, 800, strip + 400)[0], 200);  // outlier, blue
  EXPECT_NO_THROW(DrawSegments(SegmentedScan()));
}

TEST(Pictures, FeaturesWithAndWithoutImage) {
  LaserFeatures features;
  LaserFeature sharp;
  sharp.p_lidar = {20.0f, 2.0f, 1.0f};
  features.sharp = {sharp};
  FeatureTracks tracks;
  tracks.tracks = {TrackAt(100, 50, 2)};
  const VisualDepths depths = {{DepthStatus::kOk, 10.0, 0.1}};
  const Calibration calibration = TestCalibration();
  const cv::Mat both = DrawFeatures(GreyImage(), features, tracks, depths, calibration);
  const int left = 400;  // the image is centred over a wider view
  EXPECT_TRUE(IsNear(At(both, left + 170, 85), cv::Scalar(40, 40, 255)));
  EXPECT_TRUE(IsNear(At(both, left + 100, 50), cv::Scalar(0, 230, 255)));
  EXPECT_TRUE(IsNear(At(both, 580, 200 + 300), cv::Scalar(40, 40, 255)));
  const cv::Mat lidar_only = DrawFeatures(cv::Mat(), features, {}, {}, calibration);
  EXPECT_EQ(both.rows - lidar_only.rows, 200);
}

TEST(Pictures, MapFitsItsDrive) {
  MapCloud map;
  for (int i = 0; i < 1000; ++i) {
    map.points.emplace_back(0.5f * static_cast<float>(i), i % 2 ? 8.0f : -8.0f, 4.0f);
  }
  const std::vector<Eigen::Vector3d> driven = {{0, 0, 0}, {250, 0, 0}, {499, 0, 0}};
  const cv::Mat picture = DrawMap(map, driven);
  EXPECT_LE(picture.cols, 1600);
  EXPECT_GT(picture.cols, 1500);
  cv::Mat white;
  cv::inRange(picture, cv::Scalar::all(250), cv::Scalar::all(255), white);
  EXPECT_GT(cv::countNonZero(white.rowRange(0, 200)), 1500) << "the driven line";
  EXPECT_NO_THROW(DrawMap({}, {}));
}

}  // namespace
}  // namespace tvl
