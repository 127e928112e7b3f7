#include "tvl/odometry/laser_matcher.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::Moving;
using synthetic::Twist;

constexpr double kPeriod_s = 0.1;
const Rigid3d kMotion = Rigid3d::Exp(Twist(0.01, -0.01, 0.08, 1.2, 0.2, -0.05));

LaserFeatures Features(const Rigid3d& T_prev_cur, Deskew spin, uint64_t seed, double noise_m) {
  return synthetic::SampleFeatures(synthetic::Street(), Moving(Rigid3d(), T_prev_cur, kPeriod_s),
                                   spin, {noise_m, seed});
}

LaserMatcher MakeMatcher(double noise_m) {
  const LaserFeatures previous = Features(Rigid3d(), Deskew::kNone, 1, noise_m);
  return LaserMatcher(RingCloud(synthetic::PointsOf(previous.less_sharp), previous.less_sharp),
                      RingCloud(synthetic::PointsOf(previous.less_flat), previous.less_flat));
}

double MaxDistance(const LaserMatches& matches, const Rigid3d& T) {
  double largest = 0.0;
  for (const PlaneMatch& match : matches.planes) {
    const Eigen::Vector3d p = T * match.factor.p_body;
    largest = std::max(largest, std::abs(match.factor.n_ref.dot(p - match.factor.q_ref)));
  }
  for (const LineMatch& match : matches.lines) {
    const Eigen::Vector3d p = T * match.factor.p_body;
    largest = std::max(largest, match.factor.d_ref.cross(p - match.factor.q_ref).norm());
  }
  return largest;
}

TEST(PrepareSweep, TakesPointsToTheMiddleOfTheirBin) {
  const SweepBins bins = SweepBins::Raw();
  const LaserFeatures features = Features(kMotion, Deskew::kClockwise, 2, 0.0);
  const SweepFeatures sweep = PrepareSweep(features, bins, kPeriod_s, kMotion);
  ASSERT_EQ(sweep.flat.size(), features.flat.size());
  ASSERT_EQ(sweep.sharp.size(), features.sharp.size());
  double largest_m = 0.0;
  for (size_t i = 0; i < sweep.flat.size(); ++i) {
    const LaserFeature& feature = features.flat[i];
    const Rigid3d T_at = Scale(1.0 + feature.time_offset_s / kPeriod_s, kMotion);
    const Rigid3d T_bin = Scale(bins.Share(sweep.flat[i].bin), kMotion);
    const Eigen::Vector3d expected = T_at * feature.p_lidar.cast<double>();
    largest_m = std::max(largest_m, (T_bin * sweep.flat[i].p_body - expected).norm());
  }
  EXPECT_LT(largest_m, 1e-3);
}

TEST(PrepareSweep, LeavesCompensatedPointsAlone) {
  const LaserFeatures features = Features(kMotion, Deskew::kNone, 2, 0.0);
  const SweepFeatures sweep = PrepareSweep(features, SweepBins::Compensated(), kPeriod_s, kMotion);
  for (size_t i = 0; i < sweep.sharp.size(); ++i) {
    EXPECT_EQ(sweep.sharp[i].p_body, features.sharp[i].p_lidar.cast<double>());
    EXPECT_EQ(sweep.sharp[i].bin, 0);
  }
}

TEST(LaserMatcher, MatchesLieOnTheirSurfacesAtTheTruth) {
  const SweepBins bins = SweepBins::Compensated();
  const LaserFeatures features = Features(kMotion, Deskew::kNone, 2, 0.0);
  LaserMatcher matcher = MakeMatcher(0.0);
  const SweepFeatures sweep = PrepareSweep(features, bins, kPeriod_s, kMotion);
  const LaserMatches matches = matcher.Match(sweep, bins, kMotion, 1.0, LaserMatchOptions());
  EXPECT_GT(matches.planes.size(), features.flat.size() / 2);
  EXPECT_GT(matches.lines.size(), features.sharp.size() / 3);
  // Where surfaces meet, a fit may take points of both and still pass as flat to 10 cm.
  int off = 0;
  for (const PlaneMatch& match : matches.planes) {
    const Eigen::Vector3d p = kMotion * match.factor.p_body;
    off += std::abs(match.factor.n_ref.dot(p - match.factor.q_ref)) > 0.02;
  }
  EXPECT_LT(off, static_cast<int>(matches.planes.size()) / 20);
}

TEST(LaserMatcher, TheGateHolds) {
  const SweepBins bins = SweepBins::Compensated();
  const LaserFeatures features = Features(kMotion, Deskew::kNone, 2, 0.02);
  LaserMatcher matcher = MakeMatcher(0.02);
  const SweepFeatures sweep = PrepareSweep(features, bins, kPeriod_s, Rigid3d());
  size_t last = 100000;
  for (const double gate_m : {2.0, 0.5, 0.1}) {
    const LaserMatches matches = matcher.Match(sweep, bins, Rigid3d(), gate_m, {});
    EXPECT_LT(matches.planes.size() + matches.lines.size(), last);
    last = matches.planes.size() + matches.lines.size();
  }
  EXPECT_LT(MaxDistance(matcher.Match(sweep, bins, Rigid3d(), 0.1, {}), Rigid3d()), 0.4);
}

TEST(LaserMatcher, RemembersItsFits) {
  const SweepBins bins = SweepBins::Compensated();
  const SweepFeatures sweep =
      PrepareSweep(Features(kMotion, Deskew::kNone, 2, 0.02), bins, kPeriod_s, kMotion);
  LaserMatcher used = MakeMatcher(0.02), fresh = MakeMatcher(0.02);
  used.Match(sweep, bins, Rigid3d(), 2.0, {});
  const LaserMatches again = used.Match(sweep, bins, kMotion, 0.5, {});
  const LaserMatches first = fresh.Match(sweep, bins, kMotion, 0.5, {});
  ASSERT_EQ(again.planes.size(), first.planes.size());
  for (size_t i = 0; i < first.planes.size(); ++i) {
    EXPECT_EQ(again.planes[i].factor.n_ref, first.planes[i].factor.n_ref);
    EXPECT_EQ(again.planes[i].factor.q_ref, first.planes[i].factor.q_ref);
  }
}

TEST(LaserMatcher, NothingToMatchAgainstGivesNothing) {
  LaserMatcher matcher{RingCloud(), RingCloud()};
  const SweepBins bins = SweepBins::Compensated();
  const SweepFeatures sweep =
      PrepareSweep(Features(kMotion, Deskew::kNone, 2, 0.02), bins, kPeriod_s, kMotion);
  const LaserMatches matches = matcher.Match(sweep, bins, kMotion, 1.0, {});
  EXPECT_TRUE(matches.planes.empty() && matches.lines.empty());
}

TEST(LaserMatchOptions, NameTheBadField) {
  LaserMatchOptions options;
  options.plane_sigma_m = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
