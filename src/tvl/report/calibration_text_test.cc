#include "tvl/report/calibration_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/units.h"

namespace tvl {
namespace {

using testing::HasSubstr;

TEST(CalibrationText, SaysWhatWasWrongAndWhatWasNotTold) {
  ExtrinsicEstimate estimate;
  estimate.rotation_rad = {DegToRad(0.5), DegToRad(-0.25), DegToRad(0.1)};
  estimate.sigma_rad = {DegToRad(0.04), DegToRad(0.05), DegToRad(0.24)};
  estimate.applied_rad = estimate.rotation_rad;
  const double prior_rad = DegToRad(0.25);
  EXPECT_TRUE(IsObserved(estimate, 0, prior_rad));
  EXPECT_FALSE(IsObserved(estimate, 2, prior_rad));
  const std::string text = CalibrationText(estimate, prior_rad);
  EXPECT_THAT(text, HasSubstr("points 0.50 deg lower than the calibration says (sigma 0.04 deg)"));
  EXPECT_THAT(text, HasSubstr("points 0.25 deg further right than"));
  EXPECT_THAT(text, HasSubstr("about its axis: not told by this drive (sigma 0.24 deg)"));
  EXPECT_THAT(text, HasSubstr("corrected by 0.57 deg in all"));
  EXPECT_THAT(text, HasSubstr("not looked for: where the camera sits"));
  estimate.applied_rad.setZero();
  EXPECT_THAT(CalibrationText(estimate, prior_rad), HasSubstr("left as it is"));
}

}  // namespace
}  // namespace tvl
