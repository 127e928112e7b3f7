// Whether the calibration can be meant for these images at all.
//
// An inverted Tr, or images that were resized after the calibration, leave the camera without a use
// and without a word: its matches contradict the lidar's and are dropped one by one. Here the
// tracks of a few metres of way are held against the lidar's motion, and if they leave their
// epipolar planes by far, stretch after stretch, that is said, with the mistake that would explain
// it. An error of some degrees is none of this: ExtrinsicCalibration finds it.
#pragma once

#include <string>
#include <vector>

#include "tvl/frame/feature_tracks.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/sensor/calibration.h"

namespace tvl {

class CalibrationCheck {
 public:
  explicit CalibrationCheck(const Calibration& given);

  // Of the first image: the principal point lies far from its middle. Empty: nothing to be said.
  std::string CheckImage(int width_px, int height_px);

  // Takes the tracks of a frame, without those on moving things, and its measured pose. Returns
  // what is wrong in the frame in which it becomes certain, else nothing.
  std::string Add(const FeatureTracks& tracks, const Rigid3d& T_odom_lidar);
  // What was seen before does not continue.
  void Forget() { reference_ = {}; }

  // The camera cannot be used with this calibration.
  bool has_contradiction() const { return has_contradiction_; }

 private:
  struct Candidate {
    Calibration calibration;
    std::string mistake;     // that it would explain; empty for the calibration given
    double share_sum = 0.0;  // of the tracks that fit, over the stretches in a row that contradict
  };
  struct View {
    std::vector<FeatureTrack> tracks;
    Rigid3d T_odom_lidar;
  };
  // Of the tracks that both views show and that tell, those that move as the lidar says; negative
  // where too few tell.
  static double FittingShare(const View& from, const View& to, const Calibration& calibration);
  std::string Contradiction() const;

  std::vector<Candidate> candidates_;  // the first is the one given
  View reference_;
  int frames_ = 0;         // since the reference
  int contradicting_ = 0;  // stretches in a row
  bool has_seen_image_ = false, has_contradiction_ = false;
};

}  // namespace tvl
