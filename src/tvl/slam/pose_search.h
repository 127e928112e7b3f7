// Where a frame may be if it is not where constant velocity has it: hypotheses for FrameTracker to
// follow. Asked for where there is doubt, and while lost.
#pragma once

#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/map/keyframe.h"
#include "tvl/mapping/local_map.h"
#include "tvl/slam/frame_clock.h"
#include "tvl/slam/motion_model.h"
#include "tvl/slam/pose_search_options.h"

namespace tvl {

// Constant velocity over the periods that the stamps say, and over others: the vehicle has stopped;
// the stamp is wrong; scans are missing. The most probable first.
std::vector<MotionPrediction> AlternativeMotions(const MotionModel& model,
                                                 const FrameInterval& interval);

// Scans that may have been lost without a word: three seconds.
inline constexpr int kMostLostPeriods = 31;
// Whether a vehicle that moved as `model` says can have moved by T_known_cur since, in any number
// of periods up to max_periods: without braking, speeding up or sliding sideways as no car does.
// True where no velocity is known.
bool IsReachable(const MotionModel& model, int max_periods, double period_s,
                 const Rigid3d& T_known_cur);

// Coarse alignments of what stands about the vehicle with the local map, which need no guess of the
// motion: T_odom_lidar, best first. `points` are compensated, p_lidar, m, ground included;
// `T_odom_known` is the last pose that is known. Roll, pitch and height are that pose's.
std::vector<Rigid3d> AlignWithoutGuess(const std::vector<Eigen::Vector3f>& points,
                                       const LocalMap& map, const Rigid3d& T_odom_known,
                                       double radius_m, double yaw_window_rad,
                                       const PoseSearchOptions& options, const Executor& executor);

// What AlignWithoutGuess wants of a scan.
std::vector<Eigen::Vector3f> AllPoints(const KeyframeCloud& cloud);

}  // namespace tvl
