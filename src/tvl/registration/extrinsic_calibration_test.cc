#include "tvl/registration/extrinsic_calibration.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::CameraAndLidar;

// Points beside and ahead of a road that runs along x, as corners of a camera.
class Drive {
 public:
  explicit Drive(uint64_t seed) : rng_(seed) {
    for (int i = 0; i < 12000; ++i) {
      const double side = rng_.Uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
      points_.emplace_back(rng_.Uniform(0.0, 450.0), side * rng_.Uniform(3.0, 20.0),
                           rng_.Uniform(-1.7, 6.0));
    }
  }

  // What a camera with the extrinsics sees, with noise of half a pixel.
  FeatureTracks See(const Rigid3d& T_world_lidar, const Rigid3d& T_cam_lidar) {
    const Camera camera = CameraAndLidar().camera;
    const Rigid3d T_cam_world = T_cam_lidar * T_world_lidar.Inverse();
    FeatureTracks tracks;
    for (size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d p_cam = T_cam_world * points_[i];
      if (p_cam.z() < 2.0 || p_cam.z() > 40.0) continue;
      const Eigen::Vector2d px = camera.Project(p_cam.hnormalized());
      if (px.x() < 0 || px.y() < 0 || px.x() > camera.width_px || px.y() > camera.height_px) {
        continue;
      }
      FeatureTrack track;
      track.id = static_cast<TrackId>(i);
      track.px_cam = px + 0.5 * Eigen::Vector2d(rng_.Normal(), rng_.Normal());
      track.ray_cam = camera.Unproject(track.px_cam);
      tracks.tracks.push_back(track);
    }
    return tracks;
  }

  // The pose after `way_m` on a winding road (driving straight on, roll would not be seen), and as
  // odometry with its errors has it.
  static Rigid3d At(double way_m) {
    const double yaw_rad = 0.3 * std::sin(way_m / 15.0);
    return Rigid3d(ExpSo3({0.0, 0.0, yaw_rad}),
                   Eigen::Vector3d(way_m, -4.5 * (std::cos(way_m / 15.0) - 1.0), 0.0));
  }
  Rigid3d Noisy(const Rigid3d& T) {
    Vector6d xi;
    for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? 1e-4 : 2e-3) * rng_.Normal();
    return T * Rigid3d::Exp(xi);
  }

  // Drives 400 m; true extrinsics are those given, turned by `error_rad`. Returns how often the
  // extrinsics changed.
  int Run(const Eigen::Vector3d& error_rad, ExtrinsicCalibration* calibration,
          double step_m = 1.0) {
    const Rigid3d T_cam_lidar =
        Rigid3d(ExpSo3(error_rad), Eigen::Vector3d::Zero()) * CameraAndLidar().T_cam_lidar;
    int changes = 0;
    for (double way_m = 0.0; way_m < 400.0; way_m += step_m) {
      const Rigid3d T = At(way_m);
      changes += calibration->Add(See(T, T_cam_lidar), Noisy(T));
    }
    return changes;
  }

 private:
  Rng rng_;
  std::vector<Eigen::Vector3d> points_;
};

TEST(ExtrinsicCalibration, FindsWhereTheCameraPoints) {
  for (const double size_deg : {0.15, 0.5, 2.0}) {
    const Eigen::Vector3d error_rad = DegToRad(size_deg) * Eigen::Vector3d(0.6, -0.6, 0.53);
    ExtrinsicCalibration calibration(CameraAndLidar(), ExtrinsicCalibrationOptions());
    EXPECT_GE(Drive(3).Run(error_rad, &calibration), 1);
    const ExtrinsicEstimate estimate = calibration.estimate();
    const Eigen::Vector3d applied_error_rad = estimate.applied_rad - error_rad;
    EXPECT_LT(applied_error_rad.head<2>().cwiseAbs().maxCoeff(), DegToRad(0.05)) << size_deg;
    EXPECT_LT(std::abs(applied_error_rad.z()), DegToRad(0.15)) << size_deg;
    EXPECT_LT((estimate.rotation_rad - error_rad).head<2>().cwiseAbs().maxCoeff(), DegToRad(0.04));
    EXPECT_LT(estimate.sigma_rad.head<2>().maxCoeff(), DegToRad(0.05)) << "and knows it";
    const Rigid3d T_given_found =
        CameraAndLidar().T_cam_lidar * calibration.T_cam_lidar().Inverse();
    EXPECT_NEAR(T_given_found.RotationAngle(), estimate.applied_rad.norm(), 1e-9);
  }
}

