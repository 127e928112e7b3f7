// Matchers for tests.
#pragma once

#include <gmock/gmock.h>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// |angle(T^-1 expected)| <= tolerance_rad and |difference of positions| <= tolerance_m.
MATCHER_P3(Rigid3dNear, expected, tolerance_rad, tolerance_m, "") {
  const Rigid3d delta = arg.Inverse() * expected;
  const double distance_m = (arg.t() - expected.t()).norm();
  *result_listener << "off by " << delta.RotationAngle() << " rad, " << distance_m << " m";
  return delta.RotationAngle() <= tolerance_rad && distance_m <= tolerance_m;
}

}  // namespace tvl
