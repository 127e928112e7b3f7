// Images with what is wrong with them.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "tvl/sensor/sensor_frame.h"

namespace tvl {

struct ImageRead {
  cv::Mat image;  // as stored: 8 or 16 bit, 1 or 3 channels (BGR); empty: unusable, see faults
  std::vector<FrameFault> faults;  // name the file
};

// Reads an image of the expected size (0: any). Unreadable, black or wrong-sized images come as
// faults, never as exceptions.
ImageRead ReadImage(const std::string& path, int width_px, int height_px);

// The same checks of an image that was read in another way; `source` begins the faults' texts. An
// empty image is an unreadable one.
ImageRead CheckImage(const cv::Mat& image, const std::string& source, int width_px, int height_px);

// Mean brightness at or below this share of the full scale is a lens cap or a dead camera: 1 %,
// where nothing can be tracked. 16-bit images are taken to hold at least 12 bits.
inline constexpr double kBlackShare = 0.01;

}  // namespace tvl
