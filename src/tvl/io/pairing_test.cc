#include "tvl/io/pairing.h"

#include <gtest/gtest.h>

namespace tvl {
namespace {

std::vector<Timestamp> Times(double first_s, double period_s, int count) {
  std::vector<Timestamp> out;
  for (int i = 0; i < count; ++i) out.push_back(Timestamp::FromSeconds(first_s + period_s * i));
  return out;
}

TEST(PairImages, EachScanGetsTheNearestOfAFasterCamera) {
  const auto pairs = PairImages(Times(1000.0, 0.1, 20), Times(1000.012, 1.0 / 30.0, 70), 0.05);
  for (size_t k = 0; k < pairs.size(); ++k) {
    ASSERT_TRUE(pairs[k]) << k;
    EXPECT_EQ(*pairs[k], 3 * k);
  }
}

TEST(PairImages, AnImageBelongsToTheScanItIsNearestTo) {
  // A camera of half the lidar's rate, 10 ms late: every second scan has one.
  const auto pairs = PairImages(Times(0.0, 0.1, 10), Times(0.01, 0.2, 5), 0.1);
  for (size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_EQ(pairs[k].has_value(), k % 2 == 0) << k;
    if (k % 2 == 0) {
      EXPECT_EQ(pairs[k], k / 2);
    }
  }
}

TEST(PairImages, NothingFurtherAwayThanTheBound) {
  const auto pairs = PairImages(Times(0.0, 0.1, 3), Times(100.0, 0.1, 3), 0.05);
  for (const auto& pair : pairs) EXPECT_FALSE(pair);
  EXPECT_FALSE(PairImages(Times(0.0, 0.1, 1), {}, 0.05)[0]);
}

TEST(PairImages, KeepsTheNanosecondsOfAnEpoch) {
  const Timestamp scan{1700000000000000100}, image{1700000000000000101};
  const auto pairs = PairImages({scan}, {Timestamp{1699999999000000000}, image}, 1e-6);
  ASSERT_TRUE(pairs[0]);
  EXPECT_EQ(*pairs[0], 1U);
}

TEST(MedianPeriod, GapsDoNotCount) {
  std::vector<Timestamp> stamps = Times(0.0, 0.05, 20);
  stamps.push_back(Timestamp::FromSeconds(30.0));
  EXPECT_NEAR(MedianPeriod_s(stamps, 0.1), 0.05, 1e-9);
  EXPECT_EQ(MedianPeriod_s({Timestamp{5}}, 0.1), 0.1);
  EXPECT_EQ(MedianPeriod_s({Timestamp{5}, Timestamp{5}, Timestamp{5}}, 0.1), 0.1);
}

}  // namespace
}  // namespace tvl
