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

// Everything one verification works on.
struct Scene {
  const LoopSource& source;
  const LoopSubmap& submap;
  Rigid3d T_odom_history;
  std::vector<Eigen::Vector2f> source_above, target_above;  // raised, from above; target: history
  const LoopVerificationOptions& options;
  const Executor& executor;
};

// A start after registration.
struct Candidate {
  Rigid3d T_odom_current;
  LoopFit fit;
};

// What fits less what contradicts.
double FitOf(const Candidate& candidate) {
  return std::max(0.0, candidate.fit.overlap - candidate.fit.seen_through);
}

// Best first.
std::vector<Candidate> RegisterPeaks(const Scene& scene, const std::vector<BevPeak>& peaks) {
  const Rigid3d T_history_odom = scene.T_odom_history.Inverse();
  std::vector<Candidate> candidates;
  for (const BevPeak& peak : peaks) {
    const Rigid3d start =
        scene.T_odom_history * OnTheRoad(peak, T_history_odom, scene.submap.members());
    Candidate candidate;
    candidate.T_odom_current = RegisterCoarsely(scene.source, scene.submap, start,
                                                scene.options.registration, scene.executor);
    candidate.fit = MeasureFit(scene.source, scene.submap, candidate.T_odom_current);
    candidates.push_back(candidate);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return FitOf(a) > FitOf(b); });
  return candidates;
}

// The fit of the best of `others` that is not the same alignment as `best`, relative to best's.
double Ambiguity(const std::vector<Candidate>& others, const Candidate& best,
                 const BevAlignmentOptions& options) {
  if (FitOf(best) <= 0.0) return 1.0;
  for (const Candidate& other : others) {
    const Rigid3d difference = best.T_odom_current.Inverse() * other.T_odom_current;
    const bool is_same = difference.t().norm() < 0.5 * options.peak_distance_m &&
                         difference.RotationAngle() < options.peak_yaw_rad;
    if (!is_same) return FitOf(other) / FitOf(best);
  }
  return 0.0;
}

// Alignments round the one found, shifted but hardly turned, without itself.
std::vector<Candidate> FindRivals(const Scene& scene, const Rigid3d& T_history_current) {
  BevSearch search;
  search.x_m = T_history_current.t().x();
  search.y_m = T_history_current.t().y();
  search.radius_m = scene.options.rival_radius_m;
  search.yaw_rad = YawOf(T_history_current);
  search.yaw_window_rad = scene.options.bev.yaw_step_rad;
  std::vector<BevPeak> peaks =
      AlignBev(scene.target_above, scene.source_above, search, scene.options.bev, scene.executor);
  // From a cell and a half off, registration comes back to it.
  const double itself_m = 1.5 * scene.options.bev.cell_m;
  peaks.erase(std::remove_if(peaks.begin(), peaks.end(),
                             [&](const BevPeak& peak) {
                               return std::hypot(peak.x_m - search.x_m, peak.y_m - search.y_m) <
                                      itself_m;
                             }),
              peaks.end());
  return RegisterPeaks(scene, peaks);
}

LoopStatus Judge(const LoopVerdict& v, int raised, const LoopVerificationOptions& options) {
  if (v.points < options.min_points || 2 * raised < options.min_points) {
    return LoopStatus::kFewPoints;
  }
  if (v.rms_m > options.max_rms_m || v.raised_rms_m > options.max_raised_rms_m) {
    return LoopStatus::kHighRms;
  }
  if (v.overlap < options.min_overlap) return LoopStatus::kLowOverlap;
  if (v.seen_through > options.max_seen_through || v.overlap - v.seen_through < options.min_fit) {
    return LoopStatus::kContradicted;
  }
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
       << " m, overlap " << v.overlap << ", seen through " << v.seen_through << ", ambiguity "
       << v.ambiguity << ", points " << v.points << ", held " << v.translation_ratio << " / "
       << v.rotation_ratio;
  return text.str();
}

Scene MakeScene(const LoopSource& source, const LoopSubmap& submap, const Rigid3d& T_odom_history,
                const BevSearch& search, const LoopVerificationOptions& options,
                const Executor& executor) {
  Scene scene{source, submap, T_odom_history, {}, {}, options, executor};
  const double reach_m = options.bev.range_m + std::hypot(search.x_m, search.y_m) +
                         std::max(search.radius_m, options.rival_radius_m);
  scene.target_above =
      RaisedFromAbove(submap, T_odom_history.Inverse(), reach_m, options.source.raised_m);
  for (const Eigen::Vector3f& p : source.raised) scene.source_above.emplace_back(p.x(), p.y());
  return scene;
}

