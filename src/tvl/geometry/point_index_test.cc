#include "tvl/geometry/point_index.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

TEST(PointIndex, AgreesWithBruteForce) {
  Rng rng(11);
  const auto random_point = [&] {
    return Eigen::Vector3f(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                           static_cast<float>(rng.Normal()));
  };
  std::vector<Eigen::Vector3f> points(500);
  for (auto& p : points) p = random_point();
  const PointIndex index(points);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3f q = random_point();
    std::vector<float> d;
    for (const auto& p : points) d.push_back((p - q).squaredNorm());
    std::sort(d.begin(), d.end());
    Neighbour found[5];
    ASSERT_EQ(index.Nearest(q, 5, found), 5u);
    for (size_t k = 0; k < 5; ++k) EXPECT_FLOAT_EQ(found[k].distance_sq_m2, d[k]);
  }
}

TEST(PointIndex, EmptyFindsNothing) {
  Neighbour found[2];
  EXPECT_EQ(PointIndex().Nearest({0, 0, 0}, 2, found), 0u);
}

}  // namespace
}  // namespace tvl
