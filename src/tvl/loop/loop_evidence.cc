#include "tvl/loop/loop_evidence.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Positions of every few keyframes: coverage is no matter of a metre.
class Coverage {
 public:
  Coverage(const LoopSubmap& submap, double reach_m) : reach_sq_(reach_m * reach_m) {
    for (const auto& member : submap.members()) {
      const Eigen::Vector2d p = member.second.t().head<2>();
      if (places_.empty() || (p - places_.back()).norm() > 0.15 * reach_m) places_.push_back(p);
    }
  }
  bool Has(const Eigen::Vector3d& p_odom) const {
    return std::any_of(places_.begin(), places_.end(), [&](const Eigen::Vector2d& place) {
      return (p_odom.head<2>() - place).squaredNorm() < reach_sq_;
    });
  }

 private:
  double reach_sq_;
  std::vector<Eigen::Vector2d> places_;
};

double Distance_m(const SurfelMap& planes, const Eigen::Vector3d& p_odom, double largest_m) {
  const Surfel* surfel = planes.Find(p_odom);
  if (surfel == nullptr) return largest_m;
  return std::min(largest_m, std::abs(surfel->axis.dot(p_odom - surfel->mean)));
}

}  // namespace

void LoopEvidenceOptions::Check() const {
  TVL_CHECK_INPUT(coverage_m > 1.0) << "loop_evidence.coverage_m: must exceed 1";
  TVL_CHECK_INPUT(trim_share > 0.0 && trim_share <= 1.0)
      << "loop_evidence.trim_share: must be in 0..1";
  TVL_CHECK_INPUT(unmatched_m > 0.0) << "loop_evidence.unmatched_m: must be positive";
}

double TrimmedRms_m(std::vector<double> distances_m, double share) {
  const auto kept = static_cast<size_t>(share * static_cast<double>(distances_m.size()) + 0.5);
  if (kept == 0) return 0.0;
  std::sort(distances_m.begin(), distances_m.end());
  double sum = 0.0;
  for (size_t i = 0; i < kept; ++i) sum += distances_m[i] * distances_m[i];
  return std::sqrt(sum / static_cast<double>(kept));
}

LoopEvidence MeasureEvidence(const LoopSource& source, const LoopSubmap& submap,
                             const Rigid3d& T_odom_current, const LoopEvidenceOptions& options) {
  const Coverage coverage(submap, options.coverage_m);
  std::vector<double> all_m, raised_m;
  for (size_t i = 0; i < source.planes.size(); ++i) {
    const Eigen::Vector3d p = T_odom_current * source.planes[i].cast<double>();
    if (!coverage.Has(p)) continue;
    all_m.push_back(Distance_m(submap.planes(), p, options.unmatched_m));
    if (source.plane_is_raised[i] != 0) raised_m.push_back(all_m.back());
  }
  int met = 0;
  LoopEvidence evidence;
  for (const Eigen::Vector3f& point : source.raised) {
    const Eigen::Vector3d p = T_odom_current * point.cast<double>();
    if (!coverage.Has(p)) continue;
    ++evidence.raised;
    if (submap.IsOccupied(p)) ++met;
  }
  evidence.planes = static_cast<int>(all_m.size());
  evidence.overlap = evidence.raised == 0 ? 0.0 : static_cast<double>(met) / evidence.raised;
  evidence.rms_m = TrimmedRms_m(std::move(all_m), options.trim_share);
  evidence.raised_rms_m = TrimmedRms_m(std::move(raised_m), options.trim_share);
  return evidence;
}

}  // namespace tvl
