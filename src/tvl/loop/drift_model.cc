#include "tvl/loop/drift_model.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Ends of the loops by keyframe, as a compressed list: those of k are
// ends[first[k]] .. ends[first[k + 1] - 1].
struct Adjacency {
  std::vector<size_t> first, ends;
};

Adjacency LinksOf(const std::vector<LoopLink>& loops, size_t keyframes, size_t count) {
  Adjacency links;
  links.first.assign(count + 1, 0);
  std::vector<std::pair<size_t, size_t>> directed;
  for (const LoopLink& loop : loops) {
    TVL_CHECK(loop.from >= 0 && loop.to >= 0) << "loop " << loop.from << " - " << loop.to;
    const size_t from = static_cast<size_t>(loop.from), to = static_cast<size_t>(loop.to);
    TVL_CHECK(from < keyframes && to < keyframes)
        << "loop " << from << " - " << to << " of " << keyframes << " keyframes";
    if (from >= count || to >= count) continue;
    directed.emplace_back(from, to);
    directed.emplace_back(to, from);
  }
  std::sort(directed.begin(), directed.end());
  for (const auto& [from, to] : directed) {
    ++links.first[from + 1];
    links.ends.push_back(to);
  }
  for (size_t k = 0; k < count; ++k) links.first[k + 1] += links.first[k];
  return links;
}

}  // namespace

std::vector<double> LinkedPath(const std::vector<double>& path_m,
                               const std::vector<LoopLink>& loops, int current) {
  TVL_CHECK(current >= 0 && static_cast<size_t>(current) < path_m.size())
      << "keyframe " << current << " of " << path_m.size();
  const size_t count = static_cast<size_t>(current) + 1;
  const Adjacency links = LinksOf(loops, path_m.size(), count);

  std::vector<double> distance_m(count, std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, size_t>;  // distance, keyframe
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto relax = [&](size_t k, double d) {
    if (d >= distance_m[k]) return;
    distance_m[k] = d;
    queue.emplace(d, k);
  };
  relax(count - 1, 0.0);
  while (!queue.empty()) {
    const auto [d, k] = queue.top();
    queue.pop();
    if (d > distance_m[k]) continue;
    if (k > 0) relax(k - 1, d + path_m[k] - path_m[k - 1]);
    if (k + 1 < count) relax(k + 1, d + path_m[k + 1] - path_m[k]);
    for (size_t i = links.first[k]; i < links.first[k + 1]; ++i) relax(links.ends[i], d);
  }
  return distance_m;
}

double DriftRadius::Of(double linked_path_m) const {
  return std::max(floor_m, share * linked_path_m);
}

void DriftOptions::Check() const {
  const auto check = [](double floor_m, double share, const char* name) {
    TVL_CHECK_INPUT(floor_m > 0.0) << name << "_floor_m must be positive: " << floor_m;
    TVL_CHECK_INPUT(share >= 0.0 && share <= 1.0)
        << name << "_share must be between 0 and 1: " << share;
  };
  check(visual_floor_m, visual_share, "visual");
  check(vicinity_floor_m, vicinity_share, "vicinity");
  check(lidar_floor_m, lidar_share, "lidar");
}

}  // namespace tvl
