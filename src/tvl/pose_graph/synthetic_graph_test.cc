#include "tvl/pose_graph/synthetic_graph.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/pose_graph/test_graphs.h"

namespace tvl {
namespace {

SyntheticGraphOptions Small() {
  SyntheticGraphOptions options;
  options.poses = 1500;
  options.loops = 60;
  options.false_loops = 20;
  return options;
}

TEST(SyntheticGraph, HasWhatWasAskedForInDrivingOrder) {
  const SyntheticGraph drive = MakeSyntheticGraph(Small());
  EXPECT_EQ(drive.truth.size(), 1500U);
  EXPECT_EQ(drive.graph.odometry.size(), 1499U);
  ASSERT_EQ(drive.graph.loops.size(), 80U);
  int false_loops = 0;
  for (size_t k = 0; k < 80; ++k) {
    const PoseConstraint& c = drive.graph.loops[k];
    EXPECT_LE(drive.graph.loops[k > 0 ? k - 1 : 0].to, c.to);
    EXPECT_LT(c.from, c.to);
    const Rigid3d truth = drive.truth[c.from].Inverse() * drive.truth[c.to];
    false_loops += drive.is_false_loop[k];
    const double off_m = (truth.t() - c.T_from_to.t()).norm();
    EXPECT_TRUE(drive.is_false_loop[k] ? off_m > 5.0 : off_m < 0.5) << off_m;
  }
  EXPECT_EQ(false_loops, 20);
  for (size_t k = 1; k < drive.truth.size(); ++k) {
    EXPECT_NEAR((drive.truth[k].t() - drive.truth[k - 1].t()).norm(), 1.0, 0.35);
  }
}

TEST(SyntheticGraph, OnlyTheSeedDecides) {
  const SyntheticGraph a = MakeSyntheticGraph(Small()), b = MakeSyntheticGraph(Small());
  SyntheticGraphOptions other = Small();
  other.seed = 2;
  EXPECT_THAT(a.graph.T_world.back(), Rigid3dNear(b.graph.T_world.back(), 0.0, 0.0));
  EXPECT_GT((a.truth.back().t() - MakeSyntheticGraph(other).truth.back().t()).norm(), 1.0);
}

TEST(SyntheticGraph, RmseIgnoresWhereTheWorldLies) {
  Rng rng(1);
  const SyntheticGraph drive = MakeSyntheticGraph(Small());
  const Rigid3d T_other_world = RandomMotion(&rng, 1.0, 50.0);
  std::vector<Rigid3d> moved;
  for (size_t k = 0; k < drive.truth.size(); ++k) {
    const double side_m = k % 2 == 0 ? 0.1 : -0.1;
    moved.push_back(T_other_world * Rigid3d::Translation(0, 0, side_m) * drive.truth[k]);
  }
  EXPECT_NEAR(AlignedRmse(moved, drive.truth), 0.1, 1e-3);
}

TEST(SyntheticGraph, ImpossibleWishesAreNamed) {
  SyntheticGraphOptions options;
  options.poses = 100;
  EXPECT_THROW(MakeSyntheticGraph(options), InputError);
  options.odometry_rotation_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
