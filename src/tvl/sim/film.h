// From the light that enters the lens to an 8-bit image: blur, vignetting, exposure, noise.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/base/parallel.h"

namespace tvl::sim {

struct FilmOptions {
  uint64_t seed = 1;               // of the noise
  double blur_sigma_px = 0.6;      // point spread of a sharp lens on KITTI's sensor
  double vignetting = 0.18;        // share of light lost in the corners
  double target_mean = 0.31;       // mean grey, share of white, that the exposure aims at
  double metering_from = 0.35;     // rows above this share of the height (sky) do not count for it
  double exposure_strength = 0.8;  // 1 reaches the target, 0 does not adapt
  double max_gain = 3.0;           // of the exposure, and 1 / max_gain the least
  double exposure_drift = 0.05;    // slow random part of the exposure, relative
  double read_noise_grey = 1.4;    // noise of black, in grey levels of 255
  double photon_noise_grey = 1.8;  // further noise of white, in grey levels of 255
  double night_gain = 0.012;       // what is left of a day's light
  // Throws InputError naming the field.
  void Check() const;
};

// Immutable, thread-safe.
class Film {
 public:
  explicit Film(const FilmOptions& options);

  // `radiance`: CV_32F, 1 is white at gain 1. Noise depends on seed, frame and pixel only.
  cv::Mat Develop(const cv::Mat& radiance, uint64_t frame, bool night,
                  const Executor& executor) const;

  // The factor that brings the picture to the target mean, within limits; drifts with the frame.
  float Gain(const cv::Mat& radiance, uint64_t frame, const Executor& executor) const;

 private:
  // The blurred light of a row.
  std::vector<float> Blur(const cv::Mat& radiance, int y, float gain) const;
  void DevelopRow(const cv::Mat& radiance, int y, uint64_t frame, float gain, cv::Mat& image) const;

  FilmOptions options_;
  std::vector<float> normal_;  // table of standard normal numbers
  float centre_, side_;        // weights of the three-tap blur
};

}  // namespace tvl::sim
