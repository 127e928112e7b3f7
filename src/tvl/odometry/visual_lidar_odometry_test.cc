#include "tvl/odometry/visual_lidar_odometry.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/lidar/deskew.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::Moving;
using synthetic::Observe;
using synthetic::Twist;
using synthetic::World;

constexpr double kPeriod_s = 0.1;

MotionGuess Known(const Rigid3d& T_prev_cur) {
  Vector6d variance;  // 0.01 rad, 0.05 m
  variance << Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(2.5e-3);
  return {T_prev_cur, variance.asDiagonal(), true};
}

// Frames k and k+1 of a drive; which sensors deliver is up to the test.
struct Scene {
  World world = synthetic::Street();
  Deskew spin = Deskew::kNone;
  Rigid3d T_prev_cur;
  std::vector<Eigen::Vector3d> corners;
  PreprocessedFrame previous, current;

  Scene(const Rigid3d& motion, Deskew s, World w = synthetic::Street())
      : world(std::move(w)), spin(s), T_prev_cur(motion) {
    corners = synthetic::Corners(world, motion, 200, 5);
    previous = Frame(Rigid3d(), 1);
    current = Frame(motion, 2);
  }
  PreprocessedFrame Frame(const Rigid3d& T_world_lidar, uint64_t seed) const {
    const Rigid3d T_before = T_world_lidar * T_prev_cur.Inverse();
    PreprocessedFrame frame;
    frame.has_scan = frame.has_image = true;
    frame.features = synthetic::SampleFeatures(world, Moving(T_before, T_prev_cur, kPeriod_s), spin,
                                               {0.02, seed});
    See(Observe(corners, T_world_lidar, {0.3, 0.01, 2, seed}), &frame);
    return frame;
  }
  static void See(const synthetic::Seen& seen, PreprocessedFrame* frame) {
    frame->tracks = seen.tracks;
    frame->depths = seen.depths;
  }
  SweepBins bins() const {
    return spin == Deskew::kNone ? SweepBins::Compensated() : SweepBins::Raw();
  }
  MotionEstimate Estimate(const MotionGuess& guess, const OdometryOptions& options = {},
                          int threads = 1) const {
    VisualLidarOdometry odometry(synthetic::CameraAndLidar(), options);
    odometry.Advance(previous, Compensated(previous.features.less_sharp),
                     Compensated(previous.features.less_flat));
    return odometry.Estimate(current, guess, bins(), kPeriod_s, Executor(threads));
  }

 private:
  std::vector<Eigen::Vector3f> Compensated(const std::vector<LaserFeature>& features) const {
    std::vector<float> offset_s;
    for (const LaserFeature& feature : features) offset_s.push_back(feature.time_offset_s);
    return DeskewPoints(synthetic::PointsOf(features), offset_s, T_prev_cur, kPeriod_s);
  }
};

const Rigid3d kMotion = Rigid3d::Exp(Twist(0.005, -0.004, 0.05, 1.1, 0.05, 0.01));
const Rigid3d kLastMotion = Rigid3d::Exp(Twist(0.0, 0.0, 0.045, 1.06, 0.03, 0.0));

OdometryOptions LidarOnly() {
  OdometryOptions options;
  options.use_camera = false;
  return options;
}

class OdometryOf : public ::testing::TestWithParam<Deskew> {};

TEST_P(OdometryOf, FindsTheMotion) {
  const Scene scene(kMotion, GetParam());
  const MotionEstimate both = scene.Estimate(Known(kLastMotion));
  EXPECT_EQ(both.status, EstimateStatus::kConverged);
  EXPECT_THAT(both.T_ref_body, Rigid3dNear(kMotion, 0.002, 0.02));
  EXPECT_GT(both.evidence.planes, 400);
  EXPECT_GT(both.evidence.edges, 20);
  EXPECT_GT(both.evidence.visual, 60);
  const MotionEstimate lidar = scene.Estimate(Known(kLastMotion), LidarOnly());
  EXPECT_THAT(lidar.T_ref_body, Rigid3dNear(kMotion, 0.002, 0.03));
  EXPECT_EQ(lidar.evidence.visual, 0);
}

