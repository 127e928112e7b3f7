#include "tvl/lidar/ground.h"

#include <gtest/gtest.h>

#include "tvl/lidar/range_image.h"
#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

using test::Box;
using test::Plane;
using test::Surface;

// Share of the points of each surface that come out as ground.
struct Shares {
  std::vector<double> of_surface;
  GroundResult result;
};

Shares GroundShares(const std::vector<Surface>& world, LidarModel model = test::Hdl64(),
                    double noise_m = 0.02) {
  test::SimulatedScan sim = test::Scan(world, model, noise_m);
  // Carries the surface through the range image as the intensity.
  for (size_t i = 0; i < sim.surface.size(); ++i) {
    sim.scan.intensity[i] = static_cast<float>(sim.surface[i]);
  }
  const ScanGeometry geometry = ComputeScanGeometry(sim.scan);
  RingAssignment rings;
  rings.row = sim.ring;
  rings.rows = model.rows();
  const SegmentedScan scan = BuildRangeImage(sim.scan, geometry, rings, model, Deskew::kNone).scan;
  Shares shares;
  shares.result = FindGround(scan, GroundOptions{});
  std::vector<double> points(world.size(), 0.0), ground(world.size(), 0.0);
  for (size_t i = 0; i < scan.size(); ++i) {
    const size_t s = static_cast<size_t>(scan.intensity[i]);
    points[s] += 1.0;
    ground[s] += shares.result.is_ground[i];
  }
  for (size_t s = 0; s < world.size(); ++s) {
    shares.of_surface.push_back(points[s] > 0.0 ? ground[s] / points[s] : -1.0);
  }
  return shares;
}

Surface Road() { return Plane({0, 0, 1}, -1.73); }

TEST(Ground, RoadButNotWhatStandsOnIt) {
  const Shares shares = GroundShares({
      Road(), Box({8, -4, -1.73}, {12, -2, -0.3}),  // a car: side, hood and roof
      Box({-15, 3, -1.73}, {-5, 5, -0.9}),          // a low hedge whose top is seen
      Plane({0, 1, 0}, 12.0),                       // a facade
      Box({6, 1, -1.73}, {6.2, 1.2, 2.0}),          // a pole
      Box({20, -1, -1.73}, {24.5, 1, 0.2}),         // a van ahead
  });
  EXPECT_NEAR(shares.result.seed.c, -1.73, 0.02);
  EXPECT_GT(shares.of_surface[0], 0.98);
  EXPECT_LT(shares.of_surface[1], 0.03);
  EXPECT_LT(shares.of_surface[2], 0.06);  // its foot, within the noise of the road
  EXPECT_LT(shares.of_surface[3], 0.03);
  EXPECT_LT(shares.of_surface[4], 0.10);
  EXPECT_LT(shares.of_surface[5], 0.05);
}

TEST(Ground, SlopeIsMeasuredAgainstTheGroundNotTheSensor) {
  // The whole world 8 deg nose up: a car on a ramp.
  const double c = std::cos(DegToRad(8.0)), s = std::sin(DegToRad(8.0));
  const Shares shares = GroundShares({Plane({s, 0, c}, -1.73), Plane({0, 1, 0}, 8.0)});
  EXPECT_GT(shares.of_surface[0], 0.97);
  EXPECT_LT(shares.of_surface[1], 0.03);
}

TEST(Ground, HillThatRisesSmoothlyIsFollowed) {
  // Level to 10 m, then 4, 8 and 12 deg in steps of 10 m: no step exceeds 10 deg.
  std::vector<Surface> world = {
      Plane({0, 0, 1}, -1.73, [](const Eigen::Vector3d& p) { return p.x() <= 10.0; })};
  double x = 10.0, z = -1.73;
  for (int k = 1; k <= 3; ++k) {
    const double slope = std::tan(DegToRad(4.0 * k));
    const Eigen::Vector3d n(-slope, 0, 1);
    world.push_back(Plane(n, n.dot(Eigen::Vector3d(x, 0, z)), [=](const Eigen::Vector3d& p) {
      return p.x() > x && p.x() <= x + 10.0;
    }));
    z += 10.0 * slope;
    x += 10.0;
  }
  const Shares shares = GroundShares(world);
  for (const double share : shares.of_surface) EXPECT_GT(share, 0.9);
}

