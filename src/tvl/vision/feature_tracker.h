// Tracks visual features from image to image (paper 4.1, Fig. 3).
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/frame/feature_tracks.h"
#include "tvl/geometry/camera.h"
#include "tvl/vision/corner_detector.h"
#include "tvl/vision/epipolar_filter.h"
#include "tvl/vision/image_preparation.h"
#include "tvl/vision/optical_flow.h"
#include "tvl/vision/pixel_prediction.h"

namespace tvl {

struct FeatureTrackerOptions {
  int max_features = 300;  // paper 4.1
  // New features are looked for when the kept ones fall under this share of max_features: detection
  // costs as much as the flow, and a few features more or less change nothing.
  double refill_share = 0.8;
  // When a smaller share of the previous features is kept, all are given up (status kLost): of an
  // unrelated image a few per cent pass the checks by chance.
  double min_kept_share = 0.1;
  // Between features that are looked for on the road alone: what is seen of it may be small.
  double road_distance_px = 10.0;
  ImagePreparationOptions image;
  OpticalFlowOptions flow;
  EpipolarFilterOptions epipolar;
  CornerDetectorOptions corners;

  void Check() const;  // throws InputError naming the field
};

// Where the lidar sees the road, and what stands on it, in the image as delivered, px.
struct RoadView {
  std::vector<Eigen::Vector2f> road_px, standing_px;
};

// What the tracker remembers between two images: everything that affects later results.
struct FeatureTrackerState {
  cv::Mat grey;                      // previous image, equalised, 8 bit; empty: none
  std::vector<FeatureTrack> tracks;  // its features, by increasing id
  TrackId next_id = 0;
};

// Ids are never reused and increase; a track's length counts the images it was seen in without a
// gap. Copies are independent of each other. Not thread-safe.
// OpenCV's own threads (cv::setNumThreads) change the speed, not the result.
class FeatureTracker {
 public:
  // Throws InputError for unusable options.
  explicit FeatureTracker(const FeatureTrackerOptions& options = {});

  // Features of the next image: 8 or 16 bit, grey or BGR, as delivered (distorted; `camera` says
  // how). An image that is empty, black, uniform or without corners gives status kNoImage and no
  // tracks, and the image after it is a first one. So is one of another size.
  // `predicted` (by increasing id) tells where tracks are expected: faster, and farther than the
  // search alone reaches; tracks missing there are looked for near where they moved last.
  FeatureTracks Track(const cv::Mat& image, const Camera& camera,
                      const PixelPredictions& predicted = {});

  // After Track: adds at most `count` features of the same image where the road is seen, and
  // nothing that stands on it. Returns them; they are the last of the tracks.
  std::vector<FeatureTrack> AddOnRoad(const RoadView& road, int count, const Camera& camera);

  // The last usable image, grey, 8 bit, before it was equalised; empty: none.
  const cv::Mat& grey() const { return grey_; }

  // Deep copy of the memory, and its way back.
  FeatureTrackerState state() const;
  void set_state(const FeatureTrackerState& state);

 private:
  FeatureTracks Follow(const ImagePyramid& current, const Camera& camera,
                       const PixelPredictions& predicted) const;
  // New features are added to `result`.
  void Detect(const ImagePyramid& current, const cv::Mat& grey, const Camera& camera,
              FeatureTracks* result);
  void Add(const std::vector<cv::Point2f>& corners_px, const Camera& camera, FeatureTracks* result);
  FeatureTracks Forget();

  FeatureTrackerOptions options_;
  ImagePyramid previous_;
  cv::Mat grey_;  // the same image before it was equalised
  std::vector<FeatureTrack> tracks_;
  TrackId next_id_ = 0;
};

}  // namespace tvl