// A raw scan taken for a compensated one, or for one that spins the other way, must show.
TEST_P(OdometryOf, TimesOfPointsMatter) {
  if (GetParam() == Deskew::kNone) return;
  Scene scene(kMotion, GetParam());
  const auto error_m = [&] {
    const MotionEstimate estimate = scene.Estimate(Known(kLastMotion), LidarOnly());
    return (estimate.T_ref_body.t() - kMotion.t()).norm();
  };
  const double right_m = error_m();
  for (auto* features : {&scene.current.features.flat, &scene.current.features.sharp}) {
    for (LaserFeature& feature : *features) feature.time_offset_s *= -1.0f;
  }
  EXPECT_GT(error_m(), 2.0 * right_m);
}

INSTANTIATE_TEST_SUITE_P(CompensatedAndRaw, OdometryOf,
                         ::testing::Values(Deskew::kNone, Deskew::kClockwise,
                                           Deskew::kCounterClockwise));

class OdometryAtStart : public ::testing::TestWithParam<double> {};

TEST_P(OdometryAtStart, FindsTheSpeedFromNothing) {
  const Rigid3d motion = Rigid3d::Exp(Twist(0.0, 0.002, 0.01, GetParam(), 0.0, 0.0));
  const Scene scene(motion, Deskew::kNone);
  const MotionEstimate estimate = scene.Estimate(MotionGuess());
  EXPECT_NE(estimate.status, EstimateStatus::kPredicted);
  EXPECT_THAT(estimate.T_ref_body, Rigid3dNear(motion, 0.003, 0.04));
}

INSTANTIATE_TEST_SUITE_P(Speeds, OdometryAtStart, ::testing::Values(0.0, 0.3, 1.0, 1.9, 2.5, 2.9));

TEST(Odometry, TheCameraAloneBridgesAMissingScan) {
  Scene scene(kMotion, Deskew::kNone);
  scene.current.has_scan = false;
  scene.current.features = {};
  const MotionEstimate estimate = scene.Estimate(Known(kLastMotion));
  EXPECT_NE(estimate.status, EstimateStatus::kPredicted);
  EXPECT_EQ(estimate.evidence.planes, 0);
  EXPECT_GT(estimate.evidence.visual, 60);
  EXPECT_THAT(estimate.T_ref_body, Rigid3dNear(kMotion, 0.003, 0.03));
}

TEST(Odometry, WithoutAnythingUsableItPredicts) {
  Scene scene(kMotion, Deskew::kNone);
  scene.current = {};
  const MotionEstimate estimate = scene.Estimate(Known(kLastMotion));
  EXPECT_EQ(estimate.status, EstimateStatus::kPredicted);
  EXPECT_THAT(estimate.T_ref_body, Rigid3dNear(kLastMotion, 1e-12, 1e-12));
  // A prediction is vaguer than a measurement.
  const Scene measured(kMotion, Deskew::kNone);
  EXPECT_GT(estimate.covariance(3, 3),
            3.0 * measured.Estimate(Known(kLastMotion)).covariance(3, 3));
}

TEST(Odometry, ResetForgetsTheReference) {
  VisualLidarOdometry odometry(synthetic::CameraAndLidar(), OdometryOptions());
  EXPECT_FALSE(odometry.has_previous());
  const Scene scene(kMotion, Deskew::kNone);
  odometry.Advance(scene.previous, synthetic::PointsOf(scene.previous.features.less_sharp),
                   synthetic::PointsOf(scene.previous.features.less_flat));
  EXPECT_TRUE(odometry.has_previous());
  odometry.Reset();
  EXPECT_FALSE(odometry.has_previous());
}

