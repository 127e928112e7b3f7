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
  EXPECT_THAT(text, HasSubstr("the delay of the images: not told by this drive"));
  EXPECT_THAT(text, HasSubstr("where the camera sits across: not told by this drive"));
  estimate.applied_rad.setZero();
  EXPECT_THAT(CalibrationText(estimate, prior_rad), HasSubstr("left as it is"));
}

TEST(CalibrationText, SaysWhenImagesAreTakenAndWhereTheCameraSits) {
  CameraOffsetEstimate offset;
  offset.images = 20;
  offset.delay_s = 0.0312, offset.delay_sigma_s = 0.0039;
  offset.translation_m = {0.05, -0.03, 0.02};
  offset.translation_sigma_m = {0.01, 0.015, 0.08};
  EXPECT_EQ(DelayText(offset), "the images are taken 31 +- 4 ms after the scan's instant");
  EXPECT_THAT(PlaceText(offset, 0), HasSubstr("across: 0.050 +- 0.010 m further left than"));
  EXPECT_THAT(PlaceText(offset, 1), HasSubstr("0.030 +- 0.015 m lower"));
  EXPECT_THAT(PlaceText(offset, 2), HasSubstr("along the way: not told by this drive"));
  offset.delay_s = -0.02, offset.applied_delay_s = -0.02;
  EXPECT_THAT(DelayText(offset), HasSubstr("20 +- 4 ms before the scan's instant: allowed for"));
  offset.delay_sigma_s = 0.02;
  EXPECT_THAT(DelayText(offset), HasSubstr("not told by this drive (sigma 20 ms)"));
}

}  // namespace
}  // namespace tvl
