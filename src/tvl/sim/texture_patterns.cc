#include "tvl/sim/texture_patterns.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

constexpr int kMask = kPatternSize - 1;

float& Texel(cv::Mat& canvas, int x, int y) { return canvas.ptr<float>(y & kMask)[x & kMask]; }

cv::Mat Canvas(float value) {
  return cv::Mat(kPatternSize, kPatternSize, CV_32F, cv::Scalar(value));
}

// Random lattice value in [-1, 1) of an octave.
float LatticeValue(uint64_t seed, int x, int y) {
  const auto key = (static_cast<uint64_t>(x) << 32) ^ static_cast<uint64_t>(y);
  return static_cast<float>(Rng::Mix(seed ^ Rng::Mix(key + 1)) >> 40) * 0x1.0p-23F - 1.0F;
}

// Adds value noise with cells of cell_x by cell_y texels (powers of two).
void AddOctave(cv::Mat& canvas, uint64_t seed, int cell_x, int cell_y, float amplitude) {
  const int nx = kPatternSize / cell_x;
  const int ny = kPatternSize / cell_y;
  cv::Mat lattice(ny + 1, nx + 1, CV_32F);
  for (int y = 0; y <= ny; ++y) {
    for (int x = 0; x <= nx; ++x) lattice.at<float>(y, x) = LatticeValue(seed, x % nx, y % ny);
  }
  for (int y = 0; y < kPatternSize; ++y) {
    const float ty = static_cast<float>(y % cell_y) / static_cast<float>(cell_y);
    const float fy = ty * ty * (3.0F - 2.0F * ty);
    const auto* row0 = lattice.ptr<float>(y / cell_y);
    const auto* row1 = lattice.ptr<float>(y / cell_y + 1);
    auto* out = canvas.ptr<float>(y);
    for (int x = 0; x < kPatternSize; ++x) {
      const float tx = static_cast<float>(x % cell_x) / static_cast<float>(cell_x);
      const float fx = tx * tx * (3.0F - 2.0F * tx);
      const int i = x / cell_x;
      const float top = row0[i] + fx * (row0[i + 1] - row0[i]);
      const float bottom = row1[i] + fx * (row1[i + 1] - row1[i]);
      out[x] += amplitude * (top + fy * (bottom - top));
    }
  }
}

// Adds noise of all wavelengths with the given standard deviation.
void AddNoise(cv::Mat& canvas, uint64_t seed, double roughness, double sigma) {
  constexpr double kOctaveSigma = 0.4;  // of one octave of unit amplitude
  double power = 0.0;
  for (int cell = 2; cell <= kPatternSize / 4; cell *= 2) power += std::pow(cell, 2.0 * roughness);
  for (int cell = 2; cell <= kPatternSize / 4; cell *= 2) {
    const double amplitude = sigma / kOctaveSigma * std::pow(cell, roughness) / std::sqrt(power);
    AddOctave(canvas, seed + static_cast<uint64_t>(cell), cell, cell,
              static_cast<float>(amplitude));
  }
}

struct Ellipse {
  double x, y;           // centre, texels
  double length, width;  // half axes, texels
  double angle_rad;
  float tone;   // value of the middle
  float shade;  // added from one side to the other
  float share;  // 1 paints over, less mixes
};

void PaintEllipse(cv::Mat& canvas, const Ellipse& e) {
  const double c = std::cos(e.angle_rad);
  const double s = std::sin(e.angle_rad);
  const int reach = static_cast<int>(std::ceil(std::max(e.length, e.width)));
  const int x0 = static_cast<int>(std::floor(e.x));
  const int y0 = static_cast<int>(std::floor(e.y));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double along = (c * dx + s * dy) / e.length;
      const double across = (-s * dx + c * dy) / e.width;
      if (along * along + across * across > 1.0) continue;
      const float value = e.tone + e.shade * static_cast<float>(across);
      float& texel = Texel(canvas, x0 + dx, y0 + dy);
      texel += e.share * (value - texel);
    }
  }
}

// A thin line that wanders, each step one texel: cracks, seams, cables, graffiti.
struct Walk {
  double x, y, heading_rad;
  double wander_rad;  // standard deviation of the turn a step
  int steps, width;
  float tone, share;
};

void PaintWalk(cv::Mat& canvas, const Walk& walk, Rng& rng) {
  double x = walk.x;
  double y = walk.y;
  double heading = walk.heading_rad;
  for (int i = 0; i < walk.steps; ++i) {
    x += std::cos(heading);
    y += std::sin(heading);
    heading += walk.wander_rad * rng.Normal();
    for (int j = 0; j < walk.width * walk.width; ++j) {
      float& texel = Texel(canvas, static_cast<int>(std::floor(x)) + j % walk.width,
                           static_cast<int>(std::floor(y)) + j / walk.width);
      texel += walk.share * (walk.tone - texel);
    }
  }
}

// Rows of blocks in running bond, each with its own tone, joints of `joint` texels between.
struct Masonry {
  int blocks, rows;  // a period
  double joint;      // texels
  float joint_tone, tone_sigma;
  bool running_bond;
};

