// Shi-Tomasi corners spread over the image (paper 4.1).
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace tvl {

struct CornerDetectorOptions {
  double min_distance_px = 20.0;  // between features: keeps their distribution uniform
  // Of the strongest corner: below it lies noise. The smaller eigenvalue of the gradient matrix is
  // what is compared.
  double quality = 0.01;
  // The image is cut into cells of about this side; each gets an equal share of the features first,
  // so that a textured hedge does not take them all.
  double cell_px = 100.0;
  // Grey levels around a corner must spread by this many standard deviations of the image's noise,
  // and by so many levels at least; see local_contrast.h.
  double min_contrast_sigmas = 2.0;
  double min_contrast_levels = 1.5;

  void Check() const;  // throws InputError naming the field
};

// Where to look for corners.
struct CornerSearch {
  int count = 0;  // at most so many
  // Each is at least the minimum distance from all of these.
  std::vector<cv::Point2f> occupied_px;
  // 8 bit, not 0 where corners may be; empty: anywhere. The strongest corner is that in the mask.
  cv::Mat mask;
};

// At most `count` corners, each at least the minimum distance from the others and from
// the occupied places; sub-pixel positions. `gradient` holds dx, dy of each pixel (16-bit signed,
// two channels): ImagePyramid::gradient(), there for the optical flow. `grey` is the same image
// before it was equalised, 8 bit, and must show more than noise where a corner is. Deterministic.
std::vector<cv::Point2f> DetectCorners(const cv::Mat& gradient, const cv::Mat& grey,
                                       const CornerSearch& search,
                                       const CornerDetectorOptions& options);

}  // namespace tvl
