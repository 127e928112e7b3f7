#include "tvl/sim/drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/io/temp_folder.h"
#include "tvl/io/test_data.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/sim/sim_dataset.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

SimOptions Preset(const std::string& preset, int frames, uint64_t seed = 3) {
  SimOptions options;
  options.preset = preset, options.frames = frames, options.seed = seed;
  return options;
}

Rigid3d At(const Drive& drive, int frame) {
  return drive.T_world_lidar.At(frame * kFrameInterval_s);
}

double Yaw(const Rigid3d& T) {
  const Vector3d x = T.q() * Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

class PresetTest : public ::testing::TestWithParam<const char*> {};

// Real dynamics: nobody is thrown out of his seat.
TEST_P(PresetTest, DrivesLikeACar) {
  const Drive drive = PlanDrive(Preset(GetParam(), 400), Rigid3d());
  double fastest = 0.0, hardest = 0.0, turn = 0.0, tilt = 0.0;
  for (int k = 1; k < 399; ++k) {
    const Vector3d a = At(drive, k - 1).t(), b = At(drive, k).t(), c = At(drive, k + 1).t();
    fastest = std::max(fastest, (c - b).norm() / 0.1);
    hardest = std::max(hardest, (c - 2 * b + a).norm() / 0.01);
    turn = std::max(turn, (At(drive, k).Inverse() * At(drive, k + 1)).RotationAngle() / 0.1);
    tilt = std::max(tilt, std::acos((At(drive, k).q() * Vector3d::UnitZ()).z()));
  }
  EXPECT_GT(fastest, 7.0);
  EXPECT_LT(fastest, 20.0);
  EXPECT_LT(hardest, 4.5) << "m/s^2";
  EXPECT_LT(turn, 0.8) << "rad/s";
  EXPECT_LT(tilt, 0.08);
  EXPECT_GT(tilt, 0.001);
}

INSTANTIATE_TEST_SUITE_P(All, PresetTest,
                         ::testing::Values("city", "loop", "reverse", "traffic", "aliasing",
                                           "nightloop", "lateloop", "tunnel", "open"));

TEST(DriveTest, SeedsGiveDifferentRoutes) {
  const Drive a = PlanDrive(Preset("city", 300, 1), Rigid3d());
  const Drive b = PlanDrive(Preset("city", 300, 2), Rigid3d());
  const Drive again = PlanDrive(Preset("city", 300, 1), Rigid3d());
  EXPECT_GT((At(a, 250).t() - At(b, 250).t()).norm(), 3.0);
  EXPECT_EQ(At(a, 250).t(), At(again, 250).t());
}

// First frame at which the drive is back on a street it has driven in the same direction.
int FirstBack(const Drive& drive) {
  for (int k = 100; k < drive.frames; ++k) {
    for (int j = 0; j + 80 < k; ++j) {
      if (drive.travel.Way_m(0.1 * k) - drive.travel.Way_m(0.1 * j) < 60.0) continue;  // a stop
      const double turn = std::remainder(Yaw(At(drive, k)) - Yaw(At(drive, j)), 2 * M_PI);
      const double distance = (At(drive, k).t() - At(drive, j).t()).head<2>().norm();
      if (distance < 5.0 && std::abs(turn) < 0.5) return k;
    }
  }
  return drive.frames;
}

TEST(DriveTest, LoopsCloseWhenTheyShould) {
  EXPECT_NEAR(FirstBack(PlanDrive(Preset("loop", 600), Rigid3d())), 360, 12);
  EXPECT_NEAR(FirstBack(PlanDrive(Preset("nightloop", 600), Rigid3d())), 300, 12);
  EXPECT_NEAR(FirstBack(PlanDrive(Preset("lateloop", 600), Rigid3d())), 580, 12);
}

// How far a frame lies to the left of the nearest of the first 100 frames; NaN if none is near.
double LeftOfFirstPass(const Drive& drive, int frame) {
  const Vector3d p = At(drive, frame).t();
  int best = -1;
  double nearest_m = 6.0;
  for (int j = 0; j < 100; ++j) {
    const double distance = (At(drive, j).t() - p).head<2>().norm();
    if (distance < nearest_m) nearest_m = distance, best = j;
  }
  return best < 0 ? std::nan("") : (At(drive, best).Inverse() * p).y();
}

TEST(DriveTest, LaterPassLeadsBesideTheFirst) {
  SimOptions options = Preset("loop", 600);
  const Drive usual = PlanDrive(options, Rigid3d());
  options.lateral_m = 2.0;
  const Drive drive = PlanDrive(options, Rigid3d());
  EXPECT_LT((At(drive, 100).t() - At(usual, 100).t()).norm(), 0.02);
  int back = 0;
  double hardest = 0.0;
  for (int k = 1; k < 599; ++k) {
    const double left = k > 365 ? LeftOfFirstPass(drive, k) : std::nan("");
    if (!std::isnan(left)) {
      EXPECT_NEAR(left, 2.0, 0.4) << k;
      ++back;
    }
    const Vector3d a = At(drive, k - 1).t(), b = At(drive, k).t(), c = At(drive, k + 1).t();
    hardest = std::max(hardest, (c - 2 * b + a).norm() / 0.01);
  }
  EXPECT_GT(back, 50);
  EXPECT_LT(hardest, 4.5) << "m/s^2";
}

TEST(DriveTest, ReverseComesBackTheOtherWay) {
  const Drive drive = PlanDrive(Preset("reverse", 1000), Rigid3d());
  int opposite = 0;
  for (int k = 500; k < 1000; k += 5) {
    for (int j = 0; j < 500; j += 2) {
      const double turn = std::remainder(Yaw(At(drive, k)) - Yaw(At(drive, j)), 2 * M_PI);
      if ((At(drive, k).t() - At(drive, j).t()).head<2>().norm() < 4.5 && std::abs(turn) > 2.6) {
        ++opposite;
        break;
      }
    }
  }
  EXPECT_GT(opposite, 30) << "of 100 places";
}

TEST(DriveTest, NightloopIsDarkInItsSecondLap) {
  const Drive drive = PlanDrive(Preset("nightloop", 600), Rigid3d());
  EXPECT_FALSE(drive.night.Contains(299));
  EXPECT_TRUE(drive.night.Contains(300));
  EXPECT_TRUE(drive.night.Contains(599));
}

TEST(DriveTest, TunnelIsStraightLevelAndHasAStop) {
  const Drive drive = PlanDrive(Preset("tunnel", 500), Rigid3d());
  double slowest = 1e9, fastest = 0.0, aside = 0.0;
  for (int k = 0; k < 500; ++k) {
    const double way = drive.travel.Way_m(0.1 * k), speed = drive.travel.Speed_m_s(0.1 * k);
    if (way < drive.route.tunnel_begin_m + 10 || way > drive.route.tunnel_end_m - 10) continue;
    slowest = std::min(slowest, speed), fastest = std::max(fastest, speed);
    aside = std::max(aside, std::abs(At(drive, k).t().y() - At(drive, 0).t().y()));
  }
  EXPECT_LT(slowest, 0.1);
  EXPECT_GT(fastest, 9.0);
  EXPECT_LT(aside, 0.05);
  EXPECT_NEAR(drive.route.tunnel_end_m - drive.route.tunnel_begin_m, 200.0, 1e-9);
}

TEST(DriveTest, TunnelFramesBecomeAPlaceOnTheRoute) {
  SimOptions options = Preset("city", 300);
  options.tunnel = {100, 150};
  options.open = {200, 250};
  const Drive drive = PlanDrive(options, Rigid3d());
  EXPECT_DOUBLE_EQ(drive.route.tunnel_begin_m, drive.travel.Way_m(10.0));
  EXPECT_DOUBLE_EQ(drive.route.tunnel_end_m, drive.travel.Way_m(15.0));
  ASSERT_EQ(drive.open_m.size(), 1U);
  EXPECT_DOUBLE_EQ(drive.open_m[0].first, drive.travel.Way_m(20.0));
}

// A circle driven twice by camera 0, its height drifting, followed closely and at one height.
TEST(DriveTest, FollowsAPoseFile) {
  Eigen::Matrix3d R_cam_lidar;
  R_cam_lidar << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Rigid3d T_cam_lidar(Eigen::Quaterniond(R_cam_lidar), Vector3d(0, -0.08, -0.27));
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 700; ++i) {
    const double angle = 4 * M_PI * i / 700.0, r = 50.0;
    const Rigid3d T_world_lidar(
        Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitZ())),
        Vector3d(r * std::sin(angle), r - r * std::cos(angle), 1.0 * i / 700.0));
    poses.push_back(T_cam_lidar * T_world_lidar * T_cam_lidar.Inverse());
  }
  const TempFolder folder;
  WriteKittiPoses(folder / "poses.txt", poses);
  SimOptions options = Preset("city", 0);
  options.trajectory_file = folder / "poses.txt";
  const Drive drive = PlanDrive(options, T_cam_lidar);
  ASSERT_EQ(drive.frames, 700);
  for (int k = 10; k < 340; k += 10) {
    const Rigid3d expected = poses[0].Inverse() * poses[static_cast<size_t>(k)];
    const Rigid3d driven =
        (At(drive, 0) * T_cam_lidar.Inverse()).Inverse() * At(drive, k) * T_cam_lidar.Inverse();
    EXPECT_THAT(driven, Rigid3dNear(expected, 0.01, 0.9)) << k;
    EXPECT_NEAR(At(drive, k).t().z(), At(drive, k + 350).t().z(), 0.03) << "same place, twice";
    EXPECT_LT((At(drive, k).t() - At(drive, k + 350).t()).norm(), 0.1);
  }
}

