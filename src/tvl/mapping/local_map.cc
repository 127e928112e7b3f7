#include "tvl/mapping/local_map.h"

#include "tvl/base/check.h"

namespace tvl {

void LocalMapOptions::Check() const {
  TVL_CHECK_INPUT(keep_path_m > 0.0) << "local_map.keep_path_m: must be positive";
  planes.Check();
  lines.Check();
}

LocalMap::LocalMap(const LocalMapOptions& options)
    : options_(options), planes_(options.planes), lines_(options.lines) {
  options_.Check();
}

void LocalMap::Add(const Keyframe& keyframe, const Executor& executor) {
  planes_.Add(keyframe.cloud->planes.points, keyframe.T_world_lidar, executor);
  lines_.Add(keyframe.cloud->edges.points, keyframe.T_world_lidar, executor);
  members_.push_back(keyframe);
  while (keyframe.path_m - members_.front().path_m > options_.keep_path_m) {
    const Keyframe& old = members_.front();
    planes_.Remove(old.cloud->planes.points, old.T_world_lidar, executor);
    lines_.Remove(old.cloud->edges.points, old.T_world_lidar, executor);
    members_.pop_front();
  }
}

}  // namespace tvl
