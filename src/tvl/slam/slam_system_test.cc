#include "tvl/slam/slam_system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/slam/test_drive.h"

namespace tvl {
namespace {

using synthetic::Drive;
using synthetic::DriveOptions;

struct Outcome {
  std::vector<FrameResult> frames;
  Trajectory trajectory;
  Map map;
};

Outcome Play(const Drive& drive, Deskew deskew, const SlamOptions& options, int threads = 1) {
  const Executor executor(threads);
  SlamSystem system(drive.setup(), deskew, options);
  Outcome outcome;
  for (size_t i = 0; i < drive.size(); ++i) {
    outcome.frames.push_back(system.ProcessFrame(drive.Frame(i), executor));
  }
  outcome.trajectory = system.trajectory();
  outcome.map = system.map();
  return outcome;
}

SlamOptions LidarOnly() {
  SlamOptions options;
  options.use_camera = false;
  return options;
}

DriveOptions Options(size_t frames, bool camera) {
  DriveOptions options;
  options.frames = frames;
  options.camera = camera;
  return options;
}

double WorstError_m(const Drive& drive, const Outcome& outcome) {
  double worst_m = 0.0;
  for (size_t i = 0; i < outcome.frames.size(); ++i) {
    const Eigen::Vector3d error = outcome.frames[i].T_world_lidar.t() - drive.Truth(i).t();
    worst_m = std::max(worst_m, error.norm());
  }
  return worst_m;
}

class SlamSystemOn : public ::testing::TestWithParam<Deskew> {};

TEST_P(SlamSystemOn, FollowsTheDriveWithTheLidar) {
  DriveOptions options = Options(25, false);
  options.spin = GetParam();
  const Drive drive(options);
  const Outcome outcome = Play(drive, GetParam(), LidarOnly());
  // The first raw scan, too, must be compensated by the motion found later: else 0.35 m.
  EXPECT_LT(WorstError_m(drive, outcome), 0.03);
  EXPECT_EQ(outcome.frames[0].status, FrameStatus::kFirst);
  for (size_t i = 1; i < outcome.frames.size(); ++i) {
    EXPECT_EQ(outcome.frames[i].status, FrameStatus::kTracked) << "frame " << i;
    EXPECT_GT(outcome.frames[i].map_step.estimate.evidence.planes, 100);
  }
  EXPECT_GE(outcome.map.keyframes.size(), 12u);
  EXPECT_EQ(outcome.trajectory.size(), 25u);
}

INSTANTIATE_TEST_SUITE_P(CompensatedAndRaw, SlamSystemOn,
                         ::testing::Values(Deskew::kNone, Deskew::kClockwise,
                                           Deskew::kCounterClockwise));

TEST(SlamSystem, UsesTheCameraBesideTheLidar) {
  const Drive drive(Options(12, true));
  const Outcome outcome = Play(drive, Deskew::kNone, SlamOptions());
  EXPECT_LT(WorstError_m(drive, outcome), 0.10);
  for (size_t i = 2; i < outcome.frames.size(); ++i) {
    EXPECT_EQ(outcome.frames[i].tracking, TrackingStatus::kTracked);
    EXPECT_GT(outcome.frames[i].tracks, 100);
    EXPECT_GT(outcome.frames[i].tracks_with_depth, 50);
    EXPECT_GT(outcome.frames[i].odometry.evidence.visual, 50);
    EXPECT_GT(outcome.frames[i].map_step.estimate.evidence.visual, 30);
  }
}

// Paper 5.2: between map steps the pose is T_map(m) T_odo(m)^-1 T_odo(k).
TEST(SlamSystem, BetweenMapStepsOdometryCarriesThePose) {
  const Drive drive(Options(18, false));
  SlamOptions options = LidarOnly();
  options.mapping.interval = 5;
  const Outcome outcome = Play(drive, Deskew::kNone, options);
  Rigid3d T_map_m, T_odo_m, T_odo;
  for (size_t k = 0; k < outcome.frames.size(); ++k) {
    const FrameResult& frame = outcome.frames[k];
    if (k > 0) T_odo = T_odo * frame.odometry.T_ref_body;
    if (k % 5 == 0) {
      EXPECT_EQ(frame.map_step.estimate.status == EstimateStatus::kFirst, k == 0);
      T_map_m = frame.T_world_lidar;
      T_odo_m = T_odo;
      continue;
    }
    EXPECT_EQ(frame.map_step.estimate.status, EstimateStatus::kFirst) << "not due";
    EXPECT_THAT(frame.T_world_lidar, Rigid3dNear(T_map_m * T_odo_m.Inverse() * T_odo, 1e-9, 1e-9));
  }
  EXPECT_LT(WorstError_m(drive, outcome), 0.20);
  // The map step says something of its own.
  EXPECT_GT((T_map_m.Inverse() * T_odo_m).t().norm(), 1e-4);
}

int EstimatedScanToScan(const Outcome& outcome) {
  return static_cast<int>(
      std::count_if(outcome.frames.begin(), outcome.frames.end(), [](const FrameResult& frame) {
        return frame.odometry.status == EstimateStatus::kConverged ||
               frame.odometry.status == EstimateStatus::kNotConverged;
      }));
}

TEST_P(SlamSystemOn, WithoutOdometryTheMapStepBeginsWithThePrediction) {
  DriveOptions options = Options(12, false);
  options.spin = GetParam();
  const Drive drive(options);
  SlamOptions without = LidarOnly();
  without.odometry.enabled = false;
  const Outcome outcome = Play(drive, GetParam(), without);
  EXPECT_LT(WorstError_m(drive, outcome), 0.03);
  EXPECT_EQ(EstimatedScanToScan(outcome), 1) << "only the first motion";
  EXPECT_EQ(outcome.frames.back().status, FrameStatus::kTracked);
}

TEST(SlamSystem, WhereNoMapStepFollowsOdometryIsNeeded) {
  const Drive drive(Options(11, false));
  SlamOptions options = LidarOnly();
  options.odometry.enabled = false;
  options.mapping.interval = 5;
  const Outcome outcome = Play(drive, Deskew::kNone, options);
  EXPECT_EQ(EstimatedScanToScan(outcome), 8) << "all but the first, and the map steps 5 and 10";
  EXPECT_LT(WorstError_m(drive, outcome), 0.20);
}

TEST(SlamSystem, AFrameWithNothingIsBridgedByPrediction) {
  DriveOptions options = Options(18, true);
  options.without_scan = {10};
  options.without_image = {10};
  const Drive drive(options);
  const Outcome outcome = Play(drive, Deskew::kNone, SlamOptions());
  EXPECT_EQ(outcome.frames[10].status, FrameStatus::kPredicted);
  EXPECT_FALSE(outcome.frames[10].is_keyframe);
  const Rigid3d step = outcome.frames[8].T_world_lidar.Inverse() * outcome.frames[9].T_world_lidar;
  EXPECT_THAT(outcome.frames[10].T_world_lidar,
              Rigid3dNear(outcome.frames[9].T_world_lidar * step, 1e-9, 1e-9));
  EXPECT_GT(outcome.frames[10].step_covariance(3, 3), outcome.frames[9].step_covariance(3, 3));
  for (size_t i = 11; i < outcome.frames.size(); ++i) {
    EXPECT_EQ(outcome.frames[i].status, FrameStatus::kTracked) << "frame " << i;
  }
  EXPECT_LT(WorstError_m(drive, outcome), 0.10);
}

TEST(SlamSystem, AFrameWithOnlyAnImageIsTrackedByTheCameraAlone) {
  DriveOptions options = Options(14, true);
  options.without_scan = {9};
  const Drive drive(options);
  const Outcome outcome = Play(drive, Deskew::kNone, SlamOptions());
  EXPECT_EQ(outcome.frames[9].status, FrameStatus::kDegraded);
  EXPECT_EQ(outcome.frames[9].odometry.evidence.planes, 0);
  EXPECT_GT(outcome.frames[9].odometry.evidence.visual, 50);
  EXPECT_FALSE(outcome.frames[9].is_keyframe);
  EXPECT_LT(WorstError_m(drive, outcome), 0.10);
}

TEST(SlamSystem, StartsLateWhenTheFirstFramesHaveNoScan) {
  DriveOptions options = Options(14, false);
  options.without_scan = {0, 1};
  const Drive drive(options);
  const Outcome outcome = Play(drive, Deskew::kNone, LidarOnly());
  EXPECT_EQ(outcome.frames[1].status, FrameStatus::kPredicted);
  ASSERT_FALSE(outcome.map.keyframes.empty());
  EXPECT_EQ(outcome.frames.back().status, FrameStatus::kTracked);
  // From the first pair of scans on the motion is right; before it is unknown.
  const Rigid3d T_4_last =
      outcome.frames[4].T_world_lidar.Inverse() * outcome.frames.back().T_world_lidar;
  EXPECT_THAT(T_4_last, Rigid3dNear(drive.Truth(4).Inverse() * drive.Truth(13), 0.01, 0.15));
}

TEST(SlamSystem, StandingStillStaysInPlace) {
  DriveOptions options = Options(8, false);
  options.speed_m_s = 0.0;
  options.sway_m = 0.0;
  const Drive drive(options);
  const Outcome outcome = Play(drive, Deskew::kNone, LidarOnly());
  EXPECT_LT(WorstError_m(drive, outcome), 0.02);
  EXPECT_EQ(outcome.map.keyframes.size(), 1u);
}

TEST(SlamSystem, AStampThatStandsStillIsSurvived) {
  const Drive drive(Options(6, false));
  SlamSystem system(drive.setup(), Deskew::kNone, LidarOnly());
  for (size_t i = 0; i < drive.size(); ++i) {
    SensorFrame frame = drive.Frame(i);
    if (i == 4) frame.stamp = drive.Frame(3).stamp;
    const FrameResult result = system.ProcessFrame(frame, Executor(1));
    EXPECT_TRUE(result.T_world_lidar.t().allFinite());
    EXPECT_LT((result.T_world_lidar.t() - drive.Truth(i).t()).norm(), 0.1);
  }
}

TEST(SlamSystem, FaultsOfTheInputArePassedOn) {
  const Drive drive(Options(1, false));
  SensorFrame frame = drive.Frame(0);
  frame.faults.push_back({FrameFault::Kind::kBlackImage, "frame 0"});
  SlamSystem system(drive.setup(), Deskew::kNone, LidarOnly());
  ASSERT_EQ(system.ProcessFrame(frame, Executor(1)).faults.size(), 1u);
}

// Every byte of what a run leaves behind.
std::string Bytes(const Outcome& outcome) {
  std::string bytes;
  const auto append = [&](const void* data, size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  for (const StampedPose& pose : outcome.trajectory) {
    append(pose.T_world_lidar.q().coeffs().data(), 4 * sizeof(double));
    append(pose.T_world_lidar.t().data(), 3 * sizeof(double));
  }
  for (const FrameResult& frame : outcome.frames) {
    append(frame.step_covariance.data(), 36 * sizeof(double));
  }
  const MapCloud cloud = BuildMapCloud(outcome.map, 0.1);
  for (const Eigen::Vector3f& p : cloud.points) append(p.data(), 3 * sizeof(float));
  return bytes;
}

TEST(SlamSystem, IsTheSameToTheByteForAnyThreadCount) {
  DriveOptions options = Options(10, true);
  options.spin = Deskew::kClockwise;
  const Drive drive(options);
  const std::string one = Bytes(Play(drive, Deskew::kClockwise, SlamOptions(), 1));
  EXPECT_GT(one.size(), 100000u);
  EXPECT_TRUE(one == Bytes(Play(drive, Deskew::kClockwise, SlamOptions(), 2)));
}

TEST(SlamOptions, NameTheBadField) {
  SlamOptions options;
  options.mapping.interval = 0;
  EXPECT_THROW(SlamSystem(Drive(DriveOptions()).setup(), Deskew::kNone, options), InputError);
}

}  // namespace
}  // namespace tvl
