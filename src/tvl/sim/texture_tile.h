// A periodic grey texture with its blurred copies, for looking up the average over a pixel's
// footprint: detail finer than the footprint fades out instead of flickering from frame to frame.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace tvl::sim {

// Where a pixel meets a textured surface, in that surface's own coordinates.
struct TextureFootprint {
  float u_m = 0.0F, v_m = 0.0F;
  // Long axis of the pixel's image on the surface (full length), its direction included.
  float major_u_m = 0.0F, major_v_m = 0.0F;
  float minor_m = 0.01F;  // short axis, full length
};

// Immutable, thread-safe.
class TextureTile {
 public:
  // `grey`: square CV_32F of values in 0..1 (clamped), its side a power of two; it repeats every
  // `period_m`. Throws tvl::Error otherwise.
  TextureTile(const cv::Mat& grey, float period_m);

  // Average over a square of side `footprint_m` around (u, v), 0..1.
  float Sample(float u_m, float v_m, float footprint_m) const;
  // Average over an elongated footprint: up to `kMaxTaps` squares along its long axis.
  float Sample(const TextureFootprint& at) const;
  // The same with the surface's coordinates stretched: (u * scale_u, v * scale_v).
  float SampleScaled(const TextureFootprint& at, float scale_u, float scale_v) const;

  float period_m() const { return period_m_; }
  float texel_m() const { return period_m_ / static_cast<float>(size_); }

  static constexpr int kMaxTaps = 4;

 private:
  struct Level {
    uint32_t offset, mask, shift;  // texel (x, y) is at offset + (y << shift) + x
    float texels_per_m;
  };
  // Two neighbouring levels and the share of the coarser that fit a footprint.
  struct Blend {
    const Level *fine, *coarse;
    float share;
  };
  Blend BlendFor(float footprint_m) const;
  float Bilinear(const Level& level, float u_m, float v_m) const;
  float Sample(const Blend& blend, float u_m, float v_m) const;

  float period_m_;
  int size_;
  std::vector<Level> levels_;  // finest first
  std::vector<uint8_t> texels_;
};

}  // namespace tvl::sim