// Slow traffic: a lorry ahead keeps the distance and fills most of the image, its features stand
// still in it.
Scene BehindALorry(const Rigid3d& motion) {
  Scene scene(motion, Deskew::kNone);
  const auto street = synthetic::Corners(scene.world, motion, 70, 5);
  Rng rng(9);
  std::vector<Eigen::Vector3d> before = street, after = street;
  for (int i = 0; i < 160; ++i) {
    const Eigen::Vector3d p(9.0, rng.Uniform(-1.3, 1.3), rng.Uniform(-1.2, 1.8));
    before.push_back(p);
    after.push_back(motion * p);
  }
  Scene::See(Observe(before, Rigid3d(), {0.3, 0.01, 1, 1}), &scene.previous);
  Scene::See(Observe(after, motion, {0.3, 0.01, 1, 2}), &scene.current);
  return scene;
}

double ErrorBehindALorry_m(double step_m, double gate_sigmas) {
  const Rigid3d motion = Rigid3d::Exp(Twist(0.0, 0.0, 0.002, step_m, 0.0, 0.0));
  OdometryOptions options;
  options.visual_gate_sigmas = gate_sigmas;
  const MotionGuess guess = Known(Rigid3d::Translation(step_m, 0, 0));
  const Rigid3d T = BehindALorry(motion).Estimate(guess, options).T_ref_body;
  return (T.t() - motion.t()).norm();
}

TEST(Odometry, FeaturesOnAMovingLorryAreGatedAway) {
  const double gate = OdometryOptions().visual_gate_sigmas, no_gate = 1000.0;
  EXPECT_LT(ErrorBehindALorry_m(0.8, gate), 0.010);
  EXPECT_GT(ErrorBehindALorry_m(0.8, no_gate), 0.035);
}

TEST(Odometry, InSlowTrafficFeaturesOnALorryPullALittle) {
  // 0.2 m a frame move the features by half a pixel: the gate cannot tell, the weights limit it.
  EXPECT_LT(ErrorBehindALorry_m(0.2, OdometryOptions().visual_gate_sigmas), 0.030);
  const Rigid3d motion = Rigid3d::Exp(Twist(0.0, 0.0, 0.002, 0.2, 0.0, 0.0));
  const Rigid3d T_start = BehindALorry(motion).Estimate(MotionGuess()).T_ref_body;
  EXPECT_THAT(T_start, Rigid3dNear(motion, 0.002, 0.04));
}

TEST(Odometry, InATunnelTheCameraHoldsTheAxis) {
  const Rigid3d motion = Rigid3d::Exp(Twist(0.0, 0.0, 0.002, 1.2, 0.0, 0.0));
  const Rigid3d guess = Rigid3d::Translation(1.1, 0.0, 0.0);
  const Scene scene(motion, Deskew::kNone, synthetic::Tunnel());
  const MotionEstimate both = scene.Estimate(Known(guess));
  EXPECT_THAT(both.T_ref_body, Rigid3dNear(motion, 0.003, 0.04));
  const MotionEstimate lidar = scene.Estimate(Known(guess), LidarOnly());
  EXPECT_NEAR(lidar.T_ref_body.t().x(), 1.1, 0.02) << "the prediction decides";
  for (const MotionEstimate* estimate : {&both, &lidar}) {
    const auto weak = std::find_if(estimate->weak.begin(), estimate->weak.end(),
                                   [](const WeakDirection& w) { return !w.is_rotation; });
    ASSERT_NE(weak, estimate->weak.end());
    EXPECT_GT(std::abs(weak->axis_lidar.x()), std::cos(DegToRad(15.0)));
  }
  EXPECT_GT(lidar.covariance(3, 3), 3.0 * both.covariance(3, 3));
}

TEST(Odometry, IsTheSameToTheBitForAnyThreadCount) {
  const Scene scene(kMotion, Deskew::kClockwise);
  const MotionEstimate one = scene.Estimate(Known(kLastMotion), {}, 1);
  const MotionEstimate two = scene.Estimate(Known(kLastMotion), {}, 2);
  EXPECT_EQ(one.T_ref_body.Log(), two.T_ref_body.Log());
  EXPECT_EQ(one.covariance, two.covariance);
}

TEST(OdometryOptions, NameTheBadField) {
  OdometryOptions options;
  options.kernel_sigmas = 0.0;
  EXPECT_THROW(VisualLidarOdometry(synthetic::CameraAndLidar(), options), InputError);
}

}  // namespace
}  // namespace tvl
