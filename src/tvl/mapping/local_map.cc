#include "tvl/mapping/local_map.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Beyond this a rotation alone counts as moved: 3 cm at 20 m.
constexpr double kToleranceRad = 1.5e-3;

bool HasMoved(const Rigid3d& from, const Rigid3d& to, double tolerance_m) {
  const Rigid3d motion = from.Inverse() * to;
  return motion.t().norm() > tolerance_m || motion.RotationAngle() > kToleranceRad;
}

}  // namespace

void LocalMapOptions::Check() const {
  TVL_CHECK_INPUT(keep_path_m > 0.0) << "local_map.keep_path_m: must be positive";
  TVL_CHECK_INPUT(connected_radius_m >= 0.0)
      << "local_map.connected_radius_m: must not be negative";
  TVL_CHECK_INPUT(connected_changes >= 1) << "local_map.connected_changes: must be at least 1";
  TVL_CHECK_INPUT(connected_tolerance_m > 0.0)
      << "local_map.connected_tolerance_m: must be positive";
  planes.Check();
  lines.Check();
}

LocalMap::LocalMap(const LocalMapOptions& options)
    : options_(options), planes_(options.planes), lines_(options.lines) {
  options_.Check();
}

void LocalMap::Add(const LocalMapMember& member, const Executor& executor) {
  Put(member, executor);
  members_.push_back(member);
  while (member.path_m - members_.front().path_m > options_.keep_path_m) {
    Take(members_.front(), executor);
    members_.pop_front();
  }
}

void LocalMap::Connect(const std::vector<Connected>& wanted, const FetchCloud& fetch,
                       const Executor& executor) {
  int changes = 0;
  for (auto it = connected_.begin();
       it != connected_.end() && changes < options_.connected_changes;) {
    const auto still = std::find_if(wanted.begin(), wanted.end(), [&](const Connected& c) {
      return c.keyframe == it->first &&
             !HasMoved(it->second.T_odom_lidar, c.T_odom_lidar, options_.connected_tolerance_m);
    });
    if (still != wanted.end()) {
      ++it;
      continue;
    }
    ++changes;
    Take(it->second, executor);
    const auto moved = std::find_if(wanted.begin(), wanted.end(),
                                    [&](const Connected& c) { return c.keyframe == it->first; });
    if (moved == wanted.end()) {
      it = connected_.erase(it);
      continue;
    }
    it->second.T_odom_lidar = moved->T_odom_lidar;
    Put(it->second, executor);
    ++it;
  }
  for (const Connected& next : wanted) {
    if (changes >= options_.connected_changes) return;
    if (connected_.count(next.keyframe) > 0 || IsRecent(next.keyframe)) continue;
    const LocalMapMember member{next.keyframe, 0.0, next.T_odom_lidar, fetch(next.keyframe)};
    Put(member, executor);
    connected_.emplace(next.keyframe, member);
    ++changes;
  }
}

void LocalMap::Put(const LocalMapMember& member, const Executor& executor) {
  planes_.Add(member.cloud->planes.points, member.T_odom_lidar, executor);
  lines_.Add(member.cloud->edges.points, member.T_odom_lidar, executor);
}

void LocalMap::Take(const LocalMapMember& member, const Executor& executor) {
  planes_.Remove(member.cloud->planes.points, member.T_odom_lidar, executor);
  lines_.Remove(member.cloud->edges.points, member.T_odom_lidar, executor);
}

bool LocalMap::IsRecent(int keyframe) const {
  return std::any_of(members_.begin(), members_.end(),
                     [&](const LocalMapMember& m) { return m.keyframe == keyframe; });
}

}  // namespace tvl
