#include "tvl/sim/site.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/rng.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;

bool Contains(const Footprint& f, const Vector2d& p) {
  const Vector2d d = p - f.centre, left(-f.along.y(), f.along.x());
  return std::abs(d.dot(f.along)) <= f.half_length_m && std::abs(d.dot(left)) <= f.half_width_m;
}

Footprint Random(Rng* rng) {
  const double yaw = rng->Uniform(0, 6.28);
  return {{rng->Uniform(-5, 5), rng->Uniform(-5, 5)},
          {std::cos(yaw), std::sin(yaw)},
          rng->Uniform(0.5, 3.0),
          rng->Uniform(0.5, 2.0)};
}

// Against points sampled densely inside one of the two.
TEST(FootprintTest, OverlapAgreesWithSampling) {
  Rng rng(7);
  int overlaps = 0;
  for (int k = 0; k < 500; ++k) {
    const Footprint a = Random(&rng), b = Random(&rng);
    bool shared = false;
    const Vector2d left(-a.along.y(), a.along.x());
    for (double u = -1.0; u <= 1.0; u += 0.02) {
      for (double v = -1.0; v <= 1.0; v += 0.02) {
        shared = shared ||
                 Contains(b, a.centre + u * a.half_length_m * a.along + v * a.half_width_m * left);
      }
    }
    if (shared) {
      EXPECT_TRUE(Overlap(a, b)) << k;
    }
    // Sampling may miss a sliver; a real overlap survives a little shrinking.
    Footprint smaller = b;
    smaller.half_length_m -= 0.1, smaller.half_width_m -= 0.1;
    if (!shared) {
      EXPECT_FALSE(Overlap(a, smaller)) << k;
    }
    overlaps += shared ? 1 : 0;
  }
  EXPECT_GT(overlaps, 50);
  EXPECT_LT(overlaps, 450);
}

class SiteTest : public ::testing::Test {
 protected:
  SiteTest() : prototypes_(BuildPrototypes(1)), site_(route_, terrain_, {}, prototypes_, &town_) {}

  static Route StraightStreet() {
    const Polyline axis = Polyline({{0, 0}, {100, 0}}).Resampled(0.5);
    Route route;
    route.lane = axis.Shifted(-kLaneOffset_m);
    route.axes = {axis};
    return route;
  }
  bool Place(double x, double y, double half = 1.0) {
    const Vector2d p(x, y);
    return site_.TryPlace(prototypes_.bin.first, p, Vector2d::UnitX(),
                          {p, Vector2d::UnitX(), half, half}, {1.9, 3.0, true});
  }

  Route route_ = StraightStreet();
  Terrain terrain_;
  Prototypes prototypes_;
  SceneDescription town_;
  Site site_;
};

TEST_F(SiteTest, KeepsLaneAndStreetFree) {
  EXPECT_FALSE(Place(50, -kLaneOffset_m)) << "on the lane";
  EXPECT_FALSE(Place(50, 3.9)) << "too close to the axis";
  EXPECT_FALSE(Place(50, -4.5)) << "its edge is 1.8 m from the lane";
  EXPECT_TRUE(Place(50, 4.1));
  EXPECT_TRUE(Place(50, -4.8));
  EXPECT_EQ(town_.instances.size(), 2U);
}

TEST_F(SiteTest, PutsNothingOnTopOfAnother) {
  EXPECT_TRUE(Place(30, 9));
  EXPECT_FALSE(Place(31.5, 9));
  EXPECT_TRUE(Place(32.5, 9));
}

TEST_F(SiteTest, ThingsStandOnTheGround) {
  ASSERT_TRUE(Place(30, 7));
  EXPECT_NEAR(town_.instances[0].T_world_object.t().z(), ProfileHeight({}, 7.0), 1e-9);
}

}  // namespace
}  // namespace tvl::sim
