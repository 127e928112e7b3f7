#include "tvl/report/calibration_text.h"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "tvl/base/units.h"

namespace tvl {
namespace {

// Of the standard deviation that was assumed: with more left the data has hardly spoken.
constexpr double kObservedShare = 0.5;

// A positive rotation of the calibration means that the camera points ...
struct Direction {
  const char *name, *positive, *negative;
};
constexpr Direction kDirections[] = {
    {"up and down", "lower", "higher"},
    {"left and right", "further left", "further right"},
    {"about its axis", "anticlockwise", "clockwise"},
};

}  // namespace

bool IsObserved(const ExtrinsicEstimate& estimate, int axis, double prior_rad) {
  return estimate.sigma_rad[axis] < kObservedShare * prior_rad;
}

std::string CalibrationText(const ExtrinsicEstimate& estimate, double prior_rad) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(2);
  for (int axis = 0; axis < 3; ++axis) {
    const Direction& direction = kDirections[axis];
    const double angle_deg = RadToDeg(estimate.rotation_rad[axis]);
    const double sigma_deg = RadToDeg(estimate.sigma_rad[axis]);
    out << direction.name << ": ";
    if (!IsObserved(estimate, axis, prior_rad)) {
      out << "not told by this drive (sigma " << sigma_deg << " deg)\n";
      continue;
    }
    out << (axis == 2 ? "the camera is turned " : "the camera points ") << std::abs(angle_deg)
        << " deg " << (angle_deg > 0.0 ? direction.positive : direction.negative)
        << (axis == 2 ? " against what" : " than") << " the calibration says (sigma " << sigma_deg
        << " deg)\n";
  }
  if (!estimate.applied_rad.isZero(0.0)) {
    out << "corrected by " << RadToDeg(estimate.applied_rad.norm()) << " deg in all\n";
  } else {
    out << "that is within what this drive can tell: the calibration is left as it is\n";
  }
  out << "not looked for: where the camera sits, and the delay of its images\n";
  return out.str();
}

}  // namespace tvl
