#include "tvl/vision/brief.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr uint64_t kPatternSeed = 20100905;
constexpr double kPatternSigma_px = 2.0 * kBriefRadius_px / 5.0;

int8_t DrawOffset(Rng& rng) {
  for (;;) {
    const long offset = std::lround(kPatternSigma_px * rng.Normal());
    if (std::abs(offset) <= kBriefRadius_px) return static_cast<int8_t>(offset);
  }
}

// Where a pair's pixels lie in memory, relative to the corner.
struct PairOffsets {
  int a, b;
};

std::array<PairOffsets, 256> MemoryOffsets(const BriefPattern& pattern, int row_bytes) {
  std::array<PairOffsets, 256> offsets;
  for (size_t i = 0; i < pattern.size(); ++i) {
    const BriefPair& p = pattern[i];
    offsets[i] = {p.ay * row_bytes + p.ax, p.by * row_bytes + p.bx};
  }
  return offsets;
}

BinaryDescriptor Describe(const uint8_t* corner, const std::array<PairOffsets, 256>& offsets) {
  BinaryDescriptor descriptor;
  for (size_t word = 0; word < 4; ++word) {
    uint64_t bits = 0;
    for (size_t i = 0; i < 64; ++i) {
      const PairOffsets& pair = offsets[64 * word + i];
      bits |= static_cast<uint64_t>(corner[pair.a] < corner[pair.b]) << i;
    }
    descriptor[word] = bits;
  }
  return descriptor;
}

}  // namespace

BriefPattern MakeBriefPattern() {
  Rng rng(kPatternSeed);
  BriefPattern pattern;
  for (BriefPair& pair : pattern) {
    do {  // braces fix the order of drawing
      pair = BriefPair{DrawOffset(rng), DrawOffset(rng), DrawOffset(rng), DrawOffset(rng)};
    } while (pair.ax == pair.bx && pair.ay == pair.by);
  }
  return pattern;
}

cv::Mat SmoothForBrief(const cv::Mat& grey) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, cv::Size(9, 9), 2.0, 2.0);
  return smooth;
}

std::vector<BinaryDescriptor> DescribeBrief(const cv::Mat& smooth,
                                            const std::vector<cv::Point>& corners,
                                            const BriefPattern& pattern) {
  TVL_CHECK(smooth.type() == CV_8U) << "OpenCV type " << smooth.type();
  const auto offsets = MemoryOffsets(pattern, static_cast<int>(smooth.step[0]));
  const cv::Rect inside(kBriefRadius_px, kBriefRadius_px, smooth.cols - 2 * kBriefRadius_px,
                        smooth.rows - 2 * kBriefRadius_px);
  std::vector<BinaryDescriptor> descriptors;
  descriptors.reserve(corners.size());
  for (const cv::Point& corner : corners) {
    TVL_CHECK(inside.contains(corner)) << "corner " << corner << " too near the edge";
    descriptors.push_back(Describe(smooth.ptr<uint8_t>(corner.y) + corner.x, offsets));
  }
  return descriptors;
}

}  // namespace tvl
