#include "tvl/slam/deskew_decision.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr std::array<Deskew, 3> kAnswers = {Deskew::kNone, Deskew::kClockwise,
                                            Deskew::kCounterClockwise};

// Before there are so many keyframes the map is too coarse for its residuals to say anything.
constexpr size_t kMinKeyframes = 4;

// Logarithm of a frame's median squared residual. The logarithm, because frames differ more than
// answers do: a few cluttered places would decide a mean of plain differences. NaN: says nothing.
double LogResidualSq(const DeskewTrial::Contender& contender, double min_rotation_rad) {
  const FrameResult& frame = contender.frames.back();
  const double median_m = frame.map_step.plane_median_m;
  const bool tells = contender.system.map().keyframes.size() >= kMinKeyframes &&
                     frame.map_step.estimate.status != EstimateStatus::kPredicted &&
                     median_m > 0.0 && frame.odometry.T_ref_body.RotationAngle() > min_rotation_rad;
  return tells ? 2.0 * std::log(median_m) : std::nan("");
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

// Times that are all alike say nothing.
bool GivesTimes(const LidarScan& scan) {
  float first_s = std::numeric_limits<float>::infinity(), last_s = -first_s;
  for (const float offset_s : scan.time_offset_s) {
    if (!std::isfinite(offset_s)) continue;
    first_s = std::min(first_s, offset_s);
    last_s = std::max(last_s, offset_s);
  }
  return last_s > first_s;
}

// Mean of other - best over the frames, in standard errors.
double Significance(const std::vector<double>& best, const std::vector<double>& other) {
  double sum = 0.0, sum_sq = 0.0;
  const double n = static_cast<double>(best.size());
  for (size_t i = 0; i < best.size(); ++i) {
    sum += other[i] - best[i];
    sum_sq += (other[i] - best[i]) * (other[i] - best[i]);
  }
  const double mean = sum / n;
  const double variance = std::max(1e-18, sum_sq / n - mean * mean);
  return mean / std::sqrt(variance / n);
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
  TVL_CHECK_INPUT(max_frames >= 2) << "deskew_decision.max_frames: must be at least 2";
  TVL_CHECK_INPUT(min_rotation_rad >= 0.0)
      << "deskew_decision.min_rotation_rad: must not be negative";
  TVL_CHECK_INPUT(min_informative >= 2) << "deskew_decision.min_informative: must be at least 2";
  TVL_CHECK_INPUT(min_significance > 0.0) << "deskew_decision.min_significance: must be positive";
}

DeskewTrial::DeskewTrial(const SensorSetup& setup, const SlamOptions& slam,
                         const DeskewDecisionOptions& options, bool in_background)
    : options_(options), default_answer_(setup.default_deskew) {
  for (const Deskew answer : kAnswers) {
    contenders_.push_back({answer, SlamSystem(setup, answer, slam, in_background), {}});
  }
  log_residuals_sq_.resize(contenders_.size());
}

DeskewTrial::Contender& DeskewTrial::DefaultContender() {
  return *std::find_if(contenders_.begin(), contenders_.end(),
                       [&](const Contender& c) { return c.answer == default_answer_; });
}

void DeskewTrial::UsePointTimes() {
  has_point_times_ = true;
  default_answer_ = Deskew::kClockwise;
  contenders_.erase(contenders_.begin() + 2);
  log_residuals_sq_.resize(contenders_.size());
}

const FrameResult& DeskewTrial::ProcessFrame(const SensorFrame& frame, const Executor& executor) {
  if (!has_seen_scan_ && frame.scan != nullptr && !frame.scan->points.empty()) {
    has_seen_scan_ = true;
    if (GivesTimes(*frame.scan)) UsePointTimes();
  }
  const Executor alone(1);  // one thread a contender
  executor.For(contenders_.size(), 1, [&](size_t begin, size_t) {
    Contender& contender = contenders_[begin];
    contender.frames.push_back(contender.system.ProcessFrame(frame, alone));
  });
  std::vector<double> log_sq;
  for (const Contender& contender : contenders_) {
    log_sq.push_back(LogResidualSq(contender, options_.min_rotation_rad));
  }
  const bool all_tell =
      std::none_of(log_sq.begin(), log_sq.end(), [](double value) { return std::isnan(value); });
  for (size_t i = 0; all_tell && i < log_sq.size(); ++i) log_residuals_sq_[i].push_back(log_sq[i]);
  return DefaultContender().frames.back();
}

std::string DeskewTrial::TextOf(Deskew answer) const {
  return has_point_times_ && answer == Deskew::kClockwise ? "raw, by the times of the points"
                                                          : ToString(answer);
}

bool DeskewTrial::IsOver() const {
  return contenders_[0].frames.size() >= static_cast<size_t>(options_.max_frames) ||
         Judge().verdict == DeskewVerdict::kDecided;
}

DeskewDecision DeskewTrial::Judge() const {
  DeskewDecision decision;
  decision.deskew = default_answer_;
  decision.verdict = DeskewVerdict::kUndecided;
  decision.informative = static_cast<int>(log_residuals_sq_[0].size());
  std::ostringstream reason;
  reason << std::setprecision(3);
  if (decision.informative < options_.min_informative) {
    reason << "only " << decision.informative << " of the first " << contenders_[0].frames.size()
           << " frames turn enough to tell; the default is taken: " << TextOf(default_answer_);
    decision.reason = reason.str();
    return decision;
  }
  std::vector<size_t> order;
  for (size_t i = 0; i < contenders_.size(); ++i) {
    order.push_back(i);
    decision.residual_sq_m2[i] = std::exp(Mean(log_residuals_sq_[i]));
  }
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return decision.residual_sq_m2[a] < decision.residual_sq_m2[b];
  });
  double lead = std::numeric_limits<double>::infinity();
  for (size_t k = 1; k < order.size(); ++k) {
    lead = std::min(lead, Significance(log_residuals_sq_[order[0]], log_residuals_sq_[order[k]]));
  }
  const Deskew best = contenders_[order[0]].answer;
  reason << TextOf(best) << " fits best over " << decision.informative << " turning frames, "
         << lead << " standard errors ahead";
  if (lead >= options_.min_significance) {
    decision.deskew = best;
    decision.verdict = DeskewVerdict::kDecided;
  } else {
    reason << ": too close to decide, the default is taken: " << TextOf(default_answer_);
  }
  decision.reason = reason.str();
  return decision;
}

DeskewTrial::Contender DeskewTrial::Take() {
  default_answer_ = Judge().deskew;
  return std::move(DefaultContender());
}

}  // namespace tvl
