#include "tvl/loop/loop_evidence.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

double Distance_m(const SurfelMap& planes, const Eigen::Vector3d& p_odom, double largest_m) {
  const Surfel* surfel = planes.Find(p_odom);
  if (surfel == nullptr) return largest_m;
  return std::min(largest_m, std::abs(surfel->axis.dot(p_odom - surfel->mean)));
}

}  // namespace

void LoopEvidenceOptions::Check() const {
  TVL_CHECK_INPUT(trim_share > 0.0 && trim_share <= 1.0)
      << "loop_evidence.trim_share: must be in 0..1";
  TVL_CHECK_INPUT(unmatched_m > 0.0) << "loop_evidence.unmatched_m: must be positive";
}

double TrimmedRms_m(std::vector<double> distances_m, double share) {
  const auto kept =
      static_cast<size_t>(std::lround(share * static_cast<double>(distances_m.size())));
  if (kept == 0) return 0.0;
  std::sort(distances_m.begin(), distances_m.end());
  double sum = 0.0;
  for (size_t i = 0; i < kept; ++i) sum += distances_m[i] * distances_m[i];
  return std::sqrt(sum / static_cast<double>(kept));
}

LoopFit MeasureFit(const LoopSource& source, const LoopSubmap& submap,
                   const Rigid3d& T_odom_current) {
  int met = 0, through = 0;
  LoopFit fit;
  for (const Eigen::Vector3f& point : source.raised) {
    const Eigen::Vector3d p = T_odom_current * point.cast<double>();
    if (!submap.CouldSee(p)) continue;
    ++fit.raised;
    if (submap.IsOccupied(p)) {
      ++met;
    } else if (submap.SawThrough(p)) {
      ++through;
    }
  }
  const double raised = std::max(1, fit.raised);
  fit.overlap = met / raised;
  fit.seen_through = through / raised;
  return fit;
}

LoopEvidence MeasureEvidence(const LoopSource& source, const LoopSubmap& submap,
                             const Rigid3d& T_odom_current, const LoopEvidenceOptions& options) {
  std::vector<double> all_m, raised_m;
  for (size_t i = 0; i < source.planes.size(); ++i) {
    const Eigen::Vector3d p = T_odom_current * source.planes[i].cast<double>();
    if (!submap.CouldSee(p)) continue;
    all_m.push_back(Distance_m(submap.planes(), p, options.unmatched_m));
    if (source.plane_is_raised[i] != 0) raised_m.push_back(all_m.back());
  }
  LoopEvidence evidence;
  evidence.fit = MeasureFit(source, submap, T_odom_current);
  evidence.planes = static_cast<int>(all_m.size());
  evidence.rms_m = TrimmedRms_m(std::move(all_m), options.trim_share);
  evidence.raised_rms_m = TrimmedRms_m(std::move(raised_m), options.trim_share);
  return evidence;
}

}  // namespace tvl
