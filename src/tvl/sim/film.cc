#include "tvl/sim/film.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl::sim {
namespace {

constexpr size_t kNormals = 1 << 14;
constexpr float kClip = 1.6F;  // light beyond white that still bleeds into the neighbours

}  // namespace

void FilmOptions::Check() const {
  TVL_CHECK_INPUT(blur_sigma_px >= 0.0 && blur_sigma_px <= 1.0)
      << "sim film: blur_sigma_px = " << blur_sigma_px << " is not in [0, 1]";
  TVL_CHECK_INPUT(vignetting >= 0.0 && vignetting < 1.0)
      << "sim film: vignetting = " << vignetting << " is not in [0, 1)";
  TVL_CHECK_INPUT(target_mean > 0.0 && target_mean < 1.0)
      << "sim film: target_mean = " << target_mean << " is not in (0, 1)";
  TVL_CHECK_INPUT(metering_from >= 0.0 && metering_from < 1.0)
      << "sim film: metering_from = " << metering_from << " is not in [0, 1)";
  TVL_CHECK_INPUT(max_gain >= 1.0) << "sim film: max_gain = " << max_gain << " is below 1";
  TVL_CHECK_INPUT(read_noise_grey >= 0.0 && photon_noise_grey >= 0.0)
      << "sim film: noise must not be negative";
}

Film::Film(const FilmOptions& options) : options_(options), normal_(kNormals) {
  options.Check();
  Rng rng(options.seed, 0xf11a);
  for (float& value : normal_) value = static_cast<float>(rng.Normal());
  const double sigma = std::max(options.blur_sigma_px, 1e-3);
  const double side = std::exp(-0.5 / (sigma * sigma));
  centre_ = static_cast<float>(1.0 / (1.0 + 2.0 * side));
  side_ = static_cast<float>(side / (1.0 + 2.0 * side));
}

float Film::Gain(const cv::Mat& radiance, uint64_t frame, const Executor& executor) const {
  const auto top = static_cast<int>(options_.metering_from * radiance.rows);
  const auto rows = static_cast<size_t>(radiance.rows - top);
  const double sum = executor.Sum(rows, 16, 0.0, [&](size_t begin, size_t end) {
    double part = 0.0;
    for (size_t y = begin; y < end; ++y) {
      const auto* row = radiance.ptr<float>(top + static_cast<int>(y));
      float line = 0.0F;
      for (int x = 0; x < radiance.cols; ++x) line += std::min(row[x], 1.0F);
      part += static_cast<double>(line);
    }
    return part;
  });
  const double mean =
      std::max(sum / static_cast<double>(rows * static_cast<size_t>(radiance.cols)), 1e-4);
  const double gain = std::pow(options_.target_mean / mean, options_.exposure_strength);
  const auto t = static_cast<double>(frame);
  const double drift = 0.6 * std::sin(t / 23.0) + 0.4 * std::sin(t / 71.0 + 1.0);
  return static_cast<float>(std::clamp(gain, 1.0 / options_.max_gain, options_.max_gain) *
                            (1.0 + options_.exposure_drift * drift));
}

std::vector<float> Film::Blur(const cv::Mat& radiance, int y, float gain) const {
  const auto cols = static_cast<size_t>(radiance.cols);
  const auto* above = radiance.ptr<float>(std::max(y - 1, 0));
  const auto* here = radiance.ptr<float>(y);
  const auto* below = radiance.ptr<float>(std::min(y + 1, radiance.rows - 1));
  std::vector<float> column(cols + 2);
  for (size_t x = 0; x < cols; ++x) {
    column[x + 1] = side_ * (std::min(above[x] * gain, kClip) + std::min(below[x] * gain, kClip)) +
                    centre_ * std::min(here[x] * gain, kClip);
  }
  column.front() = column[1];
  column.back() = column[cols];
  std::vector<float> light(cols);
  for (size_t x = 0; x < cols; ++x) {
    light[x] = side_ * (column[x] + column[x + 2]) + centre_ * column[x + 1];
  }
  return light;
}

void Film::DevelopRow(const cv::Mat& radiance, int y, uint64_t frame, float gain,
                      cv::Mat& image) const {
  const int cols = radiance.cols;
  const std::vector<float> blurred = Blur(radiance, y, gain);
  const float cx = 0.5F * static_cast<float>(cols);
  const float dy = static_cast<float>(y) - 0.5F * static_cast<float>(radiance.rows);
  const float loss = static_cast<float>(options_.vignetting) /
                     (cx * cx + 0.25F * static_cast<float>(radiance.rows * radiance.rows));
  const auto read_sq = static_cast<float>(options_.read_noise_grey * options_.read_noise_grey);
  const auto photon_sq =
      static_cast<float>(options_.photon_noise_grey * options_.photon_noise_grey);
  const uint64_t key = Rng::Mix(options_.seed ^ Rng::Mix(frame * 4096 + static_cast<uint64_t>(y)));
  auto* out = image.ptr<uint8_t>(y);
  uint64_t bits = 0;
  for (int x = 0; x < cols; ++x) {
    if (x % 4 == 0) bits = Rng::Mix(key + static_cast<uint64_t>(x));
    const float dx = static_cast<float>(x) - cx;
    const float light = blurred[static_cast<size_t>(x)] * (1.0F - loss * (dx * dx + dy * dy));
    const float sigma = std::sqrt(read_sq + photon_sq * std::min(light, 1.0F));
    const float grey = 255.0F * light + sigma * normal_[(bits >> (16 * (x % 4))) % kNormals];
    out[x] = static_cast<uint8_t>(std::clamp(grey + 0.5F, 0.0F, 255.0F));
  }
}

cv::Mat Film::Develop(const cv::Mat& radiance, uint64_t frame, bool night,
                      const Executor& executor) const {
  TVL_CHECK(radiance.type() == CV_32F);
  const float gain =
      night ? static_cast<float>(options_.night_gain) : Gain(radiance, frame, executor);
  cv::Mat image(radiance.size(), CV_8U);
  executor.For(static_cast<size_t>(radiance.rows), 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      DevelopRow(radiance, static_cast<int>(y), frame, gain, image);
    }
  });
  return image;
}

}  // namespace tvl::sim
