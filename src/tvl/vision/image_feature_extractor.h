// From an image to the features visual loop detection keeps of a keyframe (paper 6.1, 6.2).
#pragma once

#include <opencv2/core/mat.hpp>

#include "tvl/frame/image_features.h"
#include "tvl/geometry/camera.h"
#include "tvl/vision/brief.h"
#include "tvl/vision/fast_corners.h"
#include "tvl/vision/image_preparation.h"

namespace tvl {

struct ImageFeatureOptions {
  FastCornersOptions corners;
  ImagePreparationOptions image;  // of it only what says that an image is unusable

  void Check() const;  // throws InputError naming the field
};

// Corners with descriptors. Const after construction; thread-safe.
class ImageFeatureExtractor {
 public:
  // Throws InputError for unusable options.
  explicit ImageFeatureExtractor(const ImageFeatureOptions& options = {});

  // 8 or 16 bit, grey or colour, as delivered (distorted; `camera` says how). No features for an
  // image that is empty, dark or uniform. depth_m is 0 everywhere: what the lidar knows is filled
  // in by the caller.
  ImageFeatures Extract(const cv::Mat& image, const Camera& camera) const;

 private:
  ImageFeatureOptions options_;
  BriefPattern pattern_;
};

}  // namespace tvl
