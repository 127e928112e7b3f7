#include "tvl/geometry/elevation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tvl {
namespace {

TEST(RaiseElevation, TurnsUpAndKeepsRangeAndAzimuth) {
  const Eigen::Vector3f p(3.0f, -4.0f, 1.0f);
  const Eigen::Vector3f q = RaiseElevation({p}, 0.1)[0];
  EXPECT_NEAR(q.norm(), p.norm(), 1e-5);
  EXPECT_NEAR(std::atan2(q.y(), q.x()), std::atan2(p.y(), p.x()), 1e-6);
  EXPECT_NEAR(std::asin(q.z() / q.norm()) - std::asin(p.z() / p.norm()), 0.1, 1e-5);
}

}  // namespace
}  // namespace tvl
