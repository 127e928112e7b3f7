// When the images were taken, and where the camera sits, seen from edges over a whole recording.
//
// An image that is late shows the scene from farther along the way: outlines are displaced by what
// the vehicle moves and turns meanwhile, and a camera that sits elsewhere displaces them by its
// parallax. Both are looked for together with the rotation, in the same outlines as EdgeAlignment
// uses, but over the whole recording. At a constant speed straight on a delay cannot be told from a
// place farther along: turns and changes of speed separate them. Where they do not, the standard
// deviations are large, and IsDelayObserved() says so.
//
// What all outlines of a stretch of way have wrong together (motion within the sweep, a hedge) is
// not in the scatter of single ones. So the fit is repeated without one stretch after the other,
// and what it changes by is part of the standard deviations (delete-a-group jackknife; Efron: The
// jackknife, the bootstrap and other resampling plans, 1982).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/registration/edge_alignment.h"

namespace tvl {

struct CameraOffsetOptions {
  bool enabled = true;
  int max_images = 60;   // kept of the recording; among neighbours, those in which it turns most
  int max_edges = 200;   // of one image
  int every_images = 8;  // the answer is looked for anew
  // The delay is looked for within so much to either side.
  double max_delay_s = 0.08;
  // What is possible beforehand, one standard deviation. Wide: what is said of one must not rest on
  // what is assumed of the other.
  double prior_delay_s = 0.1;
  double prior_place_m = 0.2;
  // Of all stretches alike, one standard deviation: of the delay, and of the place across and along
  // the way, and up (upper ends are rounded).
  double bias_delay_s = 0.0015;
  double bias_place_m = 0.01;
  double bias_up_m = 0.02;
  double min_significance = 3.0;  // of a delay, in standard deviations; smaller is not used
  void Check() const;             // throws InputError naming the field
};

struct CameraOffsetEstimate {
  int images = 0;  // 0: nothing is known
  // The images show the scene this much after the instant the scan is compensated to.
  double delay_s = 0.0, delay_sigma_s = 0.1;
  double applied_delay_s = 0.0;  // of it, what is used
  // Right in T_cam_lidar = Exp(rotation, translation) * T_given, camera axes: x right, y down, z
  // forward. The camera sits as much the other way.
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_sigma_m = Eigen::Vector3d::Constant(0.2);
};

// Told by the data well enough to be named: 30 ms are found within 5.
bool IsDelayObserved(const CameraOffsetEstimate& estimate);
bool IsPlaceObserved(const CameraOffsetEstimate& estimate, int axis);

class CameraOffset {
 public:
  explicit CameraOffset(const CameraOffsetOptions& options);

  // Takes the outlines of an image. True if estimate() is new.
  bool Add(const EdgeProfiles& edges, const EdgeReading& reading);
  // As of the last answer.
  const CameraOffsetEstimate& estimate() const { return estimate_; }

 private:
  struct Image {
    EdgeProfiles edges;
    EdgeReading reading;
  };
  void Keep(const Image& image);
  bool Solve(const EdgeReading& now);

  CameraOffsetOptions options_;
  std::vector<Image> images_;
  // While every stride-th image is kept: the one to keep of those since the last.
  std::vector<Image> candidate_;
  int stride_ = 1, since_kept_ = 0, since_solved_ = 0;
  CameraOffsetEstimate estimate_;
};

}  // namespace tvl
