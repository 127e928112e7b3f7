#include "tvl/eval/kitti_metric.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/eval/path_length.h"
#include "tvl/eval/test_paths.h"

namespace tvl {
namespace {

TEST(KittiMetric, PicksTheFramesOfTheDevelopmentKit) {
  // 1 m a frame, 0..250 m. A stretch of 100 m ends with the first frame MORE than 100 m ahead:
  // first + 101. Starts 0, 10, ..., 140 for 100 m (last 241), 0..40 for 200 m (last 241).
  const std::vector<Rigid3d> path = ConstantMotion(251, 1.0, 0.0);
  const std::vector<SegmentError> segments = KittiSegmentErrors(path, path);
  ASSERT_EQ(segments.size(), 15U + 5U);
  EXPECT_EQ(segments[0].first, 0U);
  EXPECT_EQ(segments[0].last, 101U);
  EXPECT_EQ(segments[0].length_m, 100.0);
  EXPECT_EQ(segments[1].last, 201U);
  EXPECT_EQ(segments[2].first, 10U);
  EXPECT_EQ(segments.back().first, 140U);
  EXPECT_NEAR(MeanError(segments).t_err_percent, 0.0, 1e-9);
}

TEST(KittiMetric, GoldenStraightLineScaleError) {
  // 1 % too long on a straight line: a stretch of 101 frames is 1.01 m off, of nominally 100 m.
  const std::vector<Rigid3d> truth = ConstantMotion(150, 1.0, 0.0);
  const KittiError error = MeanError(KittiSegmentErrors(truth, Scaled(truth, 1.01)));
  EXPECT_EQ(error.segments, 5U);  // starts 0..40
  EXPECT_NEAR(error.t_err_percent, 1.01, 1e-9);
  EXPECT_NEAR(error.r_err_deg_per_m, 0.0, 1e-9);
}

TEST(KittiMetric, GoldenYawDrift) {
  // Truth straight, estimate turns 0.01 deg a frame and goes 1 m along its heading: over 101 frames
  // the angle is 1.01 deg, and the position that of a circle's chord.
  const std::vector<Rigid3d> truth = ConstantMotion(130, 1.0, 0.0);
  const double turn_rad = DegToRad(0.01);
  const std::vector<Rigid3d> estimate = ConstantMotion(130, 1.0, turn_rad);
  const KittiError error = MeanError(KittiSegmentErrors(truth, estimate));
  EXPECT_NEAR(error.r_err_deg_per_m, 0.0101, 1e-9);
  EXPECT_NEAR(error.r_err_deg_per_100m(), 1.01, 1e-7);
  double x_m = 0.0, z_m = 0.0;  // sum of unit steps at angles 0, a, 2a, ...
  for (int i = 0; i < 101; ++i) {
    x_m += std::sin(i * turn_rad);
    z_m += std::cos(i * turn_rad);
  }
  EXPECT_NEAR(error.t_err_percent, std::hypot(x_m, z_m - 101.0), 1e-9);
}

TEST(KittiMetric, AKnownScaleErrorIsReadOnAnyPath) {
  Rng rng(3);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<Rigid3d> truth(1);
    while (truth.size() < 1500) {
      const Eigen::Vector3d turn_rad(0.002 * rng.Normal(), 0.01 * rng.Normal(), 0.0);
      truth.push_back(truth.back() *
                      Rigid3d(ExpSo3(turn_rad), Eigen::Vector3d(0, 0, rng.Uniform(0.4, 1.4))));
    }
    // Scale acts on the chord of a stretch, which is at most its length.
    for (const SegmentError& s : KittiSegmentErrors(truth, Scaled(truth, 1.01))) {
      const double chord_m = (truth[s.last].t() - truth[s.first].t()).norm();
      EXPECT_NEAR(s.t_err_m_per_m, 0.01 * chord_m / s.length_m, 1e-9);
    }
    // Another world changes nothing.
    const Rigid3d T(ExpSo3(Eigen::Vector3d(0.3, 1.0, -0.4)), Eigen::Vector3d(5, 6, 7));
    EXPECT_NEAR(MeanError(KittiSegmentErrors(truth, Moved(truth, T))).t_err_percent, 0.0, 1e-9);
  }
}

TEST(KittiMetric, ShortDrivesHaveNoFigure) {
  const std::vector<Rigid3d> path = ConstantMotion(50, 1.0, 0.0);
  EXPECT_EQ(MeanError(KittiSegmentErrors(path, path)).segments, 0U);
  EXPECT_THROW(KittiSegmentErrors(path, ConstantMotion(49, 1.0, 0.0)), Error);
}

TEST(KittiMetric, ByLengthSplitsTheSegments) {
  const std::vector<Rigid3d> truth = ConstantMotion(350, 1.0, 0.0);
  const auto by_length = MeanErrorByLength(KittiSegmentErrors(truth, Scaled(truth, 1.02)));
  EXPECT_NEAR(by_length[0].t_err_percent, 2.02, 1e-9);         // 101 frames of 100 m
  EXPECT_NEAR(by_length[1].t_err_percent, 2.0 * 1.005, 1e-9);  // 201 of 200 m
  EXPECT_EQ(by_length[3].segments, 0U);
}

}  // namespace
}  // namespace tvl
