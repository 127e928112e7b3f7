// From an image as delivered to the grey 8-bit picture the tracker works on (paper 4.1).
#pragma once

#include <opencv2/core/mat.hpp>

namespace tvl {

struct ImagePreparationOptions {
  // CLAHE (paper 4.1, after Zuiderveld): evens out light so that LK and Shi-Tomasi see contrast in
  // shadow and glare alike. Clip 3 keeps sensor noise of flat sky from being blown up.
  double clahe_clip = 3.0;
  // Tiles a side; a tile of ~150 px is larger than any window used later.
  int clahe_tiles = 8;
  // Grey levels (of 255). Below: lens covered, camera off. Night streets measure 8 and more.
  double min_mean_level = 2.0;
  // Standard deviation in grey levels. Below: uniform (saturated, covered); nothing to track.
  double min_contrast_level = 1.0;

  void Check() const;  // throws InputError naming the field
};

// 8-bit grey version of `image`: 8 or 16 bit, 1, 3 (BGR) or 4 (BGRA) channels. 16-bit images are
// scaled by their 99.5th percentile, as sensors fill 10 to 16 bits of them.
// Throws InputError for another type. May share pixels with `image` where it is grey already.
cv::Mat ToGrey8(const cv::Mat& image);

// True if `grey` (8 bit) is bright and contrasted enough to track in.
bool IsUsableImage(const cv::Mat& grey, const ImagePreparationOptions& options);

// Contrast-limited adaptive equalisation of `grey` (8 bit) into a new image.
cv::Mat Equalise(const cv::Mat& grey, const ImagePreparationOptions& options);

}  // namespace tvl
