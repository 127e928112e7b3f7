// Visual features of one image; what vision hands on (paper 4.1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/base/ids.h"

namespace tvl {

// One tracked corner in the current image.
struct FeatureTrack {
  TrackId id = 0;
  int length = 1;               // images it has been seen in, this one included
  Eigen::Vector2d px_cam;       // where it is, in the image as delivered (distorted), px
  Eigen::Vector2d px_cam_prev;  // where it was in the previous image; equals px_cam if length == 1
  Eigen::Vector2d ray_cam;      // normalised, undistorted image point (z = 1)
};

enum class TrackingStatus {
  kNoImage,  // no usable image: tracks are empty, ids start anew with the next image
  kFirst,    // first image, or the first after a gap: new features only
  kTracked,  // enough features were carried over from the previous image
  kLost,     // too few survived; features were detected anew
};

struct FeatureTracks {
  TrackingStatus status = TrackingStatus::kNoImage;
  std::vector<FeatureTrack> tracks;  // by increasing id
  // Evidence: how many features of the previous image were ...
  int tracked = 0;        // kept
  int lost_flow = 0;      // lost by optical flow (or left the image)
  int lost_backward = 0;  // rejected by the forward-backward check
  int lost_epipolar = 0;  // rejected by the fundamental-matrix RANSAC
  int added = 0;          // new features
};

}  // namespace tvl
