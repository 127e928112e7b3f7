#include "tvl/vision/image_feature_extractor.h"

namespace tvl {

void ImageFeatureOptions::Check() const {
  corners.Check();
  image.Check();
}

ImageFeatureExtractor::ImageFeatureExtractor(const ImageFeatureOptions& options)
    : options_(options), pattern_(MakeBriefPattern()) {
  options_.Check();
}

ImageFeatures ImageFeatureExtractor::Extract(const cv::Mat& image, const Camera& camera) const {
  ImageFeatures features;
  if (image.empty()) return features;
  const cv::Mat grey = ToGrey8(image);
  if (!IsUsableImage(grey, options_.image)) return features;
  const std::vector<cv::Point> corners = DetectFastCorners(grey, kBriefRadius_px, options_.corners);
  features.descriptors = DescribeBrief(SmoothForBrief(grey), corners, pattern_);
  features.depth_m.assign(corners.size(), 0.0f);
  for (const cv::Point& corner : corners) {
    const Eigen::Vector2d px_cam(corner.x, corner.y);
    features.px_cam.push_back(px_cam.cast<float>());
    features.ray_cam.push_back(camera.Unproject(px_cam).cast<float>());
  }
  return features;
}

}  // namespace tvl
