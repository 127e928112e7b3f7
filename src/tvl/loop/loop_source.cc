#include "tvl/loop/loop_source.h"

#include "tvl/base/check.h"
#include "tvl/geometry/voxel_thinning.h"
#include "tvl/loop/bev_alignment.h"

namespace tvl {
namespace {

void Append(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T, double range_m,
            std::vector<Eigen::Vector3f>* all) {
  const Eigen::Matrix3f R = T.R().cast<float>();
  const Eigen::Vector3f t = T.t().cast<float>();
  const auto range_sq = static_cast<float>(range_m * range_m);
  for (const Eigen::Vector3f& p : points) {
    if (p.squaredNorm() < range_sq) all->push_back(R * p + t);
  }
}

}  // namespace

void LoopSourceOptions::Check() const {
  TVL_CHECK_INPUT(keyframes_back >= 0) << "loop_source.keyframes_back: must not be negative";
  TVL_CHECK_INPUT(every_keyframe >= 1) << "loop_source.every_keyframe: at least 1";
  TVL_CHECK_INPUT(range_m > 1.0) << "loop_source.range_m: must exceed 1";
  TVL_CHECK_INPUT(plane_voxel_m > 0.0 && edge_voxel_m > 0.0 && raised_voxel_m > 0.0)
      << "loop_source.*_voxel_m: must be positive";
  TVL_CHECK_INPUT(raised_m > 0.0) << "loop_source.raised_m: must be positive";
}

LoopSource AssembleSource(int current, const std::vector<Rigid3d>& T_odom_lidar,
                          const KeyframeCloudSource& cloud, const LoopSourceOptions& options) {
  TVL_CHECK(current >= 0 && current < static_cast<int>(T_odom_lidar.size()))
      << "keyframe " << current << " of " << T_odom_lidar.size();
  const Rigid3d T_current_odom = T_odom_lidar[static_cast<size_t>(current)].Inverse();
  std::vector<Eigen::Vector3f> points, edges;
  for (int k = current; k >= std::max(0, current - options.keyframes_back);
       k -= options.every_keyframe) {
    const std::shared_ptr<const KeyframeCloud> keyframe = cloud(k);
    const Rigid3d T_current_k = T_current_odom * T_odom_lidar[static_cast<size_t>(k)];
    Append(keyframe->planes.points, T_current_k, options.range_m, &points);
    Append(keyframe->edges.points, T_current_k, options.range_m, &edges);
  }
  const size_t planes = points.size();
  points.insert(points.end(), edges.begin(), edges.end());
  const std::vector<char> is_raised = AboveGround(points, options.raised_m);
  LoopSource source;
  std::vector<Eigen::Vector3f> raised;
  for (size_t i = 0; i < points.size(); ++i) {
    if (is_raised[i] != 0) raised.push_back(points[i]);
  }
  for (const uint32_t i : MiddleOfEachVoxel(raised, options.raised_voxel_m))
    source.raised.push_back(raised[i]);
  for (const uint32_t i : MiddleOfEachVoxel(edges, options.edge_voxel_m))
    source.edges.push_back(edges[i]);
  points.resize(planes);
  for (const uint32_t i : MiddleOfEachVoxel(points, options.plane_voxel_m)) {
    source.planes.push_back(points[i]);
    source.plane_is_raised.push_back(is_raised[i]);
  }
  return source;
}

}  // namespace tvl
