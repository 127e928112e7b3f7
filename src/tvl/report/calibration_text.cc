#include "tvl/report/calibration_text.h"

#include <algorithm>
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
  out << DelayText(estimate.offset) << "\n";
  for (int axis = 0; axis < 3; ++axis) out << PlaceText(estimate.offset, axis) << "\n";
  return out.str();
}

std::string DelayText(const CameraOffsetEstimate& offset) {
  std::ostringstream out;
  if (offset.images == 0) return "the delay of the images: not told by this drive";
  out << std::fixed << std::setprecision(0);
  if (!IsDelayObserved(offset)) {
    out << "the delay of the images: not told by this drive (sigma " << 1e3 * offset.delay_sigma_s
        << " ms); it takes turns and changes of speed";
    return out.str();
  }
  out << "the images are taken " << 1e3 * std::abs(offset.delay_s) << " +- "
      << std::max(1.0, 1e3 * offset.delay_sigma_s) << " ms "
      << (offset.delay_s >= 0.0 ? "after" : "before") << " the scan's instant";
  if (offset.applied_delay_s != 0.0) out << ": allowed for";
  return out.str();
}

std::string PlaceText(const CameraOffsetEstimate& offset, int axis) {
  // Points that lie farther right than given are seen by a camera farther left.
  struct Side {
    const char *name, *positive, *negative;
  };
  constexpr Side kSides[] = {{"across", "further left", "further right"},
                             {"up and down", "higher", "lower"},
                             {"along the way", "further back", "further ahead"}};
  const Side& side = kSides[axis];
  std::ostringstream out;
  out << std::fixed << std::setprecision(3) << "where the camera sits " << side.name << ": ";
  if (!IsPlaceObserved(offset, axis)) {
    out << "not told by this drive (sigma " << offset.translation_sigma_m[axis] << " m)";
    return out.str();
  }
  const double place_m = offset.translation_m[axis];
  out << std::abs(place_m) << " +- " << offset.translation_sigma_m[axis] << " m "
      << (place_m > 0.0 ? side.positive : side.negative) << " than the calibration says";
  return out.str();
}

}  // namespace tvl
