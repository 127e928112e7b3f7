// What was found of the camera's extrinsics, in words.
#pragma once

#include <string>

#include "tvl/registration/extrinsic_calibration.h"

namespace tvl {

// The rotation about a camera axis (0 right, 1 down, 2 forward) was told by the data, not by what
// extrinsics are usually off by (`prior_rad`).
bool IsObserved(const ExtrinsicEstimate& estimate, int axis, double prior_rad);

// For `tvl calibrate`, a line an axis: what was wrong by how much, what could not be told.
std::string CalibrationText(const ExtrinsicEstimate& estimate, double prior_rad);

// One line without its end: "the images are taken 31 +- 4 ms after the scan's instant".
std::string DelayText(const CameraOffsetEstimate& offset);
// Of one camera axis: "where the camera sits across: 0.050 +- 0.010 m further left than ...".
std::string PlaceText(const CameraOffsetEstimate& offset, int axis);

}  // namespace tvl