// Registers the best start finely and judges it.
LoopVerdict Decide(const Scene& scene, double coarse_score, const std::vector<Candidate>& starts) {
  const LoopRegistration fine = RegisterFinely(scene.source, scene.submap, starts[0].T_odom_current,
                                               scene.options.registration, scene.executor);
  const LoopEvidence evidence =
      MeasureEvidence(scene.source, scene.submap, fine.T_odom_current, scene.options.evidence);
  const Candidate best{fine.T_odom_current, evidence.fit};
  LoopVerdict verdict;
  verdict.T_history_current = scene.T_odom_history.Inverse() * fine.T_odom_current;
  verdict.covariance = fine.covariance;
  verdict.rms_m = evidence.rms_m;
  verdict.raised_rms_m = evidence.raised_rms_m;
  verdict.overlap = best.fit.overlap;
  verdict.seen_through = best.fit.seen_through;
  verdict.ambiguity = Ambiguity(starts, best, scene.options.bev);
  verdict.coarse_score = coarse_score;
  verdict.translation_ratio = fine.translation_ratio;
  verdict.rotation_ratio = fine.rotation_ratio;
  verdict.points = evidence.planes;
  verdict.status = Judge(verdict, best.fit.raised, scene.options);
  if (verdict.accepted()) {
    const std::vector<Candidate> rivals = FindRivals(scene, verdict.T_history_current);
    verdict.ambiguity = std::max(verdict.ambiguity, Ambiguity(rivals, best, scene.options.bev));
    verdict.status = Judge(verdict, best.fit.raised, scene.options);
  }
  verdict.reason = ReasonOf(verdict);
  return verdict;
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
  TVL_CHECK_INPUT(rival_radius_m > 0.0) << "loop_verification.rival_radius_m: must be positive";
  TVL_CHECK_INPUT(max_rms_m > 0.0 && max_raised_rms_m > 0.0)
      << "loop_verification.max_rms_m, max_raised_rms_m: must be positive";
  TVL_CHECK_INPUT(min_overlap >= 0.0 && min_overlap <= 1.0)
      << "loop_verification.min_overlap: must be in 0..1";
  TVL_CHECK_INPUT(max_seen_through >= 0.0 && max_seen_through <= 1.0)
      << "loop_verification.max_seen_through: must be in 0..1";
  TVL_CHECK_INPUT(min_fit >= 0.0 && min_fit <= 1.0) << "loop_verification.min_fit: must be in 0..1";
  TVL_CHECK_INPUT(max_ambiguity > 0.0 && max_ambiguity <= 1.0)
      << "loop_verification.max_ambiguity: must be in 0..1";
  TVL_CHECK_INPUT(min_points >= 1) << "loop_verification.min_points: must be at least 1";
}

LoopVerifier::LoopVerifier(const LoopVerificationOptions& options)
    : options_(options), submap_(options.submap) {
  options_.Check();
}

void LoopVerifier::MoveTo(const LoopProposal& proposal, const VerificationInput& input,
                          const Executor& executor) {
  if (proposal.current != source_of_) {
    source_ = AssembleSource(proposal.current, input.T_odom_lidar, input.cloud, options_.source);
    source_of_ = proposal.current;
  }
  // The submap must not hold what is laid over it.
  const int end = std::max(proposal.history + 1, proposal.current - options_.source.keyframes_back);
  submap_.MoveTo(proposal.history, end, input.T_odom_lidar, input.cloud, executor);
}

LoopVerdict LoopVerifier::Verify(const LoopProposal& proposal, const VerificationInput& input,
                                 const Executor& executor) {
  TVL_CHECK(proposal.history >= 0 && proposal.history < proposal.current &&
            proposal.current < static_cast<int>(input.T_odom_lidar.size()))
      << "loop of keyframes " << proposal.history << ", " << proposal.current;
  MoveTo(proposal, input, executor);
  const Rigid3d& T_odom_history = input.T_odom_lidar[static_cast<size_t>(proposal.history)];
  const BevSearch search = SearchOf(proposal, input, options_);
  const Scene scene = MakeScene(source_, submap_, T_odom_history, search, options_, executor);
  const std::vector<BevPeak> peaks =
      AlignBev(scene.target_above, scene.source_above, search, options_.bev, executor);
  if (peaks.empty()) {
    LoopVerdict verdict;
    verdict.reason = ReasonOf(verdict);
    return verdict;
  }
  const std::vector<Candidate> starts = RegisterPeaks(scene, peaks);
  return Decide(scene, peaks[0].score, starts);
}

}  // namespace tvl
