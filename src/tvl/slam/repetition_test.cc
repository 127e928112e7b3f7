#include "tvl/slam/repetition.h"

#include <gtest/gtest.h>

#include <memory>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

std::shared_ptr<const LidarScan> ScanOf(uint64_t seed) {
  auto scan = std::make_shared<LidarScan>();
  Rng rng(seed);
  for (int i = 0; i < 5000; ++i) {
    scan->points.emplace_back(10.0 + 0.02 * rng.Normal(), 0.01 * i, 0.02 * rng.Normal());
  }
  return scan;
}

cv::Mat ImageOf(uint64_t seed) {
  cv::Mat image(120, 400, CV_8UC3);
  Rng rng(seed);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < 3 * image.cols; ++x) {
      image.ptr(y)[x] = static_cast<uchar>(100.0 + 2.0 * rng.Normal());
    }
  }
  return image;
}

SensorFrame FrameOf(uint64_t scan_seed, uint64_t image_seed) {
  SensorFrame frame;
  if (scan_seed > 0) frame.scan = ScanOf(scan_seed);
  if (image_seed > 0) frame.image = ImageOf(image_seed);
  return frame;
}

TEST(RepetitionCheck, FindsTheScanAndTheImageOfTheFrameBefore) {
  RepetitionCheck check;
  EXPECT_FALSE(check.Check(FrameOf(1, 1)).scan);
  const Repetition scan_only = check.Check(FrameOf(1, 2));
  EXPECT_TRUE(scan_only.scan);
  EXPECT_FALSE(scan_only.image);
  const Repetition image_only = check.Check(FrameOf(2, 2));
  EXPECT_FALSE(image_only.scan);
  EXPECT_TRUE(image_only.image);
}

// A vehicle that stands sees the same, but for the noise.
TEST(RepetitionCheck, NoiseAloneMakesDataNew) {
  RepetitionCheck check;
  for (uint64_t seed = 1; seed < 40; ++seed) {
    const Repetition repetition = check.Check(FrameOf(seed, seed));
    EXPECT_FALSE(repetition.scan);
    EXPECT_FALSE(repetition.image);
  }
}

TEST(RepetitionCheck, MissingDataRepeatsNothing) {
  RepetitionCheck check;
  check.Check(FrameOf(1, 1));
  const Repetition missing = check.Check(FrameOf(0, 0));
  EXPECT_FALSE(missing.scan || missing.image);
  EXPECT_TRUE(check.Check(FrameOf(1, 0)).scan) << "it is still the last scan there was";
}

}  // namespace
}  // namespace tvl
