#include "tvl/slam/pose_search.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Multiples of the last motion that are tried: between them the map step's catchment of one voxel
// reaches at town speed, beyond them the alignment without a guess does.
constexpr int kMultiples[] = {1, 0, 2, 3, 4};

// Seen from above: the points that stand above the ground.
std::vector<Eigen::Vector2f> Raised(const std::vector<Eigen::Vector3f>& points,
                                    double min_height_m) {
  const std::vector<char> is_raised = AboveGround(points, min_height_m);
  std::vector<Eigen::Vector2f> raised;
  for (size_t i = 0; i < points.size(); ++i) {
    if (is_raised[i] != 0) raised.push_back(points[i].head<2>());
  }
  return raised;
}

// Wheels roll along the heading: a vehicle has moved in a direction between the one it looked in
// and the one it looks in now. Of the way it has moved, so much may be across, as when changing
// lanes in a hurry (3.5 m in 10 m), and the known pose may be off by a little.
bool IsSideways(const Eigen::Vector2d& moved_m, double yaw_rad) {
  constexpr double kShare = 0.35, kMargin_m = 0.5;
  const double direction_rad = std::atan2(moved_m.y(), moved_m.x());
  const double beyond_rad = std::max(
      {std::min(0.0, yaw_rad) - direction_rad, direction_rad - std::max(0.0, yaw_rad), 0.0});
  const double across_m = moved_m.norm() * std::sin(std::min(beyond_rad, 1.57));
  return across_m > kMargin_m + kShare * moved_m.norm();
}

}  // namespace

std::vector<Eigen::Vector3f> AllPoints(const KeyframeCloud& cloud) {
  std::vector<Eigen::Vector3f> points = cloud.planes.points;
  points.insert(points.end(), cloud.edges.points.begin(), cloud.edges.points.end());
  return points;
}

void PoseSearchOptions::Check() const {
  TVL_CHECK_INPUT(radius_m > 0.0 && start_radius_m > 0.0)
      << "search.radius_m, start_radius_m: must be positive";
  TVL_CHECK_INPUT(yaw_window_rad > 0.0 && max_yaw_window_rad >= yaw_window_rad)
      << "search.yaw_window_rad, max_yaw_window_rad: want 0 < window <= max";
  TVL_CHECK_INPUT(lost_yaw_rate_rad_per_s >= 0.0)
      << "search.lost_yaw_rate_rad_per_s: must not be negative";
  TVL_CHECK_INPUT(min_height_m > 0.0) << "search.min_height_m: must be positive";
  TVL_CHECK_INPUT(max_followed >= 1) << "search.max_followed: must be at least 1";
  bev.Check();
}

std::vector<MotionPrediction> AlternativeMotions(const MotionModel& model,
                                                 const FrameInterval& interval) {
  std::vector<int> periods = {interval.periods};
  const auto add = [&](int n) {
    if (std::find(periods.begin(), periods.end(), n) == periods.end()) periods.push_back(n);
  };
  add(interval.nearest_periods);
  for (const int multiple : kMultiples) add(multiple);
  std::vector<MotionPrediction> motions;
  for (const int n : periods) motions.push_back(model.Predict(n, interval.period_s));
  return motions;
}

bool IsReachable(const MotionModel& model, int max_periods, double period_s,
                 const Rigid3d& T_known_cur) {
  constexpr double kAcceleration_m_s2 = 4.0;  // braking and cornering of a car in a hurry
  constexpr double kMargin_m = 0.5;           // of the pose before
  if (!model.known()) return true;
  const Eigen::Vector2d moved_m = T_known_cur.t().head<2>();
  const double yaw_rad = T_known_cur.Log()(2);
  const bool can_be_ahead = !IsSideways(moved_m, yaw_rad);
  const bool can_be_behind = !IsSideways(-moved_m, yaw_rad);
  const double speed_m_s = model.T_period().t().x() / period_s;
  for (int periods = 1; periods <= max_periods; ++periods) {
    const double time_s = periods * period_s;
    const double reach_m = kMargin_m + 0.5 * kAcceleration_m_s2 * time_s * time_s;
    const Eigen::Vector3d straight_m = periods * model.T_period().t();
    if ((T_known_cur.t() - straight_m).norm() >= reach_m) continue;
    // Half the time to come to a stand, half to reverse.
    const bool may_reverse = speed_m_s < 0.5 * kAcceleration_m_s2 * time_s;
    if (can_be_ahead || (may_reverse && can_be_behind)) return true;
  }
  return false;
}

std::vector<Rigid3d> AlignWithoutGuess(const std::vector<Eigen::Vector3f>& points,
                                       const LocalMap& map, const Rigid3d& T_odom_known,
                                       double radius_m, double yaw_window_rad,
                                       const PoseSearchOptions& options, const Executor& executor) {
  const Rigid3d T_known_odom = T_odom_known.Inverse();
  const double reach_m = radius_m + options.bev.range_m;
  std::vector<Eigen::Vector3f> occupied;
  for (const Eigen::Vector3f& p_odom : map.planes().OccupiedPlaces()) {
    const Eigen::Vector3d p = T_known_odom * p_odom.cast<double>();
    if (p.head<2>().norm() < reach_m) occupied.push_back(p.cast<float>());
  }
  BevTarget target;
  target.raised = Raised(occupied, options.min_height_m);
  for (const Eigen::Vector3d& p_odom : map.planes().KnownPlaces()) {
    const Eigen::Vector3d p = T_known_odom * p_odom;
    if (p.head<2>().norm() < reach_m) target.known.push_back(p.head<2>().cast<float>());
  }
  // Rings on the road are up to a voxel apart: with its neighbours each stands for the ground.
  target.known_m = 3.0 * map.planes().coarsest_m();
  BevSearch search;
  search.radius_m = radius_m;
  search.yaw_window_rad = yaw_window_rad;
  std::vector<Rigid3d> poses;
  for (const BevPeak& peak : AlignBevToKnown(target, Raised(points, options.min_height_m), search,
                                             options.bev, executor)) {
    const Rigid3d T_known_cur(ExpSo3({0.0, 0.0, peak.yaw_rad}),
                              Eigen::Vector3d(peak.x_m, peak.y_m, 0.0));
    poses.push_back(T_odom_known * T_known_cur);
  }
  return poses;
}

}  // namespace tvl
