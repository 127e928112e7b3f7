#include "tvl/loop/loop_separation.h"

#include <algorithm>

#include "tvl/base/check.h"

namespace tvl {

void KeyframeTrack::Check() const {
  TVL_CHECK(path_m.size() == stamp.size() && T_world_lidar.size() == stamp.size())
      << "a track of " << stamp.size() << " stamps, " << path_m.size() << " lengths, "
      << T_world_lidar.size() << " poses";
}

void LoopSeparationOptions::Check() const {
  TVL_CHECK_INPUT(min_time_s >= 0.0) << "min_time_s must not be negative: " << min_time_s;
  TVL_CHECK_INPUT(min_path_m >= 0.0) << "min_path_m must not be negative: " << min_path_m;
  TVL_CHECK_INPUT(pass_gap_m > 0.0) << "pass_gap_m must be positive: " << pass_gap_m;
}

int EligibleHistory(const KeyframeTrack& track, int current, const LoopSeparationOptions& options) {
  track.Check();
  TVL_CHECK(current >= 0 && current < track.size())
      << "keyframe " << current << " of " << track.size();
  const size_t cur = static_cast<size_t>(current);
  const auto young_stamp = std::partition_point(
      track.stamp.begin(), track.stamp.begin() + current,
      [&](Timestamp t) { return SecondsBetween(t, track.stamp[cur]) > options.min_time_s; });
  const auto young_path = std::partition_point(
      track.path_m.begin(), track.path_m.begin() + current,
      [&](double path) { return track.path_m[cur] - path > options.min_path_m; });
  return static_cast<int>(
      std::min(young_stamp - track.stamp.begin(), young_path - track.path_m.begin()));
}

std::vector<std::vector<int>> SeparatePasses(const std::vector<int>& keyframes,
                                             const std::vector<double>& path_m,
                                             const LoopSeparationOptions& options) {
  std::vector<std::vector<int>> passes;
  for (const int k : keyframes) {
    const bool is_new =
        passes.empty() ||
        path_m.at(static_cast<size_t>(k)) - path_m.at(static_cast<size_t>(passes.back().back())) >
            options.pass_gap_m;
    if (is_new) passes.emplace_back();
    passes.back().push_back(k);
  }
  return passes;
}

}  // namespace tvl
