#include "tvl/slam/calibration_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

using testing::HasSubstr;

Calibration RightCalibration() {
  Calibration calibration;
  calibration.camera.fx_px = calibration.camera.fy_px = 700.0;
  calibration.camera.cx_px = 600.0;
  calibration.camera.cy_px = 180.0;
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  calibration.T_cam_lidar = Rigid3d(R, Eigen::Vector3d(0.0, -0.08, -0.27));
  return calibration;
}

// What is said over `way_m` of a gently winding road by a camera that is as `right` says, with
// images of `image_scale` times the size.
std::string Drive(const Calibration& given, const Calibration& right, double image_scale,
                  double way_m = 30.0) {
  Rng rng(7);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 1500; ++i) {
    const double side = rng.Uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    points.emplace_back(rng.Uniform(0.0, 80.0), side * rng.Uniform(3.0, 15.0),
                        rng.Uniform(-1.7, 5.0));
  }
  CalibrationCheck check(given);
  for (double x = 0.0; x < way_m; x += 0.8) {
    const Rigid3d T_world_lidar(ExpSo3({0.0, 0.0, 0.1 * std::sin(x / 10.0)}), {x, 0.0, 0.0});
    const Rigid3d T_cam_world = right.T_cam_lidar * T_world_lidar.Inverse();
    FeatureTracks tracks;
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p_cam = T_cam_world * points[i];
      if (p_cam.z() < 2.0 || p_cam.z() > 40.0) continue;
      const Eigen::Vector2d px_cam = image_scale * right.camera.Project(p_cam.hnormalized()) +
                                     0.5 * Eigen::Vector2d(rng.Normal(), rng.Normal());
      tracks.tracks.push_back(
          {static_cast<TrackId>(i), 2, px_cam, px_cam, given.camera.Unproject(px_cam)});
    }
    const std::string said = check.Add(tracks, T_world_lidar);
    EXPECT_EQ(said.empty(), !check.has_contradiction());
    if (!said.empty()) return said;
  }
  return "";
}

TEST(CalibrationCheck, SaysNothingOfACalibrationThatIsRightOrNearlySo) {
  Calibration turned = RightCalibration();
  EXPECT_EQ(Drive(turned, turned, 1.0), "");
  turned.T_cam_lidar =
      Rigid3d(ExpSo3(DegToRad(3.0) * Eigen::Vector3d(0.6, -0.8, 0.0)), Eigen::Vector3d::Zero()) *
      turned.T_cam_lidar;
  EXPECT_EQ(Drive(turned, RightCalibration(), 1.0), "") << "ExtrinsicCalibration finds that";
}

TEST(CalibrationCheck, NamesTheMistake) {
  const Calibration right = RightCalibration();
  Calibration inverted = right;
  inverted.T_cam_lidar = right.T_cam_lidar.Inverse();
  EXPECT_THAT(Drive(inverted, right, 1.0), HasSubstr("if Tr is the inverse"));
  EXPECT_THAT(Drive(right, right, 0.5), HasSubstr("if the images are half the size"));
  EXPECT_THAT(Drive(right, right, 2.0), HasSubstr("if the images are twice the size"));
  EXPECT_EQ(Drive(inverted, right, 1.0, 3.0), "") << "not after three metres";
}

TEST(CalibrationCheck, SaysSoOfSomethingElseThatIsWrong) {
  Calibration upwards = RightCalibration();
  upwards.T_cam_lidar =
      Rigid3d(ExpSo3({DegToRad(-60.0), 0.0, 0.0}), Eigen::Vector3d::Zero()) * upwards.T_cam_lidar;
  const std::string said = Drive(upwards, RightCalibration(), 1.0);
  EXPECT_THAT(said, HasSubstr("contradict the lidar's motion"));
  EXPECT_THAT(said, testing::Not(HasSubstr("% fit if")));
}

TEST(CalibrationCheck, LooksAtThePrincipalPointOnce) {
  CalibrationCheck check(RightCalibration());
  EXPECT_THAT(check.CheckImage(600, 180), HasSubstr("(600, 180) px is far from the middle"));
  EXPECT_EQ(check.CheckImage(600, 180), "");
  EXPECT_EQ(CalibrationCheck(RightCalibration()).CheckImage(1242, 375), "");
  EXPECT_EQ(CalibrationCheck(RightCalibration()).CheckImage(1242, 290), "") << "sky cut off";
}

}  // namespace
}  // namespace tvl
