#include "tvl/slam/deskew_decision.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/slam/slam_system.h"

namespace tvl {
namespace {

constexpr std::array<Deskew, 3> kAnswers = {Deskew::kNone, Deskew::kClockwise,
                                            Deskew::kCounterClockwise};

// Residual of every frame under one answer; negative where it says nothing.
std::vector<double> Residuals(const std::vector<SensorFrame>& frames, const SensorSetup& setup,
                              const SlamOptions& slam, Deskew answer,
                              const DeskewDecisionOptions& options, const Executor& executor) {
  SlamSystem system(setup, answer, slam);
  std::vector<double> residuals;
  for (const SensorFrame& frame : frames) {
    const FrameResult result = system.ProcessFrame(frame, executor);
    const Rigid3d& T = result.odometry.T_ref_body;
    const double shift_m = 0.5 * std::max(T.t().norm(), 20.0 * T.RotationAngle());
    const MotionEstimate& estimate = result.map_step.estimate;
    const bool tells = estimate.evidence.planes > 0 && shift_m > options.min_shift_m &&
                       estimate.status != EstimateStatus::kPredicted;
    residuals.push_back(tells ? std::pow(estimate.evidence.plane_rms_m, 2) : -1.0);
  }
  return residuals;
}

struct Comparison {
  double difference = 0.0, significance = 0.0;
};

// Mean of b - a over the frames, in standard errors.
Comparison Compare(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0, sum_sq = 0.0;
  const double n = static_cast<double>(a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    sum += b[i] - a[i];
    sum_sq += (b[i] - a[i]) * (b[i] - a[i]);
  }
  const double mean = sum / n;
  const double variance = std::max(1e-18, sum_sq / n - mean * mean);
  return {mean, mean / std::sqrt(variance / n)};
}

// Of each answer, the frames that tell something under all of them.
std::array<std::vector<double>, 3> Common(const std::array<std::vector<double>, 3>& all) {
  std::array<std::vector<double>, 3> common;
  for (size_t i = 0; i < all[0].size(); ++i) {
    if (all[0][i] < 0.0 || all[1][i] < 0.0 || all[2][i] < 0.0) continue;
    for (size_t a = 0; a < 3; ++a) common[a].push_back(all[a][i]);
  }
  return common;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

}  // namespace

const char* ToString(DeskewVerdict verdict) {
  switch (verdict) {
    case DeskewVerdict::kGiven:
      return "given";
    case DeskewVerdict::kDecided:
      return "decided";
    case DeskewVerdict::kUndecided:
      return "undecided";
  }
  return "unknown";
}

const char* ToString(Deskew deskew) {
  switch (deskew) {
    case Deskew::kNone:
      return "none";
    case Deskew::kClockwise:
      return "cw";
    case Deskew::kCounterClockwise:
      return "ccw";
  }
  return "unknown";
}

void DeskewDecisionOptions::Check() const {
  TVL_CHECK_INPUT(max_frames >= 2) << "deskew.max_frames: must be at least 2";
  TVL_CHECK_INPUT(min_informative >= 2) << "deskew.min_informative: must be at least 2";
  TVL_CHECK_INPUT(min_significance > 0.0) << "deskew.min_significance: must be positive";
}

DeskewDecision DecideDeskew(const std::vector<SensorFrame>& frames, const SensorSetup& setup,
                            const SlamOptions& slam, const DeskewDecisionOptions& options,
                            const Executor& executor) {
  SlamOptions lidar_only = slam;
  lidar_only.use_camera = false;
  std::array<std::vector<double>, 3> residuals;
  for (size_t a = 0; a < 3; ++a) {
    residuals[a] = Residuals(frames, setup, lidar_only, kAnswers[a], options, executor);
  }
  residuals = Common(residuals);
  DeskewDecision decision;
  decision.deskew = setup.default_deskew;
  decision.verdict = DeskewVerdict::kUndecided;
  decision.informative = static_cast<int>(residuals[0].size());
  std::ostringstream reason;
  if (decision.informative < options.min_informative) {
    reason << "only " << decision.informative << " of the first " << frames.size()
           << " frames move enough to tell; the input's default is taken";
    decision.reason = reason.str();
    return decision;
  }
  std::array<size_t, 3> order = {0, 1, 2};
  for (size_t a = 0; a < 3; ++a) decision.residual_sq_m2[a] = Mean(residuals[a]);
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return decision.residual_sq_m2[a] < decision.residual_sq_m2[b];
  });
  const Comparison lead = Compare(residuals[order[0]], residuals[order[1]]);
  reason << ToString(kAnswers[order[0]]) << " fits best over " << decision.informative
         << " frames, " << ToString(kAnswers[order[1]]) << " next, " << lead.significance
         << " standard errors apart";
  if (lead.significance >= options.min_significance) {
    decision.deskew = kAnswers[order[0]];
    decision.verdict = DeskewVerdict::kDecided;
  } else {
    reason << ": too close to decide, the input's default is taken";
  }
  decision.reason = reason.str();
  return decision;
}

}  // namespace tvl