void PaintMasonry(cv::Mat& canvas, uint64_t seed, const Masonry& m) {
  const double width = static_cast<double>(kPatternSize) / m.blocks;
  const double height = static_cast<double>(kPatternSize) / m.rows;
  for (int y = 0; y < kPatternSize; ++y) {
    const int row = static_cast<int>(y / height);
    const double shift = m.running_bond && row % 2 == 1 ? 0.5 * width : 0.0;
    for (int x = 0; x < kPatternSize; ++x) {
      const double along = (x + shift) / width;
      const int block = static_cast<int>(along) % m.blocks;
      const double in_x = (along - std::floor(along)) * width;
      const double in_y = y - row * height;
      if (in_x < m.joint || in_y < m.joint) {
        Texel(canvas, x, y) = m.joint_tone;
      } else {
        Texel(canvas, x, y) += m.tone_sigma * 1.7F * LatticeValue(seed, block, row);
      }
    }
  }
}

// Stains that run down from a point (towards smaller v).
void PaintStreaks(cv::Mat& canvas, Rng& rng, int count, float share) {
  for (int i = 0; i < count; ++i) {
    const int x0 = static_cast<int>(rng.Integer(kPatternSize));
    const int y0 = static_cast<int>(rng.Integer(kPatternSize));
    const int width = 2 + static_cast<int>(rng.Integer(10));
    const int height = 40 + static_cast<int>(rng.Integer(260));
    const float tone = rng.Uniform() < 0.75 ? 0.2F : 0.75F;
    for (int y = 0; y < height; ++y) {
      const float fade = share * (1.0F - static_cast<float>(y) / static_cast<float>(height));
      for (int x = 0; x < width; ++x) {
        float& texel = Texel(canvas, x0 + x, y0 - y);
        texel += fade * (tone - texel);
      }
    }
  }
}

// Rows of letter-like marks of 3 x 5 cells.
void PaintSign(cv::Mat& canvas, Rng& rng) {
  const int cell = 3 + static_cast<int>(rng.Integer(6));
  const int letters = 3 + static_cast<int>(rng.Integer(5));
  const int x0 = static_cast<int>(rng.Integer(kPatternSize));
  const int y0 = static_cast<int>(rng.Integer(kPatternSize));
  const bool on_board = rng.Uniform() < 0.6;
  const float ink = on_board || rng.Uniform() < 0.5 ? 0.05F : 0.95F;
  if (on_board) {
    for (int y = -2 * cell; y < 7 * cell; ++y) {
      for (int x = -2 * cell; x < (4 * letters + 1) * cell; ++x)
        Texel(canvas, x0 + x, y0 + y) = 0.95F;
    }
  }
  for (int letter = 0; letter < letters; ++letter) {
    const uint64_t bits = rng.Next() | (rng.Next() & 0x1111ULL);
    for (int i = 0; i < 15 * cell * cell; ++i) {
      const int x = i % (3 * cell);
      const int y = i / (3 * cell);
      if (((bits >> (y / cell * 3 + x / cell)) & 1U) == 0) continue;
      Texel(canvas, x0 + (4 * letter) * cell + x, y0 + y) = ink;
    }
  }
}

Ellipse RandomSpot(Rng& rng, double smallest, double largest) {
  const double size = smallest * std::pow(largest / smallest, rng.Uniform());
  return {rng.Uniform() * kPatternSize,
          rng.Uniform() * kPatternSize,
          size,
          size * rng.Uniform(0.5, 1.0),
          rng.Uniform() * kPi,
          static_cast<float>(rng.Uniform()),
          0.0F,
          1.0F};
}

}  // namespace

cv::Mat PaintNoise(uint64_t seed, double roughness) {
  cv::Mat canvas = Canvas(0.5F);
  AddNoise(canvas, seed, roughness, 0.2);
  return canvas;
}

cv::Mat PaintAsphalt(uint64_t seed) {
  Rng rng(seed, 1);
  cv::Mat canvas = Canvas(0.5F);
  AddNoise(canvas, seed, -0.7, 0.15);
  for (int i = 0; i < 40000; ++i) {  // chippings
    Ellipse spot = RandomSpot(rng, 0.8, 2.4);
    spot.tone = rng.Uniform() < 0.55 ? 0.2F : 0.95F;
    spot.share = 0.6F;
    PaintEllipse(canvas, spot);
  }
  for (int i = 0; i < 60; ++i) {  // oil, chewing gum
    Ellipse spot = RandomSpot(rng, 3.0, 25.0);
    spot.tone = spot.length < 6.0 && rng.Uniform() < 0.5 ? 0.9F : 0.25F;
    spot.share = 0.5F;
    PaintEllipse(canvas, spot);
  }
  for (int i = 0; i < 7; ++i) {  // cracks and tar seams
    const double heading = rng.Uniform() * 2.0 * kPi;
    PaintWalk(canvas,
              {rng.Uniform() * kPatternSize, rng.Uniform() * kPatternSize, heading, 0.12,
               150 + static_cast<int>(rng.Integer(500)), 2 + static_cast<int>(rng.Integer(3)), 0.1F,
               0.8F},
              rng);
  }
  return canvas;
}

