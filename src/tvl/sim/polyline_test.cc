#include "tvl/sim/polyline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;

TEST(PolylineTest, GoesOnStraightBeyondItsEnds) {
  const Polyline line({{0, 0}, {3, 0}, {3, 4}});
  EXPECT_DOUBLE_EQ(line.length_m(), 7.0);
  EXPECT_TRUE(line.At(-2).isApprox(Vector2d(-2, 0)));
  EXPECT_TRUE(line.At(5).isApprox(Vector2d(3, 2)));
  EXPECT_TRUE(line.At(10).isApprox(Vector2d(3, 7)));
  EXPECT_TRUE(line.Tangent(-5).isApprox(Vector2d(1, 0)));
  EXPECT_DOUBLE_EQ(line.Extended(10).length_m(), 27.0);
}

TEST(PolylineTest, ShiftedLinesKeepTheirDistance) {
  const Polyline line = RoundCorners({{0, 0}, {50, 0}, {50, 50}}, 10.0, 0.5);
  const Polyline left = line.Shifted(1.7);
  for (double s = 0.0; s < line.length_m(); s += 1.0) {
    double nearest = 1e9;
    for (const Vector2d& p : left.points()) nearest = std::min(nearest, (p - line.At(s)).norm());
    EXPECT_NEAR(nearest, 1.7, 0.05) << "at " << s;
  }
  EXPECT_TRUE(left.At(0).isApprox(Vector2d(0, 1.7)));
}

TEST(PolylineTest, RoundedCornersHaveTheRadius) {
  const double radius = 8.0;
  const Polyline line = RoundCorners({{0, 0}, {60, 0}, {60, -60}}, radius, 0.5);
  EXPECT_NEAR(line.length_m(), 120.0 - 2 * radius + 0.5 * kPi * radius, 0.05);
  const Vector2d centre(60 - radius, -radius);
  EXPECT_NEAR((line.At(60 - radius + 0.25 * kPi * radius) - centre).norm(), radius, 0.02);
}

// Shares of the segments and cells, against all segments one by one.
TEST(PolylineIndexTest, AgreesWithBruteForce) {
  Rng rng(5);
  std::vector<Polyline> lines;
  for (int l = 0; l < 5; ++l) {
    std::vector<Vector2d> points;
    for (int i = 0; i < 30; ++i) points.emplace_back(rng.Uniform(-80, 80), rng.Uniform(-80, 80));
    lines.emplace_back(points);
  }
  const double reach = 9.0;
  const PolylineIndex index(lines, reach);
  int found = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector2d p(rng.Uniform(-120, 120), rng.Uniform(-120, 120));
    double best = reach;
    for (const Polyline& line : lines) {
      for (size_t i = 0; i + 1 < line.points().size(); ++i) {
        const Vector2d a = line.points()[i], ab = line.points()[i + 1] - a;
        const double share = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
        best = std::min(best, (p - a - share * ab).norm());
      }
    }
    const PolylineHit hit = index.Nearest(p);
    if (best >= reach) {
      EXPECT_EQ(hit.line, -1);
      continue;
    }
    ++found;
    EXPECT_NEAR(hit.distance_m, best, 1e-9);
    const Vector2d foot = lines[static_cast<size_t>(hit.line)].At(hit.s_m);
    EXPECT_NEAR((foot - p).norm(), best, 1e-9);
  }
  EXPECT_GT(found, 500);
}

}  // namespace
}  // namespace tvl::sim