TEST(DriveTest, BadPoseFileIsNamed) {
  const TempFolder folder;
  SimOptions options = Preset("city", 0);
  options.trajectory_file = folder.Write("short.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THROW(PlanDrive(options, Rigid3d()), InputError);
  options.trajectory_file = folder / "none.txt";
  EXPECT_THROW(PlanDrive(options, Rigid3d()), InputError);
}

TEST(DriveTest, FollowsKittiPoses) {
  const auto path = TestDataPath("trajectories/kitti_06.txt");
  if (!path) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  const std::vector<Rigid3d> poses = ReadKittiPoses(*path);
  SimOptions options = Preset("city", 0);
  options.trajectory_file = *path;
  const Drive drive = PlanDrive(options, SensorsFor(options).calibration.T_cam0_lidar);
  ASSERT_EQ(static_cast<size_t>(drive.frames), poses.size());
  double travelled = 0.0, given = 0.0;
  for (int k = 1; k < drive.frames; ++k) {
    const auto i = static_cast<size_t>(k);
    travelled += (At(drive, k).t() - At(drive, k - 1).t()).norm();
    given += (poses[i].t() - poses[i - 1].t()).norm();
  }
  EXPECT_NEAR(travelled, given, 0.003 * given);
}

}  // namespace
}  // namespace tvl::sim