TEST(Ground, SteepBankIsNoGround) {
  for (const double bank_deg : {20.0, 35.0}) {
    const double slope = std::tan(DegToRad(bank_deg));
    const Eigen::Vector3d n(0, -slope, 1);
    const Shares shares = GroundShares(
        {Plane({0, 0, 1}, -1.73, [](const Eigen::Vector3d& p) { return p.y() <= 6.0; }),
         Plane(n, n.dot(Eigen::Vector3d(0, 6, -1.73)),
               [](const Eigen::Vector3d& p) { return p.y() > 6.0; })});
    EXPECT_GT(shares.of_surface[0], 0.98);
    // Along the street the rays meet the bank at a slant, where it rises less than 10 deg.
    EXPECT_LT(shares.of_surface[1], bank_deg > 30.0 ? 0.15 : 0.4) << bank_deg << " deg";
  }
}

TEST(Ground, KerbAndPavementAreGround) {
  const Shares shares =
      GroundShares({Plane({0, 0, 1}, -1.73, [](const Eigen::Vector3d& p) { return p.y() <= 4.0; }),
                    Plane({0, 0, 1}, -1.60, [](const Eigen::Vector3d& p) { return p.y() > 4.0; })});
  EXPECT_GT(shares.of_surface[0], 0.98);
  EXPECT_GT(shares.of_surface[1], 0.95);
}

TEST(Ground, NarrowPavementBetweenKerbAndWall) {
  const Shares shares =
      GroundShares({Plane({0, 0, 1}, -1.73, [](const Eigen::Vector3d& p) { return p.y() <= 4.0; }),
                    Plane({0, 0, 1}, -1.58, [](const Eigen::Vector3d& p) { return p.y() > 4.0; }),
                    Plane({0, 1, 0}, 5.0)},
                   test::Hdl64(), 0.01);
  EXPECT_GT(shares.of_surface[1], 0.38);  // the last ring before the wall runs on into it
  EXPECT_LT(shares.of_surface[2], 0.03);
}

TEST(Ground, LowestRingsSeeTheOwnCarOnly) {
  // The own hood close below the sensor hides the lowest third of the rings all round.
  const Shares shares = GroundShares({Road(), Box({-2.2, -2.2, -0.9}, {2.2, 2.2, -0.75})});
  EXPECT_NEAR(shares.result.seed.c, -1.73, 0.03);
  EXPECT_GT(shares.of_surface[0], 0.97);
  EXPECT_LT(shares.of_surface[1], 0.01);
}

TEST(Ground, BehindObstaclesTheGroundGoesOn) {
  // A row of low boxes hides 6 to 14 m on all of the front; behind it the road is seen again.
  const Shares shares = GroundShares({Road(), Box({6, -20, -1.73}, {6.5, 20, -1.0})});
  EXPECT_GT(shares.of_surface[0], 0.95);
}

TEST(Ground, RisingGroundBehindAnObstacleIsReachedFromItsSides) {
  // Up 6 deg from 6 m on; a box hides the first 7 m of it in the columns ahead, where the road is
  // 0.9 m higher when it is seen again.
  const double slope = std::tan(DegToRad(6.0));
  const Eigen::Vector3d n(-slope, 0, 1);
  const Shares shares = GroundShares(
      {Plane({0, 0, 1}, -1.73, [](const Eigen::Vector3d& p) { return p.x() <= 6.0; }),
       Plane(n, n.dot(Eigen::Vector3d(6, 0, -1.73)),
             [](const Eigen::Vector3d& p) { return p.x() > 6.0 && std::abs(p.y()) < 12.0; }),
       Box({5.5, -2, -1.73}, {6, 2, -0.9})});
  EXPECT_GT(shares.of_surface[1], 0.95);
  EXPECT_LT(shares.of_surface[2], 0.08);
}

TEST(Ground, NoneInAShaft) {
  const Shares shares = GroundShares({Plane({1, 0, 0}, 5.0), Plane({1, 0, 0}, -5.0),
                                      Plane({0, 1, 0}, 5.0), Plane({0, 1, 0}, -5.0)});
  EXPECT_FALSE(shares.result.seed.found);
  EXPECT_EQ(shares.result.count, 0);
}

}  // namespace
}  // namespace tvl