TEST(ExtrinsicCalibration, LeavesARightCalibrationAlone) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    ExtrinsicCalibration calibration(CameraAndLidar(), ExtrinsicCalibrationOptions());
    EXPECT_EQ(Drive(seed).Run(Eigen::Vector3d::Zero(), &calibration), 0) << seed;
  }
}

TEST(ExtrinsicCalibration, SaysNothingWithoutMotionAndAcrossABreak) {
  const Eigen::Vector3d error_rad(0.02, 0.0, 0.0);
  ExtrinsicCalibration standing(CameraAndLidar(), ExtrinsicCalibrationOptions());
  EXPECT_EQ(Drive(5).Run(error_rad, &standing, 0.05), 0) << "4 m take more than 30 frames";
  EXPECT_EQ(standing.estimate().windows, 0);
  EXPECT_GT(standing.estimate().sigma_rad.minCoeff(), DegToRad(0.25)) << "what is usual";

  ExtrinsicCalibration broken(CameraAndLidar(), ExtrinsicCalibrationOptions());
  Drive drive(5);
  for (double way_m = 0.0; way_m < 100.0; way_m += 1.0) {
    broken.Add(drive.See(Drive::At(way_m), CameraAndLidar().T_cam_lidar), Drive::At(way_m));
    if (static_cast<int>(way_m) % 3 == 0) broken.Forget();
  }
  EXPECT_EQ(broken.estimate().windows, 0);
}

// A fifth of the tracks move on their own.
TEST(ExtrinsicCalibration, OutlivesMovingThings) {
  const Eigen::Vector3d error_rad(0.006, -0.006, 0.0);
  const Rigid3d T_cam_lidar =
      Rigid3d(ExpSo3(error_rad), Eigen::Vector3d::Zero()) * CameraAndLidar().T_cam_lidar;
  ExtrinsicCalibration calibration(CameraAndLidar(), ExtrinsicCalibrationOptions());
  Drive drive(9);
  for (double way_m = 0.0; way_m < 400.0; way_m += 1.0) {
    FeatureTracks tracks = drive.See(Drive::At(way_m), T_cam_lidar);
    for (FeatureTrack& track : tracks.tracks) {
      if (track.id % 5 == 0) track.ray_cam.x() += 0.01 * way_m;  // overtakes on the right
    }
    calibration.Add(tracks, drive.Noisy(Drive::At(way_m)));
  }
  const Eigen::Vector3d left_rad = calibration.estimate().applied_rad - error_rad;
  EXPECT_LT(left_rad.head<2>().cwiseAbs().maxCoeff(), DegToRad(0.07));
}

// Poses that follow the wrong camera agree with it: they are those of the lidar as a lidar sees
// them whose mounting has the error, too.
Rigid3d Following(const Rigid3d& T_world_lidar, const Eigen::Vector3d& error_rad) {
  const Rigid3d T_cam_lidar = CameraAndLidar().T_cam_lidar;
  const Rigid3d T_right = Rigid3d(ExpSo3(error_rad), Eigen::Vector3d::Zero()) * T_cam_lidar;
  return T_world_lidar * T_right.Inverse() * T_cam_lidar;
}

