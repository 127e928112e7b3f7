#include "tvl/slam/health.h"

#include <algorithm>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// A tenth of the tracks: far more than chance takes from one of two equal hypotheses.
constexpr double kClearlyLess = 0.1;

// How many points lie on the map.
double Explained(const KnownFit& fit) { return fit.judged * (1.0 - fit.mean); }

}  // namespace

void HealthOptions::Check() const {
  TVL_CHECK_INPUT(window_frames >= 1) << "health.window_frames: must be at least 1";
  TVL_CHECK_INPUT(first_usual_misfit >= 0.0 && first_usual_misfit <= 1.0)
      << "health.first_usual_misfit: must lie in 0..1";
  TVL_CHECK_INPUT(suspicious_rise > 0.0 && lost_rise >= suspicious_rise)
      << "health.suspicious_rise, lost_rise: want 0 < suspicious <= lost";
  TVL_CHECK_INPUT(suspicious_innovation_m > 0.0 && suspicious_innovation_rad > 0.0)
      << "health.suspicious_innovation_m, suspicious_innovation_rad: must be positive";
  TVL_CHECK_INPUT(min_judged >= 1) << "health.min_judged: must be at least 1";
  TVL_CHECK_INPUT(min_better_sigmas >= 0.0) << "health.min_better_sigmas: must not be negative";
}

HealthMonitor::HealthMonitor(const HealthOptions& options) : options_(options) { options_.Check(); }

double HealthMonitor::usual_misfit() const {
  std::vector<double> misfits(misfits_.begin(), misfits_.end());
  for (int i = 0; i < 3; ++i) misfits.push_back(options_.first_usual_misfit);
  const auto middle = misfits.begin() + static_cast<std::ptrdiff_t>(misfits.size() / 2);
  std::nth_element(misfits.begin(), middle, misfits.end());
  return *middle;
}

Health HealthMonitor::Judge(const TrackedPose& tracked, const Rigid3d& T_odom_expected,
                            bool was_lost) const {
  if (!tracked.is_measured) return Health::kBad;
  const Rigid3d innovation = T_odom_expected.Inverse() * tracked.T_odom_lidar;
  const bool is_leap = innovation.t().norm() > options_.suspicious_innovation_m ||
                       innovation.RotationAngle() > options_.suspicious_innovation_rad;
  // Where nothing about the vehicle can be judged, a leap has nothing to show for itself.
  if (tracked.fit.judged < options_.min_judged) return is_leap ? Health::kBad : Health::kGood;
  const double rise = tracked.fit.mean - usual_misfit();
  if (rise > options_.lost_rise) {
    const bool goes_on = !is_leap && !was_lost && IsConfirmed(tracked);
    return goes_on ? Health::kSuspicious : Health::kBad;
  }
  if (rise > options_.suspicious_rise) {
    return is_leap || was_lost ? Health::kBad : Health::kSuspicious;
  }
  return is_leap ? Health::kSuspicious : Health::kGood;
}

bool HealthMonitor::IsConfirmed(const TrackedPose& tracked) const {
  return LiesOnWhatIsKnown(tracked) || CameraAgrees(tracked);
}

// Landmarks, and the points seen in the image before, were placed in the world then: they confirm a
// pose without the scan.
bool HealthMonitor::CameraAgrees(const TrackedPose& tracked) const {
  constexpr double kMostOfThem = 0.6;
  return CameraShare(tracked) >= kMostOfThem;
}

double HealthMonitor::CameraShare(const TrackedPose& tracked) const {
  constexpr int kEnough = 30;  // by chance not two of a hundred agree
  double share = 0.0;
  for (const EstimateEvidence& evidence :
       {tracked.map_step.estimate.evidence, tracked.odometry.evidence}) {
    if (evidence.visual < kEnough) continue;
    share = std::max(share, static_cast<double>(evidence.visual) / evidence.visual_offered);
  }
  return share;
}

bool HealthMonitor::LiesOnWhatIsKnown(const TrackedPose& tracked) const {
  // Of the judged points: all else may be traffic. Of a wrong pose, too, some things lie on the
  // map.
  constexpr double kEnoughShare = 0.15;
  const KnownFit& known = tracked.known_fit;
  return known.judged >= std::max<double>(options_.min_judged, kEnoughShare * tracked.fit.judged) &&
         known.mean - usual_misfit() < options_.suspicious_rise;
}

bool HealthMonitor::IsBetter(const TrackedPose& challenger, const TrackedPose& champion,
                             double sigmas) const {
  if (!challenger.is_measured) return false;
  if (!champion.is_measured) return true;
  // Where traffic hides most of what is known, or the known ends, any pose fits the rest better by
  // chance: what the known things, or the landmarks, bear out is not given up for it.
  const bool explains_less = Explained(challenger.known_fit) < Explained(champion.known_fit);
  if (LiesOnWhatIsKnown(champion) && !LiesOnWhatIsKnown(challenger) && explains_less) return false;
  if (CameraAgrees(champion) && CameraShare(challenger) < CameraShare(champion) - kClearlyLess) {
    return false;
  }
  const FitComparison comparison = Compare(challenger.fit, champion.fit);
  return comparison.common >= options_.min_judged &&
         comparison.better > sigmas * comparison.standard_error;
}

void HealthMonitor::Learn(const TrackedPose& tracked) {
  if (tracked.fit.judged < options_.min_judged) return;
  const bool has_new_clusters = tracked.fit.mean - usual_misfit() > options_.lost_rise;
  misfits_.push_back(has_new_clusters ? tracked.known_fit.mean : tracked.fit.mean);
  if (misfits_.size() > static_cast<size_t>(options_.window_frames)) misfits_.pop_front();
}

}  // namespace tvl
