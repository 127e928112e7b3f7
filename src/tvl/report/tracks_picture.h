// Tracked features over their image (paper Fig. 3).
#pragma once

#include <opencv2/core/mat.hpp>

#include "tvl/frame/feature_tracks.h"

namespace tvl {

// Dots at the features, green (new) to red (seen in 20 images or more); a blue line from each to
// where it will be after one more step of its velocity; counts in a bar below. `image` is the one
// the tracks were made from. 8-bit BGR, as wide as the image.
cv::Mat DrawTracks(const cv::Mat& image, const FeatureTracks& tracks);

}  // namespace tvl
