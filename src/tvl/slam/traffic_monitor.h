// Whether the traffic around the vehicle carries the estimate with it. In a jam lorries and cars
// are most of what the lidar sees, and moving together they look like a world that stands. The road
// does not move, nor does what stands beside it: where the motion over the road (road_motion.h), or
// against what stands beside it, and the estimate drift apart for several frames in the same
// direction, what stands on the road is no longer believed.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "tvl/frame/preprocessed_frame.h"
#include "tvl/mapping/map_fit.h"
#include "tvl/odometry/road_motion.h"
#include "tvl/slam/motion_model.h"

namespace tvl {

struct TrafficOptions {
  // The estimate is carried away if, over so many frames, it differs from the road by so much, this
  // share of the way, and three standard deviations of the road's motion, and so many of the frames
  // differ in that direction. Camera and lidar, in good order, differ by less (measured on KITTI
  // and KITTI-360: 0.007 m a frame at walking speed, 4 % of a step at 10 m/s, either sign).
  int window_frames = 5, min_slipping_frames = 3;
  double min_slip_m = 0.04, slip_share = 0.04;
  // Faster than this, traffic is not dense enough to hide everything else.
  double max_speed_m_s = 6.0;
  // What stands so near to the line of travel may be traffic: two lanes to each side.
  double corridor_m = 8.0;
  // Of the tracks on the road, to overrule what the scan says of the first motions: so many must
  // agree, and be twice as many as agree with the scan.
  double min_start_share = 0.5;
  // What stands beside the vehicle is believed again when it has moved as the road does for so long
  // a way: no queue stands beside one that moves for longer.
  double release_m = 20.0;
  // ... or when the road has not been seen for so many frames: without it nothing overrules the
  // scan.
  int max_frames_without_road = 20;
  // What stands in the corridor moves, at least in part, where so much of it lies off the map (mean
  // cost, as MapFit::mean). In a street that stands still: up to 0.08 (KITTI-360, hedges and
  // parked cars); among moving cars 0.23 to 0.31 (drive 0052).
  double min_moving_misfit = 0.12;
  // What stands beside the corridor tells the motion if its standard deviation, without what was
  // expected, is no larger: 0.3 m, by which no claimed step may be off, are four of them.
  double max_surroundings_sigma_m = 0.075;
  void Check() const;  // throws InputError naming the field
};

// A motion by what certainly stands: the road, or what is beside it.
struct StandingMotion {
  Rigid3d T_prev_cur;
  Eigen::Matrix2d covariance_m2;  // of x and y
  // Believed from a single frame, whatever the whole scan says. Shadows move over the road with
  // those who cast them: with some of them among the tracks, several frames must agree.
  bool decides_alone = false;

  static StandingMotion Of(const RoadMotion& road);
};

class TrafficMonitor {
 public:
  explicit TrafficMonitor(const TrafficOptions& options);

  // The motion of the vehicle over duration_s, as the scan as a whole says and as what certainly
  // stands does. Returns how far the estimate has been carried away when that is noticed, else
  // zero: x, y in the lidar frame, m.
  Eigen::Vector2d Update(const Rigid3d& T_prev_cur, const std::optional<StandingMotion>& standing,
                         double duration_s);
  // Slow enough for traffic to be dense.
  bool MayBeAmongTraffic(const Rigid3d& T_prev_cur, double duration_s) const {
    return T_prev_cur.t().head<2>().norm() <= options_.max_speed_m_s * duration_s;
  }
  // The poses before and after do not belong together, or the scan said nothing.
  void Interrupt() { window_.clear(); }
  // Whether most tracks agree on the motion, and few of them with what was guessed: while nothing
  // is expected of the motion, that is as good as it gets.
  bool HasMajority(const RoadMotion& road) const;
  // Of the first motion there is, which nothing was expected of. Returns carries_estimate().
  bool Start(const Rigid3d& T_prev_cur, const RoadMotion& road, double duration_s);
  // Whether what stands in the corridor moves, at least in part: `fit` is that of the frame's
  // points, the motion took duration_s.
  bool IsAmongMovingThings(const LaserFeatures& features, const MapFit& fit,
                           const Rigid3d& T_prev_cur, double duration_s) const;
  // The motion by a frame without traffic, where that tells: `found` with its covariance, from
  // which what was `expected` is taken out again.
  std::optional<StandingMotion> Surroundings(const Rigid3d& found, const Matrix6d& covariance,
                                             const MotionPrediction& expected) const;
  // Whether a motion of the whole scan cannot be true beside `standing`, from this frame alone.
  bool Contradicts(const StandingMotion& standing, const Rigid3d& T_prev_cur) const;
  // The estimate would be carried away: what may be traffic is to be left out.
  bool carries_estimate() const { return carries_; }
  int frames_without_road() const { return frames_without_road_; }
  void Forget();

  // Leaves in the frame only what is known not to be traffic: laser features of the ground and of
  // what stands beside the corridor, and tracks that move with the road. Any other track may be on
  // a lorry, above the lidar's sight or at its edge. Returns how many tracks were taken out.
  int RemoveTraffic(const std::optional<RoadMotion>& road, PreprocessedFrame* frame) const;

 private:
  struct Slip {
    Eigen::Vector2d slip_m;  // of the estimate against what stands, x and y in the lidar frame
    Eigen::Matrix2d covariance_m2;
    double step_m;
  };
  Eigen::Vector2d Slip_m() const;
  bool IsSlipping() const;
  // More than what the two differ by in good order.
  bool IsSignificant(const Slip& slip) const;

  TrafficOptions options_;
  std::deque<Slip> window_;
  bool carries_ = false;
  double agreeing_m_ = 0.0;  // way since the scan last contradicted the road
  int frames_without_road_ = 0;
};

}  // namespace tvl
