// Whether there is anything but noise around a pixel. Adaptive equalisation lifts the noise of a
// blank sky to the contrast of a wall, so this is asked of the image as delivered.
#pragma once

#include <opencv2/core/mat.hpp>

namespace tvl {

// Side of the patch that is looked at, px: as wide as a corner's surroundings in the optical flow.
inline constexpr int kContrastPatch_px = 9;

// Standard deviation of the grey levels in the patch around `px` (cut at the image's edge).
// 8-bit grey image.
double ContrastAround(const cv::Mat& grey, const cv::Point2f& px);

// Standard deviation of the image's noise, grey levels: that of its smoothest tenth, where nothing
// but noise is left. Patches without any variation are clipped black or white and do not count; an
// image of nothing else has noise 0. An image that is textured all over has no such tenth: more
// than kMaxNoise_levels is texture, at any gain that a camera is used with.
inline constexpr double kMaxNoise_levels = 6.0;
double NoiseLevel(const cv::Mat& grey);

}  // namespace tvl
