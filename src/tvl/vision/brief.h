// 256-bit BRIEF descriptors (Calonder et al. 2010; paper 6.2).
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/frame/image_features.h"

namespace tvl {

// The patch is 48 x 48 pixels: every comparison lies within this distance of the corner in x and y.
inline constexpr int kBriefRadius_px = 24;

struct BriefPair {
  int8_t ax, ay, bx, by;  // two pixels relative to the corner; the bit says that a is darker than b
};
using BriefPattern = std::array<BriefPair, 256>;

// The pattern of all our descriptors: both ends normally distributed about the corner with a
// standard deviation of a fifth of the patch (the paper's G II), rounded, drawn again when outside.
// Made from a fixed seed: a vocabulary belongs to it, so it never changes.
BriefPattern MakeBriefPattern();

// Smoothed for comparing single pixels: Gaussian, sigma 2 px, 9 x 9.
cv::Mat SmoothForBrief(const cv::Mat& grey);

// One descriptor a corner of `smooth` (8 bit, one channel). Corners must be at least
// kBriefRadius_px away from the image's edge (checked). Not turned with the corner: cameras on
// vehicles stand upright.
std::vector<BinaryDescriptor> DescribeBrief(const cv::Mat& smooth,
                                            const std::vector<cv::Point>& corners,
                                            const BriefPattern& pattern);

}  // namespace tvl
