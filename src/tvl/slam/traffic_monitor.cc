#include "tvl/slam/traffic_monitor.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// At a stand traffic and road agree whatever the traffic does next; noise of the steps is less.
constexpr double kMoving_m = 0.03;
constexpr double kSigmas = 3.0;

// Clusters most of whose points lie in the corridor. What has no flat points is a post or a trunk,
// and no vehicle.
std::set<int32_t> ClustersWithin(const LaserFeatures& features, double corridor_m) {
  struct Count {
    int points = 0, inside = 0;
  };
  std::map<int32_t, Count> clusters;
  for (const LaserFeature& feature : features.less_flat) {
    if (feature.label == kLabelGround) continue;
    Count& count = clusters[feature.label];
    ++count.points;
    count.inside += std::abs(static_cast<double>(feature.p_lidar.y())) < corridor_m;
  }
  std::set<int32_t> labels;
  for (const auto& [label, count] : clusters) {
    if (2 * count.inside >= count.points) labels.insert(label);
  }
  return labels;
}

void RemoveLabels(const std::set<int32_t>& labels, std::vector<LaserFeature>* features) {
  features->erase(std::remove_if(features->begin(), features->end(),
                                 [&](const LaserFeature& f) { return labels.count(f.label) > 0; }),
                  features->end());
}

}  // namespace

void TrafficOptions::Check() const {
  TVL_CHECK_INPUT(window_frames >= 1) << "traffic.window_frames: must be at least 1";
  TVL_CHECK_INPUT(min_slip_m > 0.0) << "traffic.min_slip_m: must be positive";
  TVL_CHECK_INPUT(slip_share >= 0.0) << "traffic.slip_share: must not be negative";
  TVL_CHECK_INPUT(min_slipping_frames >= 1 && min_slipping_frames <= window_frames)
      << "traffic.min_slipping_frames: want 1 to traffic.window_frames";
  TVL_CHECK_INPUT(max_speed_m_s > 0.0) << "traffic.max_speed_m_s: must be positive";
  TVL_CHECK_INPUT(max_frames_without_road >= 1)
      << "traffic.max_frames_without_road: must be at least 1";
  TVL_CHECK_INPUT(min_moving_misfit > 0.0 && min_moving_misfit < 1.0)
      << "traffic.min_moving_misfit: must lie between 0 and 1";
  TVL_CHECK_INPUT(max_surroundings_sigma_m > 0.0)
      << "traffic.max_surroundings_sigma_m: must be positive";
  TVL_CHECK_INPUT(corridor_m > 0.0) << "traffic.corridor_m: must be positive";
  TVL_CHECK_INPUT(min_start_share > 0.0 && min_start_share <= 1.0)
      << "traffic.min_start_share: must lie in 0..1, and not be 0";
  TVL_CHECK_INPUT(release_m > 0.0) << "traffic.release_m: must be positive";
}

StandingMotion StandingMotion::Of(const RoadMotion& road) {
  constexpr double kNearlyAll = 0.7, kHardlyAny = 0.2;
  const auto agreeing = static_cast<double>(road.agreeing.size());
  const bool is_unanimous =
      agreeing >= kNearlyAll * road.tracks && road.agreeing_with_guess <= kHardlyAny * agreeing;
  return {road.T_prev_cur, road.covariance_m2, is_unanimous};
}

TrafficMonitor::TrafficMonitor(const TrafficOptions& options) : options_(options) {
  options_.Check();
}

void TrafficMonitor::Forget() {
  window_.clear();
  carries_ = false;
  agreeing_m_ = 0.0;
  frames_without_road_ = 0;
}

Eigen::Vector2d TrafficMonitor::Slip_m() const {
  Eigen::Vector2d sum_m = Eigen::Vector2d::Zero();
  for (const Slip& frame : window_) sum_m += frame.slip_m;
  return sum_m;
}

bool TrafficMonitor::IsSlipping() const {
  const Eigen::Vector2d slip_m = Slip_m();
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();
  double path_m = 0.0;
  int slipping = 0;
  for (const Slip& frame : window_) {
    covariance_m2 += frame.covariance_m2;
    path_m += frame.step_m;
    // A quarter of what each frame would have to contribute.
    slipping += frame.slip_m.dot(slip_m) > 0.25 * slip_m.squaredNorm() / options_.window_frames;
  }
  if (slipping < options_.min_slipping_frames) return false;
  return IsSignificant({slip_m, covariance_m2, path_m});
}

bool TrafficMonitor::IsSignificant(const Slip& slip) const {
  const double length_m = slip.slip_m.norm();
  if (length_m <= 0.0) return false;
  const double sigma_m = std::sqrt(slip.slip_m.dot(slip.covariance_m2 * slip.slip_m)) / length_m;
  return length_m > options_.min_slip_m + options_.slip_share * slip.step_m + kSigmas * sigma_m;
}

bool TrafficMonitor::Contradicts(const StandingMotion& standing, const Rigid3d& T_prev_cur) const {
  const Eigen::Vector2d slip_m = (standing.T_prev_cur.t() - T_prev_cur.t()).head<2>();
  return standing.decides_alone &&
         IsSignificant({slip_m, standing.covariance_m2, standing.T_prev_cur.t().head<2>().norm()});
}

