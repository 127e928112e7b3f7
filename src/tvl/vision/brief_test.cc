#include "tvl/vision/brief.h"

#include <gtest/gtest.h>

#include <bitset>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

int Distance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  size_t bits = 0;
  for (size_t i = 0; i < 4; ++i) bits += std::bitset<64>(a[i] ^ b[i]).count();
  return static_cast<int>(bits);
}

TEST(Brief, ThePatternNeverChanges) {
  // Vocabularies and stored maps belong to it.
  uint64_t hash = 0;
  double sum_sq = 0.0;  // of a normal distribution of 9.6 px, cut off at 24 px
  for (const BriefPair& p : MakeBriefPattern()) {
    for (const int8_t v : {p.ax, p.ay, p.bx, p.by}) {
      EXPECT_LE(std::abs(v), kBriefRadius_px);
      hash = hash * 1000003 + static_cast<uint64_t>(v + 128);
      sum_sq += v * v;
    }
  }
  EXPECT_NEAR(std::sqrt(sum_sq / 1024.0), 9.1, 0.2);
  EXPECT_EQ(hash, 3125055316439518951ULL);
}

TEST(Brief, BitsAreComparisonsOfSmoothedPixels) {
  const cv::Mat smooth = SmoothForBrief(MakeTexture({200, 100}, 4));
  const BriefPattern pattern = MakeBriefPattern();
  const cv::Point corner(101, 47);
  const BinaryDescriptor d = DescribeBrief(smooth, {corner}, pattern).at(0);
  for (size_t i = 0; i < 256; ++i) {
    const BriefPair& p = pattern[i];
    const bool darker = smooth.at<uchar>(corner.y + p.ay, corner.x + p.ax) <
                        smooth.at<uchar>(corner.y + p.by, corner.x + p.bx);
    EXPECT_EQ(((d[i / 64] >> (i % 64)) & 1) != 0, darker) << "bit " << i;
  }
}

TEST(Brief, SamePlaceIsNearAnotherPlaceIsFar) {
  const cv::Mat image = MakeTexture({400, 200}, 5);
  cv::Mat brighter;
  image.convertTo(brighter, CV_8U, 0.7, 40.0);
  // 12 % larger, as seen from a metre nearer at 9 m.
  const cv::Mat larger = Warp(image, {1.12, 0.0, -24.0, 0.0, 1.12, -12.0});
  const BriefPattern pattern = MakeBriefPattern();
  const cv::Point here(200, 100), there(120, 60);
  const auto in_image = DescribeBrief(SmoothForBrief(image), {here, there}, pattern);
  const auto in_brighter = DescribeBrief(SmoothForBrief(brighter), {here}, pattern);
  const auto in_larger = DescribeBrief(SmoothForBrief(larger), {here}, pattern);
  EXPECT_LE(Distance(in_image[0], in_brighter[0]), 8);
  EXPECT_LE(Distance(in_image[0], in_larger[0]), 60);
  EXPECT_GE(Distance(in_image[0], in_image[1]), 90);
}

TEST(Brief, RefusesCornersAtTheEdge) {
  const cv::Mat smooth(100, 100, CV_8U, cv::Scalar(0));
  const BriefPattern pattern = MakeBriefPattern();
  EXPECT_NO_THROW(DescribeBrief(smooth, {{24, 24}, {75, 75}}, pattern));
  EXPECT_THROW(DescribeBrief(smooth, {{23, 50}}, pattern), Error);
  EXPECT_THROW(DescribeBrief(smooth, {{50, 76}}, pattern), Error);
}

}  // namespace
}  // namespace tvl
