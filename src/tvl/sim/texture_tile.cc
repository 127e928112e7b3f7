#include "tvl/sim/texture_tile.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

// log2 to within 0.01, for x > 0: exponent bits plus a parabola through the mantissa.
float FastLog2(float x) {
  uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  const auto exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  bits = (bits & 0x007fffffU) | 0x3f800000U;
  float m;
  std::memcpy(&m, &bits, sizeof m);
  return exponent + (-0.344845F * m + 2.024658F) * m - 1.674873F;
}

int FloorToInt(float x) {
  const int i = static_cast<int>(x);
  return i - static_cast<int>(x < static_cast<float>(i));
}

cv::Mat Halve(const cv::Mat& fine) {
  cv::Mat coarse(fine.rows / 2, fine.cols / 2, CV_32F);
  for (int y = 0; y < coarse.rows; ++y) {
    const auto* a = fine.ptr<float>(2 * y);
    const auto* b = fine.ptr<float>(2 * y + 1);
    auto* out = coarse.ptr<float>(y);
    for (int x = 0; x < coarse.cols; ++x) {
      out[x] = 0.25F * (a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1]);
    }
  }
  return coarse;
}

}  // namespace

TextureTile::TextureTile(const cv::Mat& grey, float period_m)
    : period_m_(period_m), size_(grey.rows) {
  TVL_CHECK(grey.type() == CV_32F && grey.rows == grey.cols && size_ > 1 && period_m > 0.0F);
  TVL_CHECK((size_ & (size_ - 1)) == 0) << "side " << size_ << " is not a power of two";
  cv::Mat level = grey;
  for (int size = size_;; size /= 2) {
    uint32_t shift = 0;
    while ((1 << shift) < size) ++shift;
    levels_.push_back({static_cast<uint32_t>(texels_.size()), static_cast<uint32_t>(size - 1),
                       shift, static_cast<float>(size) / period_m});
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const float value = std::clamp(level.at<float>(y, x), 0.0F, 1.0F);
        texels_.push_back(static_cast<uint8_t>(std::lround(value * 255.0F)));
      }
    }
    if (size == 1) break;
    level = Halve(level);
  }
}

float TextureTile::Bilinear(const Level& level, float u_m, float v_m) const {
  const float x = u_m * level.texels_per_m - 0.5F;
  const float y = v_m * level.texels_per_m - 0.5F;
  const int xi = FloorToInt(x);
  const int yi = FloorToInt(y);
  const float fx = x - static_cast<float>(xi);
  const float fy = y - static_cast<float>(yi);
  const uint32_t x0 = static_cast<uint32_t>(xi) & level.mask;
  const uint32_t x1 = static_cast<uint32_t>(xi + 1) & level.mask;
  const uint8_t* texels = texels_.data() + level.offset;
  const uint8_t* row0 = texels + ((static_cast<uint32_t>(yi) & level.mask) << level.shift);
  const uint8_t* row1 = texels + ((static_cast<uint32_t>(yi + 1) & level.mask) << level.shift);
  const auto a = static_cast<float>(row0[x0]);
  const auto b = static_cast<float>(row0[x1]);
  const auto c = static_cast<float>(row1[x0]);
  const auto d = static_cast<float>(row1[x1]);
  const float top = a + fx * (b - a);
  return (top + fy * (c + fx * (d - c) - top)) * (1.0F / 255.0F);
}

TextureTile::Blend TextureTile::BlendFor(float footprint_m) const {
  const float ratio = footprint_m * levels_[0].texels_per_m;
  if (ratio <= 1.0F) return {levels_.data(), levels_.data(), 0.0F};
  const float lod = FastLog2(ratio);
  const auto fine = static_cast<size_t>(lod);
  if (fine + 1 >= levels_.size()) return {&levels_.back(), &levels_.back(), 0.0F};
  return {&levels_[fine], &levels_[fine + 1], lod - static_cast<float>(fine)};
}

float TextureTile::Sample(const Blend& blend, float u_m, float v_m) const {
  // A twentieth of a level more or less cannot be seen and saves a lookup.
  if (blend.share < 0.05F) return Bilinear(*blend.fine, u_m, v_m);
  const float a = Bilinear(*blend.fine, u_m, v_m);
  return a + blend.share * (Bilinear(*blend.coarse, u_m, v_m) - a);
}

float TextureTile::Sample(float u_m, float v_m, float footprint_m) const {
  return Sample(BlendFor(footprint_m), u_m, v_m);
}

float TextureTile::Sample(const TextureFootprint& at) const { return SampleScaled(at, 1.0F, 1.0F); }

float TextureTile::SampleScaled(const TextureFootprint& at, float scale_u, float scale_v) const {
  const float du = at.major_u_m * scale_u;
  const float dv = at.major_v_m * scale_v;
  const float major = std::sqrt(du * du + dv * dv);
  const float minor =
      std::max(at.minor_m * std::min(std::abs(scale_u), std::abs(scale_v)), texel_m());
  const int taps = std::clamp(static_cast<int>(std::lround(major / minor)), 1, kMaxTaps);
  const auto n = static_cast<float>(taps);
  const Blend blend = BlendFor(std::max(minor, major / n));
  float sum = 0.0F;
  for (int i = 0; i < taps; ++i) {
    const float along = (static_cast<float>(i) + 0.5F) / n - 0.5F;
    sum += Sample(blend, at.u_m * scale_u + along * du, at.v_m * scale_v + along * dv);
  }
  return sum / n;
}

}  // namespace tvl::sim
