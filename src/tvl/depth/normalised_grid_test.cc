#include "tvl/depth/normalised_grid.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

TEST(NormalisedGrid, FindsWhatBruteForceFinds) {
  Rng rng(4);
  std::vector<ProjectedPoint> points;
  for (int i = 0; i < 3000; ++i) {
    points.push_back({static_cast<float>(rng.Uniform(-1.3, 1.3)),
                      static_cast<float>(rng.Uniform(-0.5, 0.5)), static_cast<float>(i), 0, 0});
  }
  const NormalisedRect bounds{-1.0f, -0.3f, 1.1f, 0.4f};
  const NormalisedGrid grid(points, bounds, 0.02f, 0.013f);
  for (int query = 0; query < 300; ++query) {
    const float x = static_cast<float>(rng.Uniform(-1.1, 1.2));
    const float y = static_cast<float>(rng.Uniform(-0.4, 0.5));
    const float w = static_cast<float>(rng.Uniform(0.0, 0.08));
    const NormalisedRect rect{x - w, y - w, x + w, y + w};
    std::vector<float> found, expected;
    grid.ForEach(rect, [&](const ProjectedPoint& p) { found.push_back(p.depth_m); });
    for (const ProjectedPoint& p : points) {
      if (bounds.Contains(p.x, p.y) && rect.Contains(p.x, p.y)) expected.push_back(p.depth_m);
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(NormalisedGrid, EmptyAndDegenerate) {
  const NormalisedGrid none({}, {0, 0, 1, 1}, 0.1f, 0.1f);
  EXPECT_EQ(none.size(), 0u);
  const NormalisedGrid flat({{0.5f, 0.5f, 1.0f, 0, 0}}, {0.5f, 0.5f, 0.5f, 0.5f}, 0.1f, 0.1f);
  int found = 0;
  flat.ForEach({0, 0, 1, 1}, [&](const ProjectedPoint&) { ++found; });
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace tvl
