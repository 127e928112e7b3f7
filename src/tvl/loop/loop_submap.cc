#include "tvl/loop/loop_submap.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {
namespace {

std::vector<Eigen::Vector3f> EveryNth(const std::vector<Eigen::Vector3f>& points, int n) {
  std::vector<Eigen::Vector3f> kept;
  kept.reserve(points.size() / static_cast<size_t>(n) + 1);
  for (size_t i = 0; i < points.size(); i += static_cast<size_t>(n)) kept.push_back(points[i]);
  return kept;
}

}  // namespace

void LoopSubmapOptions::Check() const {
  TVL_CHECK_INPUT(keyframes_each_way >= 1) << "loop_submap.keyframes_each_way: at least 1";
  TVL_CHECK_INPUT(every_keyframe >= 1) << "loop_submap.every_keyframe: at least 1";
  TVL_CHECK_INPUT(every_point >= 1) << "loop_submap.every_point: at least 1";
  TVL_CHECK_INPUT(every_view >= 1) << "loop_submap.every_view: must be at least 1";
  TVL_CHECK_INPUT(view_range_m > 1.0) << "loop_submap.view_range_m: must exceed 1";
  TVL_CHECK_INPUT(view_margin_m >= 0.0) << "loop_submap.view_margin_m: must not be negative";
  TVL_CHECK_INPUT(voxel_m > 0.05) << "loop_submap.voxel_m: must exceed 0.05";
  planes.Check();
  lines.Check();
}

LoopSubmap::LoopSubmap(const LoopSubmapOptions& options) : options_(options) {
  options_.Check();
  Clear();
}

void LoopSubmap::Clear() {
  members_.clear();
  views_.clear();
  planes_ = std::make_unique<SurfelMap>(options_.planes);
  lines_ = std::make_unique<SurfelMap>(options_.lines);
  occupancy_.Clear();
}

void LoopSubmap::MoveTo(int centre, int end, const std::vector<Rigid3d>& T_odom_lidar,
                        const KeyframeCloudSource& cloud, const Executor& executor) {
  TVL_CHECK(end <= static_cast<int>(T_odom_lidar.size()) && centre >= 0 && centre < end)
      << "keyframe " << centre << " of " << T_odom_lidar.size() << ", end " << end;
  const int first = std::max(0, centre - options_.keyframes_each_way);
  const int last = std::min(end - 1, centre + options_.keyframes_each_way);
  const bool is_far =
      members_.empty() || members_.rbegin()->first < centre || members_.begin()->first > centre;
  if (is_far) Clear();
  for (auto it = members_.begin(); it != members_.end();) {
    const bool stays = it->first >= first && it->first <= last;
    if (!stays) Change(*cloud(it->first), it->second, -1, executor);
    if (!stays) views_.erase(it->first);
    it = stays ? std::next(it) : members_.erase(it);
  }
  const int step = options_.every_keyframe;
  for (int k = (first + step - 1) / step * step; k <= last; k += step) {
    const Rigid3d& T = T_odom_lidar[static_cast<size_t>(k)];
    if (!members_.emplace(k, T).second) continue;
    const std::shared_ptr<const KeyframeCloud> added = cloud(k);
    Change(*added, T, 1, executor);
    if (k % (options_.every_keyframe * options_.every_view) == 0)
      views_.emplace(k, View{T.t(), T.Inverse(), SeenRanges(*added)});
  }
  DropEmpty();
}

// Voxels left behind would pile up over a long drive.
void LoopSubmap::DropEmpty() {
  const auto& entries = occupancy_.entries();
  const auto empty = static_cast<size_t>(std::count_if(
      entries.begin(), entries.end(), [](const auto& entry) { return entry.value == 0; }));
  if (2 * empty <= entries.size()) return;
  VoxelHash<int32_t> kept;
  for (const auto& entry : entries) {
    if (entry.value > 0) kept[entry.key] = entry.value;
  }
  occupancy_ = std::move(kept);
}

void LoopSubmap::Change(const KeyframeCloud& cloud, const Rigid3d& T_odom_lidar, int sign,
                        const Executor& executor) {
  const std::vector<Eigen::Vector3f> planes = EveryNth(cloud.planes.points, options_.every_point);
  const std::vector<Eigen::Vector3f>& edges = cloud.edges.points;
  const std::vector<std::function<void()>> tasks = {
      [&] {
        sign > 0 ? planes_->Add(planes, T_odom_lidar, executor)
                 : planes_->Remove(planes, T_odom_lidar, executor);
      },
      [&] {
        sign > 0 ? lines_->Add(edges, T_odom_lidar, executor)
                 : lines_->Remove(edges, T_odom_lidar, executor);
      },
      [&] {
        Count(planes, T_odom_lidar, sign);
        Count(edges, T_odom_lidar, sign);
      }};
  for (const auto& task : tasks) task();
}

void LoopSubmap::Count(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_odom_lidar,
                       int sign) {
  const Eigen::Matrix3d R = T_odom_lidar.R();
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3d p_odom = R * p.cast<double>() + T_odom_lidar.t();
    occupancy_[VoxelKey::Of(p_odom, options_.voxel_m)] += sign;
  }
}

bool LoopSubmap::IsOccupied(const Eigen::Vector3d& p_odom) const {
  const int32_t* count = occupancy_.Find(VoxelKey::Of(p_odom, options_.voxel_m));
  return count != nullptr && *count > 0;
}

bool LoopSubmap::SawAtLeast(const Eigen::Vector3d& p_odom, double further_m) const {
  constexpr double kRounding_m = 0.01;  // of the float range below, and much more
  const double range_m = options_.view_range_m + kRounding_m;
  return std::any_of(views_.begin(), views_.end(), [&](const auto& entry) {
    const View& view = entry.second;
    if ((p_odom - view.place_odom).squaredNorm() > range_m * range_m) return false;
    const Eigen::Vector3f p = (view.T_lidar_odom * p_odom).template cast<float>();
    const double distance_m = p.norm();
    return distance_m < options_.view_range_m && view.seen.Towards(p) > distance_m + further_m;
  });
}

bool LoopSubmap::CouldSee(const Eigen::Vector3d& p_odom) const {
  return SawAtLeast(p_odom, -options_.view_margin_m);
}

bool LoopSubmap::SawThrough(const Eigen::Vector3d& p_odom) const {
  return SawAtLeast(p_odom, options_.view_margin_m);
}

std::vector<Eigen::Vector3d> LoopSubmap::OccupiedCentres() const {
  std::vector<Eigen::Vector3d> centres;
  for (const auto& entry : occupancy_.entries()) {
    if (entry.value > 0) centres.push_back(entry.key.Centre(options_.voxel_m));
  }
  return centres;
}

}  // namespace tvl
