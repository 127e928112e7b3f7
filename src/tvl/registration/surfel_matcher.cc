#include "tvl/registration/surfel_matcher.h"

#include <algorithm>
#include <cmath>

#include "tvl/registration/beam_directions.h"

namespace tvl {
namespace {

constexpr size_t kChunk = 256;

// Variance of a residual: scatter of the surface, the error of the surfel's normal at the lever arm
// to its mean, and the point's own errors: along its beam, and across it in elevation, which far
// out on the road is the greater by much.
double PlaneInformation(const Surfel& surfel, const Eigen::Vector3d& p_world,
                        const Eigen::Vector3d& p_body, const Eigen::Matrix3d& R,
                        const MatchNoise& noise) {
  const double lever_sq = (p_world - surfel.mean).squaredNorm();
  const BeamDirections beam = DirectionsAt(p_body);
  const Eigen::Vector3d n_body = R.transpose() * surfel.axis;
  const double across_m = noise.beam_sigma_rad * n_body.dot(beam.elevation);
  const double variance =
      surfel.thickness_sq_m2 * (1.0 + lever_sq / (surfel.count * surfel.extent_sq_m2)) +
      noise.sensor_sigma_m * noise.sensor_sigma_m + across_m * across_m;
  return 1.0 / variance;
}

}  // namespace

std::vector<PlaneMatch> MatchPlanes(const std::vector<Eigen::Vector3f>& points,
                                    const SurfelMap& map, const Rigid3d& T, double gate_m,
                                    const MatchNoise& noise, const Executor& executor) {
  std::vector<PlaneMatch> all(points.size());
  const Eigen::Matrix3d R = T.R();
  executor.For(points.size(), kChunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d p_body = points[i].cast<double>();
      const Eigen::Vector3d p_world = R * p_body + T.t();
      const Surfel* surfel = map.Find(p_world);
      all[i].information = 0.0;
      if (surfel == nullptr) continue;
      if (std::abs(surfel->axis.dot(p_world - surfel->mean)) > gate_m) continue;
      all[i].source = static_cast<uint32_t>(i);
      all[i].factor = {p_body, surfel->axis, surfel->mean};
      all[i].information = PlaneInformation(*surfel, p_world, p_body, R, noise);
    }
  });
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const PlaneMatch& m) { return m.information == 0.0; }),
            all.end());
  return all;
}

std::vector<LineMatch> MatchLines(const std::vector<Eigen::Vector3f>& points, const SurfelMap& map,
                                  const Rigid3d& T, double gate_m, const MatchNoise& noise) {
  std::vector<LineMatch> matches;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p_body = point.cast<double>();
    const Eigen::Vector3d p_world = T * p_body;
    const Surfel* surfel = map.Find(p_world);
    if (surfel == nullptr) continue;
    if ((p_world - surfel->mean).cross(surfel->axis).norm() > gate_m) continue;
    LineMatch match;
    match.factor = {p_body, surfel->axis, surfel->mean};
    match.information = 1.0 / (surfel->thickness_sq_m2 + noise.edge_sigma_m * noise.edge_sigma_m);
    matches.push_back(match);
  }
  return matches;
}

}  // namespace tvl
