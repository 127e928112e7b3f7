#include "tvl/loop/loop_verification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "tvl/base/check.h"

namespace tvl {
namespace {

double YawOf(const Rigid3d& T) {
  const Eigen::Vector3d x = T.q() * Eigen::Vector3d::UnitX();
  return std::atan2(x.y(), x.x());
}

BevSearch SearchOf(const LoopProposal& proposal, const VerificationInput& input,
                   const LoopVerificationOptions& options) {
  const bool has_guess = proposal.guess != LoopGuess::kNone;
  const Rigid3d& T = has_guess ? proposal.T_history_current : input.T_history_current;
  BevSearch search;
  search.x_m = T.t().x();
  search.y_m = T.t().y();
  search.yaw_rad = YawOf(T);
  switch (proposal.guess) {
    case LoopGuess::kNone:
      search.radius_m = input.radius_m;
      search.yaw_window_rad = options.graph_yaw_rad;
      break;
    case LoopGuess::kYaw:
      search.radius_m = options.yaw_radius_m;
      search.yaw_window_rad = options.yaw_yaw_rad;
      break;
    case LoopGuess::kPose:
      search.radius_m = options.pose_radius_m;
      search.yaw_window_rad = options.pose_yaw_rad;
      break;
  }
  return search;
}

// The car stood on the same road: height and tilt are those of the history keyframe nearest by.
Rigid3d OnTheRoad(const BevPeak& peak, const Rigid3d& T_history_odom,
                  const std::map<int, Rigid3d>& members) {
  Rigid3d nearest;
  double nearest_sq = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d place(peak.x_m, peak.y_m);
  for (const auto& member : members) {
    const Rigid3d T = T_history_odom * member.second;
    const double distance_sq = (T.t().head<2>() - place).squaredNorm();
    if (distance_sq >= nearest_sq) continue;
    nearest_sq = distance_sq;
    nearest = T;
  }
  const Eigen::Vector3d up = nearest.q() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector2d off = place - nearest.t().head<2>();
  const double z = nearest.t().z() - up.head<2>().dot(off) / up.z();
  const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up);
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(peak.yaw_rad, Eigen::Vector3d::UnitZ()));
  return {tilt * yaw, Eigen::Vector3d(peak.x_m, peak.y_m, z)};
}

std::vector<Eigen::Vector2f> RaisedFromAbove(const LoopSubmap& submap,
                                             const Rigid3d& T_history_odom, double reach_m,
                                             double raised_m) {
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector3d& centre : submap.OccupiedCentres()) {
    const Eigen::Vector3d p = T_history_odom * centre;
    if (p.head<2>().norm() < reach_m) points.push_back(p.cast<float>());
  }
  const std::vector<char> is_raised = AboveGround(points, raised_m);
  std::vector<Eigen::Vector2f> raised;
  for (size_t i = 0; i < points.size(); ++i) {
    if (is_raised[i] != 0) raised.push_back(points[i].head<2>());
  }
  return raised;
}

// A start after coarse registration.
struct Candidate {
  Rigid3d T_odom_current;
  LoopEvidence evidence;
  double fit = 0.0;  // larger is better
};

double Fit(const LoopEvidence& evidence) { return evidence.overlap; }

bool AreOne(const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d difference = a.Inverse() * b;
  return difference.t().norm() < 1.0 && difference.RotationAngle() < 0.1;
}

// Second best of those that did not run to the same place, relative to the best (first).
double Ambiguity(const std::vector<Candidate>& candidates) {
  double second = 0.0;
  for (const Candidate& candidate : candidates) {
    if (AreOne(candidate.T_odom_current, candidates[0].T_odom_current)) continue;
    second = std::max(second, candidate.fit);
  }
  return candidates[0].fit <= 0.0 ? 1.0 : second / candidates[0].fit;
}

LoopStatus Judge(const LoopVerdict& v, const LoopEvidence& evidence,
                 const LoopVerificationOptions& options) {
  if (evidence.planes < options.min_points || 2 * evidence.raised < options.min_points) {
    return LoopStatus::kFewPoints;
  }
  if (v.rms_m > options.max_rms_m || v.raised_rms_m > options.max_raised_rms_m) {
    return LoopStatus::kHighRms;
  }
  if (v.overlap < options.min_overlap) return LoopStatus::kLowOverlap;
  if (v.translation_ratio < options.min_translation_ratio ||
      v.rotation_ratio < options.min_rotation_ratio) {
    return LoopStatus::kWeak;
  }
  if (v.ambiguity > options.max_ambiguity) return LoopStatus::kAmbiguous;
  return LoopStatus::kAccepted;
}

std::string ReasonOf(const LoopVerdict& v) {
  if (v.accepted()) return "";
  std::ostringstream text;
  text.precision(3);
  text << ToString(v.status) << ": rms " << v.rms_m << " m, raised " << v.raised_rms_m
       << " m, overlap " << v.overlap << ", ambiguity " << v.ambiguity << ", points " << v.points
       << ", held " << v.translation_ratio << " / " << v.rotation_ratio;
  return text.str();
}

}  // namespace

