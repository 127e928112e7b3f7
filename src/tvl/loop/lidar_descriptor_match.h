// Two places laid over each other: yaw, x and y between them, and how well they agree.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tvl/loop/lidar_descriptor.h"

namespace tvl {

// Correlation of a place's image with itself, blurred as PlaceMatcher blurs it.
float PlaceEnergy(const std::vector<PlaceCell>& cells, const LidarDescriptorOptions& options);

// T_history_current in the plane of the road, and the normalised correlation of the two images.
struct PlaceMatch {
  double yaw_rad = 0.0, x_m = 0.0, y_m = 0.0;
  double similarity = 0.0;  // 0..1
  // How well another placement fits, as a share of the best: the other half turn, or shifted by 3 m
  // or more. Near 1 between hedges that look alike all along.
  double ambiguity = 1.0;
};

// One current place, made ready to be compared with many of the past. Yaw mod half a turn from the
// ring spectra; for both half turns x and y from a coarse correlation of the images (FFT, 2 cells a
// pixel); the better of the two improved by a pattern search on the full image. 0.2 ms a match.
// Deterministic; Match is const and safe from several threads.
class PlaceMatcher {
 public:
  // Shifts up to max_offset_m along x and y are tried: the image wraps around beyond.
  PlaceMatcher(const LidarDescriptor& current, double max_offset_m,
               const LidarDescriptorOptions& options);

  PlaceMatch Match(const LidarDescriptor& history) const;

 private:
  // p_current = R(-yaw) p_history + shift.
  struct Placement {
    double yaw_rad, shift_x_m, shift_y_m;
    double correlation;
  };
  // The best shift at one yaw, and the correlation of the best one elsewhere.
  struct CoarseResult {
    Placement best;
    double elsewhere = 0.0;
  };
  CoarseResult Coarse(const LidarDescriptor& history, double yaw_rad) const;
  Placement Refined(const LidarDescriptor& history, Placement start) const;
  double Correlation(const std::vector<PlaceCell>& history, const Placement& at) const;

  LidarDescriptorOptions options_;
  double max_offset_m_;
  std::vector<int8_t> spectrum_;
  float energy_;
  cv::Mat field_;   // blurred image of the current place
  cv::Mat coarse_;  // transform of the image at half the resolution
};

// Yaw in [0, pi) that turns the spectrum of `current` onto that of `history`.
double SpectrumYaw(const std::vector<int8_t>& history, const std::vector<int8_t>& current);

}  // namespace tvl
