#include "tvl/odometry/laser_matcher.h"

#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

std::vector<SweepFeatures::Entry> Prepare(const std::vector<LaserFeature>& features,
                                          const SweepBins& bins, double period_s,
                                          const Rigid3d& T_prev_cur) {
  std::vector<SweepFeatures::Entry> entries;
  entries.reserve(features.size());
  const Vector6d xi = T_prev_cur.Log();
  for (const LaserFeature& feature : features) {
    Eigen::Vector3d p = feature.p_lidar.cast<double>();
    const int bin = bins.BinOf(feature.time_offset_s, period_s);
    if (bins.bins > 1) {  // p at its own time -> at the middle of the bin, to first order
      const double rest = 1.0 + feature.time_offset_s / period_s - bins.Share(bin);
      p += rest * (xi.head<3>().cross(p) + xi.tail<3>());
    }
    entries.push_back({p, bin});
  }
  return entries;
}

}  // namespace

SweepFeatures PrepareSweep(const LaserFeatures& features, const SweepBins& bins, double period_s,
                           const Rigid3d& T_prev_cur) {
  return {Prepare(features.sharp, bins, period_s, T_prev_cur),
          Prepare(features.flat, bins, period_s, T_prev_cur)};
}

void LaserMatchOptions::Check() const {
  TVL_CHECK_INPUT(edge_sigma_m > 0.0) << "odometry.edge_sigma_m: must be positive";
  TVL_CHECK_INPUT(plane_sigma_m > 0.0) << "odometry.plane_sigma_m: must be positive";
}

LaserMatcher::LaserMatcher(RingCloud less_sharp, RingCloud less_flat)
    : less_sharp_(std::move(less_sharp)),
      less_flat_(std::move(less_flat)),
      line_known_(less_sharp_.size(), 0),
      plane_known_(less_flat_.size(), 0),
      lines_(less_sharp_.size()),
      planes_(less_flat_.size()) {}

const LocalFit* LaserMatcher::Lookup(const RingCloud& cloud, const Eigen::Vector3d& p,
                                     double gate_m, LocalFit (*fit)(const RingCloud&, uint32_t),
                                     std::vector<char>* known, std::vector<LocalFit>* fits) {
  Neighbour nearest;
  if (cloud.Nearest(p.cast<float>(), &nearest) == 0) return nullptr;
  if (nearest.distance_sq_m2 > gate_m * gate_m) return nullptr;
  if ((*known)[nearest.index] == 0) {
    (*known)[nearest.index] = 1;
    (*fits)[nearest.index] = fit(cloud, nearest.index);
  }
  const LocalFit& found = (*fits)[nearest.index];
  return found.valid ? &found : nullptr;
}

LaserMatches LaserMatcher::Match(const SweepFeatures& features, const SweepBins& bins,
                                 const Rigid3d& T_prev_cur, double gate_m,
                                 const LaserMatchOptions& options) {
  const SweepMotion motion(bins, T_prev_cur);
  LaserMatches matches;
  for (const auto& entry : features.flat) {
    const SweepMotion::Bin& bin = motion.bins[static_cast<size_t>(entry.bin)];
    const LocalFit* fit = Lookup(less_flat_, bin.R * entry.p_body + bin.t, gate_m, &FitPlaneAround,
                                 &plane_known_, &planes_);
    if (fit == nullptr) continue;
    const double variance = fit->variance_m2 + options.plane_sigma_m * options.plane_sigma_m;
    matches.planes.push_back({{entry.p_body, fit->axis, fit->mean}, 1.0 / variance, entry.bin});
  }
  for (const auto& entry : features.sharp) {
    const SweepMotion::Bin& bin = motion.bins[static_cast<size_t>(entry.bin)];
    const LocalFit* fit = Lookup(less_sharp_, bin.R * entry.p_body + bin.t, gate_m, &FitLineAround,
                                 &line_known_, &lines_);
    if (fit == nullptr) continue;
    const double variance = fit->variance_m2 + options.edge_sigma_m * options.edge_sigma_m;
    matches.lines.push_back({{entry.p_body, fit->axis, fit->mean}, 1.0 / variance, entry.bin});
  }
  return matches;
}

}  // namespace tvl