bool TrafficMonitor::HasMajority(const RoadMotion& road) const {
  const auto agreeing = static_cast<double>(road.agreeing.size());
  return agreeing >= options_.min_start_share * road.tracks &&
         agreeing >= 2.0 * road.agreeing_with_guess;
}

bool TrafficMonitor::Start(const Rigid3d& T_prev_cur, const RoadMotion& road, double duration_s) {
  Forget();
  const double step_m = road.T_prev_cur.t().head<2>().norm();
  const double slip_m = (road.T_prev_cur.t() - T_prev_cur.t()).head<2>().norm();
  carries_ = HasMajority(road) && step_m < options_.max_speed_m_s * duration_s &&
             slip_m > options_.min_slip_m + options_.slip_share * step_m;
  return carries_;
}

Eigen::Vector2d TrafficMonitor::Update(const Rigid3d& T_prev_cur,
                                       const std::optional<StandingMotion>& standing,
                                       double duration_s) {
  const Rigid3d& motion = standing ? standing->T_prev_cur : T_prev_cur;
  const double step_m = motion.t().head<2>().norm();
  frames_without_road_ = standing ? 0 : frames_without_road_ + 1;
  if (!MayBeAmongTraffic(motion, duration_s) ||
      frames_without_road_ > options_.max_frames_without_road) {
    Forget();
    return Eigen::Vector2d::Zero();
  }
  if (!standing) {
    Interrupt();
    return Eigen::Vector2d::Zero();
  }
  const Eigen::Vector2d slip_m = (standing->T_prev_cur.t() - T_prev_cur.t()).head<2>();
  window_.push_back({slip_m, standing->covariance_m2, step_m});
  if (window_.size() > static_cast<size_t>(options_.window_frames)) window_.pop_front();
  const bool is_slipping = IsSlipping();
  if (!carries_) {
    const bool is_contradicted = Contradicts(*standing, T_prev_cur);
    if (is_contradicted) window_.erase(window_.begin(), window_.end() - 1);  // this frame alone
    carries_ = is_slipping || is_contradicted;
    agreeing_m_ = 0.0;
    return carries_ ? Slip_m() : Eigen::Vector2d::Zero();
  }
  if (is_slipping) agreeing_m_ = 0.0;
  if (!is_slipping && step_m > kMoving_m) agreeing_m_ += step_m;
  if (agreeing_m_ > options_.release_m) Forget();
  return Eigen::Vector2d::Zero();
}

bool TrafficMonitor::IsAmongMovingThings(const LaserFeatures& features, const MapFit& fit,
                                         const Rigid3d& T_prev_cur, double duration_s) const {
  constexpr double kEnough = 50.0;  // points that can be judged
  if (!MayBeAmongTraffic(T_prev_cur, duration_s)) return false;
  const std::set<int32_t> labels = ClustersWithin(features, options_.corridor_m);
  double judged = 0.0, cost = 0.0;
  for (size_t i = 0; i < fit.label.size(); ++i) {
    if (labels.count(fit.label[i]) == 0) continue;
    const auto weight = static_cast<double>(fit.weight[i]);
    judged += weight;
    cost += weight * static_cast<double>(fit.cost[i]);
  }
  return judged > kEnough && cost > options_.min_moving_misfit * judged;
}

std::optional<StandingMotion> TrafficMonitor::Surroundings(const Rigid3d& found,
                                                           const Matrix6d& covariance,
                                                           const MotionPrediction& expected) const {
  const Eigen::Matrix2d information = covariance.block<2, 2>(3, 3).inverse();
  const Eigen::Matrix2d measured = information - expected.covariance.block<2, 2>(3, 3).inverse();
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(measured).eigenvalues()[0];
  const double max_sigma_m = options_.max_surroundings_sigma_m;
  if (!(least * max_sigma_m * max_sigma_m >= 1.0)) return std::nullopt;
  const Eigen::Vector2d expected_m = expected.T_prev_cur.t().head<2>();
  const Eigen::Vector2d innovation_m = found.t().head<2>() - expected_m;
  StandingMotion standing{found, measured.inverse(), true};
  Eigen::Vector3d t = found.t();
  t.head<2>() = expected_m + standing.covariance_m2 * information * innovation_m;
  standing.T_prev_cur = Rigid3d(found.q(), t);
  return standing;
}

int TrafficMonitor::RemoveTraffic(const std::optional<RoadMotion>& road,
                                  PreprocessedFrame* frame) const {
  const std::set<int32_t> labels = ClustersWithin(frame->features, options_.corridor_m);
  LaserFeatures& features = frame->features;
  for (auto* of : {&features.sharp, &features.flat, &features.less_sharp, &features.less_flat}) {
    RemoveLabels(labels, of);
  }
  std::vector<bool> agrees(frame->depths.size(), false);
  if (road) {
    for (const size_t i : road->agreeing) agrees[i] = true;
  }
  size_t kept = 0;
  for (size_t i = 0; i < frame->depths.size(); ++i) {
    const bool is_new =
        frame->depths[i].label == kLabelGround && frame->tracks.tracks[i].length == 1;
    if (!agrees[i] && !is_new) continue;
    frame->tracks.tracks[kept] = frame->tracks.tracks[i];
    frame->depths[kept] = frame->depths[i];
    ++kept;
  }
  const int removed = static_cast<int>(frame->depths.size() - kept);
  frame->tracks.tracks.resize(kept);
  frame->depths.resize(kept);
  return removed;
}

}  // namespace tvl
