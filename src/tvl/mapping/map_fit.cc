#include "tvl/mapping/map_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// So many keyframes see a place well: the map's surfels are there.
constexpr size_t kEnoughKeyframes = 10;
constexpr int kColumnBelow = 4;  // voxels of 2 m: what stands is seldom higher than 8 m

// A cluster of so many judged points, of which most lie off the map by more than the full misfit,
// was not there when the map was made: a wrong pose leaves some of a thing's surfaces on the map.
constexpr double kNewObjectPoints = 8.0, kNewObjectCost = 0.6;

double CostOf(const Eigen::Vector3d& p_odom, const LocalMap& map, double max_distance_m) {
  double distance_m = max_distance_m;
  const Surfel* plane = map.planes().Find(p_odom);
  if (plane != nullptr) {
    distance_m = std::min(distance_m, std::abs(plane->axis.dot(p_odom - plane->mean)));
  }
  const Surfel* line = map.lines().Find(p_odom);
  if (line != nullptr) {
    distance_m = std::min(distance_m, (p_odom - line->mean).cross(line->axis).norm());
  }
  const double share = distance_m / max_distance_m;
  return share * share;
}

// Of the points of one cluster.
struct ClusterSum {
  double weight = 0.0, cost = 0.0;
};

std::map<int32_t, ClusterSum> SumByCluster(const MapFit& fit) {
  std::map<int32_t, ClusterSum> clusters;
  for (size_t i = 0; i < fit.label.size(); ++i) {
    ClusterSum& cluster = clusters[fit.label[i]];
    const auto weight = static_cast<double>(fit.weight[i]);
    cluster.weight += weight;
    cluster.cost += weight * static_cast<double>(fit.cost[i]);
  }
  return clusters;
}

bool IsNewObject(int32_t label, const ClusterSum& cluster) {
  return label >= kFirstClusterLabel && cluster.weight >= kNewObjectPoints &&
         cluster.cost > kNewObjectCost * cluster.weight;
}

// Labels of what neither fit explains.
std::set<int32_t> NewObjectsInBoth(const MapFit& a, const MapFit& b) {
  const std::map<int32_t, ClusterSum> in_a = SumByCluster(a), in_b = SumByCluster(b);
  std::set<int32_t> labels;
  for (const auto& [label, cluster] : in_a) {
    if (IsNewObject(label, cluster) && IsNewObject(label, in_b.at(label))) labels.insert(label);
  }
  return labels;
}

}  // namespace

void MapFitOptions::Check() const {
  TVL_CHECK_INPUT(max_distance_m > 0.0) << "map_fit.max_distance_m: must be positive";
  TVL_CHECK_INPUT(max_range_m > 0.0) << "map_fit.max_range_m: must be positive";
  TVL_CHECK_INPUT(min_column_points >= 0.0) << "map_fit.min_column_points: must not be negative";
  TVL_CHECK_INPUT(max_points >= 50) << "map_fit.max_points: must be at least 50";
}

double Evidence(const MapFit& fit) { return fit.judged * (1.0 - 2.0 * fit.mean); }

double EvidenceSigmas(const MapFit& fit, int correlated) {
  double variance = 0.0;
  for (size_t i = 0; i < fit.cost.size(); ++i) {
    const double weighted = static_cast<double>(fit.weight[i]);
    const double excess = 2.0 * (static_cast<double>(fit.cost[i]) - fit.mean);
    variance += weighted * weighted * (excess * excess);
  }
  // At least as uncertain as if one group of neighbours were all wrong.
  const double group = correlated;
  return Evidence(fit) / std::sqrt(group * variance + group * group);
}

std::vector<FitSample> SampleForFit(const std::vector<LaserFeature>& features,
                                    const MapFitOptions& options) {
  const auto max_range_m = static_cast<float>(options.max_range_m);
  std::vector<FitSample> all;
  for (uint32_t i = 0; i < features.size(); ++i) {
    if (features[i].label != kLabelGround && features[i].p_lidar.norm() < max_range_m) {
      all.push_back({i, features[i].label});
    }
  }
  const auto wanted = static_cast<size_t>(options.max_points);
  if (all.size() <= wanted) return all;
  std::vector<FitSample> sample(wanted);
  for (size_t k = 0; k < wanted; ++k) sample[k] = all[k * all.size() / wanted];
  return sample;
}

MapFit FitToMap(const std::vector<Eigen::Vector3f>& points, const std::vector<FitSample>& sample,
                const LocalMap& map, const Rigid3d& T_odom_lidar, const MapFitOptions& options) {
  MapFit fit;
  fit.cost.reserve(sample.size());
  const Eigen::Matrix3d R = T_odom_lidar.R();
  const auto keyframes = static_cast<double>(std::min(map.size(), kEnoughKeyframes));
  const double well_seen = options.min_column_points * keyframes;
  double sum = 0.0;
  for (const FitSample& point : sample) {
    const Eigen::Vector3d p_odom = R * points[point.index].cast<double>() + T_odom_lidar.t();
    const auto seen = static_cast<double>(map.planes().PointsInColumn(p_odom, kColumnBelow));
    const double weight = std::min(1.0, seen / std::max(1.0, well_seen));
    const double cost = weight > 0.0 ? CostOf(p_odom, map, options.max_distance_m) : 0.0;
    fit.cost.push_back(static_cast<float>(cost));
    fit.weight.push_back(static_cast<float>(weight));
    fit.label.push_back(point.label);
    sum += weight * cost;
    fit.judged += weight;
  }
  if (fit.judged > 0.0) fit.mean = sum / fit.judged;
  return fit;
}

KnownFit FitWithoutNewClusters(const MapFit& fit) {
  KnownFit known;
  double sum = 0.0;
  for (const auto& [label, cluster] : SumByCluster(fit)) {
    if (IsNewObject(label, cluster)) {
      known.new_clusters.insert(label);
      continue;
    }
    known.judged += cluster.weight;
    sum += cluster.cost;
  }
  if (known.judged > 0.0) known.mean = sum / known.judged;
  return known;
}

FitComparison Compare(const MapFit& a, const MapFit& b, int correlated) {
  TVL_CHECK(a.cost.size() == b.cost.size()) << "fits of the same points";
  const std::set<int32_t> left_out = NewObjectsInBoth(a, b);
  FitComparison comparison;
  double sum = 0.0, sum_sq = 0.0, weights_sq = 0.0;
  for (size_t i = 0; i < a.cost.size(); ++i) {
    if (left_out.count(a.label[i]) > 0) continue;
    const double weight = std::min(a.weight[i], b.weight[i]);
    const double difference = static_cast<double>(b.cost[i]) - static_cast<double>(a.cost[i]);
    sum += weight * difference;
    sum_sq += weight * difference * difference;
    weights_sq += weight * weight;
    comparison.common += weight;
  }
  if (comparison.common <= 0.0) return comparison;
  comparison.better = sum / comparison.common;
  const double variance =
      std::max(0.0, sum_sq / comparison.common - comparison.better * comparison.better);
  const double independent = comparison.common * comparison.common / weights_sq / correlated;
  // At least as uncertain as if one group of neighbours were all wrong.
  comparison.standard_error = std::sqrt((variance + 1.0 / independent) / independent);
  return comparison;
}

}  // namespace tvl