void LoopVerificationOptions::Check() const {
  submap.Check();
  source.Check();
  bev.Check();
  registration.Check();
  evidence.Check();
  TVL_CHECK_INPUT(pose_radius_m > 0.0 && yaw_radius_m > 0.0)
      << "loop_verification.*_radius_m: must be positive";
  TVL_CHECK_INPUT(pose_yaw_rad >= 0.0 && yaw_yaw_rad >= 0.0 && graph_yaw_rad >= 0.0)
      << "loop_verification.*_yaw_rad: must not be negative";
  TVL_CHECK_INPUT(max_rms_m > 0.0 && max_raised_rms_m > 0.0)
      << "loop_verification.max_rms_m, max_raised_rms_m: must be positive";
  TVL_CHECK_INPUT(min_overlap >= 0.0 && min_overlap <= 1.0)
      << "loop_verification.min_overlap: must be in 0..1";
  TVL_CHECK_INPUT(min_points >= 1) << "loop_verification.min_points: must be at least 1";
}

LoopVerifier::LoopVerifier(const LoopVerificationOptions& options)
    : options_(options), submap_(options.submap) {
  options_.Check();
}

const LoopSource& LoopVerifier::SourceOf(int current, const VerificationInput& input) {
  if (current != source_of_) {
    source_ = AssembleSource(current, input.T_odom_lidar, input.cloud, options_.source);
    source_of_ = current;
  }
  return source_;
}

std::vector<BevPeak> LoopVerifier::FindStarts(const LoopProposal& proposal,
                                              const VerificationInput& input,
                                              const Executor& executor) const {
  const BevSearch search = SearchOf(proposal, input, options_);
  const Rigid3d T_history_odom =
      input.T_odom_lidar[static_cast<size_t>(proposal.history)].Inverse();
  const double reach_m = options_.bev.range_m + search.radius_m;
  const std::vector<Eigen::Vector2f> target =
      RaisedFromAbove(submap_, T_history_odom, 1.5 * reach_m, options_.source.raised_m);
  std::vector<Eigen::Vector2f> source;
  for (const Eigen::Vector3f& p : source_.raised) source.emplace_back(p.x(), p.y());
  return AlignBev(target, source, search, options_.bev, executor);
}

LoopVerdict LoopVerifier::Verify(const LoopProposal& proposal, const VerificationInput& input,
                                 const Executor& executor) {
  TVL_CHECK(proposal.history >= 0 && proposal.history < proposal.current &&
            proposal.current < static_cast<int>(input.T_odom_lidar.size()))
      << "loop of keyframes " << proposal.history << ", " << proposal.current;
  const LoopSource& source = SourceOf(proposal.current, input);
  const int end = std::max(proposal.history + 1, proposal.current - options_.source.keyframes_back);
  submap_.MoveTo(proposal.history, end, input.T_odom_lidar, input.cloud, executor);
  const Rigid3d& T_odom_history = input.T_odom_lidar[static_cast<size_t>(proposal.history)];

  LoopVerdict verdict;
  std::vector<Candidate> candidates;
  for (const BevPeak& peak : FindStarts(proposal, input, executor)) {
    verdict.coarse_score = std::max(verdict.coarse_score, peak.score);
    const Rigid3d start =
        T_odom_history * OnTheRoad(peak, T_odom_history.Inverse(), submap_.members());
    Candidate candidate;
    candidate.T_odom_current =
        RegisterCoarsely(source, submap_, start, options_.registration, executor);
    candidate.evidence =
        MeasureEvidence(source, submap_, candidate.T_odom_current, options_.evidence);
    candidate.fit = Fit(candidate.evidence);
    candidates.push_back(candidate);
  }
  if (candidates.empty()) {
    verdict.reason = ReasonOf(verdict);
    return verdict;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.fit > b.fit; });
  const LoopRegistration fine = RegisterFinely(source, submap_, candidates[0].T_odom_current,
                                               options_.registration, executor);
  const LoopEvidence evidence =
      MeasureEvidence(source, submap_, fine.T_odom_current, options_.evidence);
  verdict.T_history_current = T_odom_history.Inverse() * fine.T_odom_current;
  verdict.covariance = fine.covariance;
  verdict.rms_m = evidence.rms_m;
  verdict.raised_rms_m = evidence.raised_rms_m;
  verdict.overlap = evidence.overlap;
  verdict.ambiguity = Ambiguity(candidates);
  verdict.translation_ratio = fine.translation_ratio;
  verdict.rotation_ratio = fine.rotation_ratio;
  verdict.points = evidence.planes;
  verdict.status = Judge(verdict, evidence, options_);
  verdict.reason = ReasonOf(verdict);
  return verdict;
}

}  // namespace tvl
