// Where tracks will be in the next image, given a predicted motion: seeds for the optical flow.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "tvl/frame/feature_tracks.h"
#include "tvl/frame/visual_depth.h"
#include "tvl/geometry/camera.h"
#include "tvl/geometry/rigid3.h"

namespace tvl {

struct PixelPrediction {
  TrackId id = 0;
  Eigen::Vector2d px_cam;  // in the image as delivered (distorted), px
  bool warps = false;      // on the ground, which comes so much nearer that its look changes
};

struct PixelPredictions {
  std::vector<PixelPrediction> pixels;  // by increasing id
  // Takes pixels of the ground in the previous image to the current one, where any of them warps.
  std::optional<cv::Matx33d> H_cur_prev_ground;
};

// Positions of the tracks with known depth after the camera moved. `tracks` and `depths` (one a
// track) belong to the previous image; T_cur_prev maps points of the previous camera frame into the
// current one. Points that come to lie behind the camera or nearer than 0.5 m are left out. Tracks
// on the ground whose depth is not known are predicted by the plane of those whose depth is.
PixelPredictions PredictPixels(const FeatureTracks& tracks, const VisualDepths& depths,
                               const Rigid3d& T_cur_prev, const Camera& camera);

}  // namespace tvl
