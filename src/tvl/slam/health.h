// Is a pose to be believed? Judged by how the scan lies on the map, compared with how it usually
// does, and by how far the pose is from what was expected.
#pragma once

#include <deque>

#include "tvl/slam/frame_tracker.h"
#include "tvl/slam/health_options.h"

namespace tvl {

enum class Health {
  kGood,
  kSuspicious,  // other hypotheses should be tried
  kBad,         // the pose is not to be believed
};

class HealthMonitor {
 public:
  explicit HealthMonitor(const HealthOptions& options);

  // `T_odom_expected` is where the motion model has the frame. A pose far from it, and any after
  // the vehicle was lost (`was_lost`), is believed only if its scan lies on the map as usual. One
  // where the vehicle was expected may have things before it that the map does not know, such as
  // passing lorries, as long as all else lies on the map as usual, or the camera's landmarks agree.
  Health Judge(const TrackedPose& tracked, const Rigid3d& T_odom_expected, bool was_lost) const;
  // Whether `challenger` lies on the map better than `champion` by more than `sigmas` standard
  // errors. A champion that what is not new, or the camera's landmarks, bear out is not replaced by
  // one that they do not.
  bool IsBetter(const TrackedPose& challenger, const TrackedPose& champion, double sigmas) const;
  double min_better_sigmas() const { return options_.min_better_sigmas; }

  // The pose was believed: its misfit is what is usual here.
  void Learn(const TrackedPose& tracked);
  double usual_misfit() const;

 private:
  bool IsConfirmed(const TrackedPose& tracked) const;
  // What is not new lies on the map as usual, and is enough to tell.
  bool LiesOnWhatIsKnown(const TrackedPose& tracked) const;
  bool CameraAgrees(const TrackedPose& tracked) const;
  // Share of the visual matches that agree with laser and prediction; 0 if there are too few.
  double CameraShare(const TrackedPose& tracked) const;

  HealthOptions options_;
  std::deque<double> misfits_;
};

}  // namespace tvl