cv::Mat PaintBricks(uint64_t seed) {
  cv::Mat canvas = Canvas(0.45F);
  AddNoise(canvas, seed, 0.2, 0.06);
  PaintMasonry(canvas, seed + 1, {21, 68, 2.4, 0.9F, 0.16F, true});
  Rng rng(seed, 2);
  PaintStreaks(canvas, rng, 25, 0.3F);
  return canvas;
}

cv::Mat PaintPlaster(uint64_t seed) {
  Rng rng(seed, 3);
  cv::Mat canvas = Canvas(0.5F);
  AddNoise(canvas, seed, -0.1, 0.08);
  PaintStreaks(canvas, rng, 60, 0.35F);
  for (int i = 0; i < 90; ++i) {  // stains and spalls
    Ellipse spot = RandomSpot(rng, 2.0, 40.0);
    spot.share = 0.25F;
    PaintEllipse(canvas, spot);
  }
  for (int i = 0; i < 3; ++i) {
    PaintWalk(canvas,
              {rng.Uniform() * kPatternSize, rng.Uniform() * kPatternSize, rng.Uniform() * kPi,
               0.15, 200, 1, 0.15F, 0.8F},
              rng);
  }
  return canvas;
}

cv::Mat PaintLeaves(uint64_t seed) {
  Rng rng(seed, 4);
  cv::Mat canvas = Canvas(0.02F);
  constexpr int kLeaves = 20000;
  for (int i = 0; i < kLeaves; ++i) {
    const double depth = static_cast<double>(i) / kLeaves;  // 1: outermost, in the light
    const double length = rng.Uniform(5.0, 11.0);
    PaintEllipse(canvas, {rng.Uniform() * kPatternSize, rng.Uniform() * kPatternSize, length,
                          length * rng.Uniform(0.45, 0.7), rng.Uniform() * kPi,
                          static_cast<float>(depth * rng.Uniform(0.15, 0.95)),
                          static_cast<float>(0.15 * depth), 1.0F});
  }
  return canvas;
}

cv::Mat PaintGrass(uint64_t seed) {
  Rng rng(seed, 5);
  cv::Mat canvas = Canvas(0.25F);
  AddNoise(canvas, seed, 0.2, 0.08);
  for (int i = 0; i < 26000; ++i) {
    PaintEllipse(canvas, {rng.Uniform() * kPatternSize, rng.Uniform() * kPatternSize,
                          rng.Uniform(4.0, 9.0), rng.Uniform(0.8, 1.8), rng.Uniform() * kPi,
                          static_cast<float>(rng.Uniform(0.1, 0.8)), 0.0F, 0.85F});
  }
  for (int i = 0; i < 260; ++i) {  // flowers, leaves, bare earth
    Ellipse spot = RandomSpot(rng, 1.5, 12.0);
    spot.tone = spot.length < 4.0 ? 1.0F : spot.tone * 0.6F;
    spot.share = 0.7F;
    PaintEllipse(canvas, spot);
  }
  return canvas;
}

cv::Mat PaintSlabs(uint64_t seed) {
  cv::Mat canvas = Canvas(0.55F);
  AddNoise(canvas, seed, -0.5, 0.12);
  PaintMasonry(canvas, seed + 1, {14, 14, 2.5, 0.15F, 0.06F, true});
  Rng rng(seed, 6);
  for (int i = 0; i < 150; ++i) {
    Ellipse spot = RandomSpot(rng, 1.5, 14.0);
    spot.share = 0.4F;
    PaintEllipse(canvas, spot);
  }
  return canvas;
}

cv::Mat PaintRoofTiles(uint64_t seed) {
  cv::Mat canvas = Canvas(0.5F);
  AddNoise(canvas, seed, 0.1, 0.06);
  PaintMasonry(canvas, seed + 1, {20, 16, 5.0, 0.15F, 0.09F, true});
  return canvas;
}

cv::Mat PaintTunnelLining(uint64_t seed) {
  Rng rng(seed, 7);
  cv::Mat canvas = Canvas(0.5F);
  AddNoise(canvas, seed, 0.25, 0.12);
  PaintMasonry(canvas, seed + 1, {2, 3, 3.0, 0.12F, 0.07F, true});
  PaintStreaks(canvas, rng, 110, 0.6F);
  for (int i = 0; i < 500; ++i) {  // bolts, spalls, patches
    Ellipse spot = RandomSpot(rng, 2.0, 22.0);
    spot.share = 0.65F;
    PaintEllipse(canvas, spot);
  }
  for (int i = 0; i < 10; ++i) {  // cracks and scrawls
    const bool paint = rng.Uniform() < 0.4;
    PaintWalk(canvas,
              {rng.Uniform() * kPatternSize, rng.Uniform() * kPatternSize, rng.Uniform() * kPi,
               0.15, 350, paint ? 5 : 2, paint ? 0.9F : 0.08F, 0.85F},
              rng);
  }
  for (int i = 0; i < 12; ++i) PaintSign(canvas, rng);
  return canvas;
}

}  // namespace tvl::sim
