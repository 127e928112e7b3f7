// FAST corners spread over the image: where the binary descriptors of visual loop detection are
// taken (paper 6.2).
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace tvl {

struct FastCornersOptions {
  int count = 500;  // paper 6.2
  // Grey levels that 9 of the 16 pixels on the circle must differ by. Low: the strongest are chosen
  // afterwards, and dull places (shade, fog) still give corners.
  int threshold_levels = 10;
  // The image is cut into cells of about this side, which get equal shares first: else one hedge
  // takes them all. Not smaller: shares of 60 px cells are filled with weak corners, of which a
  // fifth fewer are found again a metre on.
  double cell_px = 200.0;
  // Between corners: neighbours give nearly the same descriptor.
  double min_distance_px = 5.0;

  void Check() const;  // throws InputError naming the field
};

// At most `count` corners of `grey` (8 bit), at whole pixels at least `border_px` away from the
// image's edge, the strongest of each cell first. Deterministic.
std::vector<cv::Point> DetectFastCorners(const cv::Mat& grey, int border_px,
                                         const FastCornersOptions& options);

}  // namespace tvl