TEST(ExtrinsicCalibration, LidarOnlyPosesTellWhatPosesThatFollowTheCameraHide) {
  for (const double error_deg : {0.9, -0.9}) {
    const Eigen::Vector3d error_rad(0.0, DegToRad(error_deg), 0.0);
    const Rigid3d T_cam_lidar =
        Rigid3d(ExpSo3(error_rad), Eigen::Vector3d::Zero()) * CameraAndLidar().T_cam_lidar;
    ExtrinsicCalibration calibration(CameraAndLidar(), ExtrinsicCalibrationOptions());
    Drive drive(7);
    double found_after_m = 0.0;
    for (double way_m = 0.0; way_m < 100.0; way_m += 1.0) {
      const Rigid3d T = Drive::At(way_m);
      const FeatureTracks tracks = drive.See(T, T_cam_lidar);
      if (found_after_m == 0.0) {
        EXPECT_FALSE(calibration.Add(tracks, Following(T, error_rad))) << "these hide it";
        EXPECT_LT(calibration.estimate().rotation_rad.norm(), DegToRad(0.1));
      } else {
        calibration.Add(tracks, drive.Noisy(T));  // in doubt they do not follow it any more
      }
      if (!calibration.WantsLidarOnly()) continue;
      if (calibration.AddLidarOnly(tracks, {drive.Noisy(T)})) found_after_m = way_m;
    }
    EXPECT_GT(found_after_m, 11.0);
    EXPECT_LT(found_after_m, 20.0);
    const Eigen::Vector3d left_rad = calibration.estimate().applied_rad - error_rad;
    EXPECT_LT(left_rad.head<2>().cwiseAbs().maxCoeff(), DegToRad(0.1));
    EXPECT_FALSE(calibration.RemainingError().isZero(0.0)) << "the rest stays in doubt";
    EXPECT_FALSE(calibration.WantsLidarOnly()) << "what was corrected has been checked, too";
  }
}

// What the direction of motion of the lidar is usually off by is no error of the camera.
TEST(ExtrinsicCalibration, LidarOnlyPosesLeaveWhatTheyDoNotTell) {
  for (const double bias_deg : {0.15, -0.15, 0.0}) {
    ExtrinsicCalibration calibration(CameraAndLidar(), ExtrinsicCalibrationOptions());
    Drive drive(8);
    const Eigen::Vector3d bias_rad(0.0, DegToRad(bias_deg), 0.0);
    for (double way_m = 0.0; way_m < 100.0; way_m += 1.0) {
      const Rigid3d T = Drive::At(way_m);
      const FeatureTracks tracks = drive.See(T, CameraAndLidar().T_cam_lidar);
      EXPECT_FALSE(calibration.AddLidarOnly(tracks, {Following(drive.Noisy(T), bias_rad)}));
    }
    EXPECT_FALSE(calibration.WantsLidarOnly());
    EXPECT_TRUE(calibration.RemainingError().isZero(0.0));
  }
}

// Tracks that all lie on one thing that moves are one window or two; and a pose that says of itself
// that it is not known tells nothing.
TEST(ExtrinsicCalibration, LidarOnlyPosesAreBelievedAsFarAsTheyAreKnown) {
  const Eigen::Vector3d error_rad(0.0, DegToRad(0.9), 0.0);
  LidarPose pose;
  pose.covariance = 0.1 * 0.1 * Matrix6d::Identity();
  ExtrinsicCalibration calibration(CameraAndLidar(), ExtrinsicCalibrationOptions());
  Drive drive(9);
  for (double way_m = 0.0; way_m < 100.0; way_m += 1.0) {
    pose.T_odom_lidar = Following(Drive::At(way_m), error_rad);
    const FeatureTracks tracks = drive.See(Drive::At(way_m), CameraAndLidar().T_cam_lidar);
    EXPECT_FALSE(calibration.AddLidarOnly(tracks, pose));
  }
  EXPECT_TRUE(calibration.WantsLidarOnly()) << "it goes on asking";
}

TEST(ExtrinsicCalibration, OptionsAreChecked) {
  ExtrinsicCalibrationOptions options;
  options.window_m = 0.0;
  EXPECT_THROW(options.Check(), InputError);
  options = {};
  options.prior_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
