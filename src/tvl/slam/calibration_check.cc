#include "tvl/slam/calibration_check.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace tvl {
namespace {

// Way and time between two views: near things have moved by 5 deg and are still seen.
constexpr double kWay_m = 1.0;
constexpr int kMaxFrames = 20;

// A track tells the direction of motion if it has moved by more than this; one that fits leaves its
// epipolar plane by less than the noise and a share of its motion (an error of 9 deg). Which way it
// has moved within the plane is not asked: so traffic along the road fits, too.
constexpr double kMinParallax_rad = 0.015;
constexpr double kNoise_rad = 0.003;
constexpr double kFittingSlope = 0.15;
constexpr int kMinTracks = 15;

// Right calibrations fit nine tracks of ten. By chance, or where all tracks are on traffic, one
// stretch may not; not so many in a row.
constexpr double kContradictingShare = 0.4;
constexpr int kMinStretches = 5;
constexpr double kExplainingShare = 0.7;  // for another calibration to be named

// The principal point of a camera is near the middle of its images, whose sky may be cut off.
constexpr double kMaxOffCentre = 0.25;  // of the width or height

Calibration Resized(Calibration calibration, double factor) {
  calibration.camera.fx_px *= factor;
  calibration.camera.fy_px *= factor;
  calibration.camera.cx_px *= factor;
  calibration.camera.cy_px *= factor;
  return calibration;
}

Calibration Inverted(Calibration calibration) {
  calibration.T_cam_lidar = calibration.T_cam_lidar.Inverse();
  return calibration;
}

}  // namespace

CalibrationCheck::CalibrationCheck(const Calibration& given) {
  candidates_.push_back({given, ""});
  candidates_.push_back({Inverted(given), "Tr is the inverse of what it should be"});
  candidates_.push_back({Resized(given, 0.5), "the images are half the size P is made for"});
  candidates_.push_back({Resized(given, 2.0), "the images are twice the size P is made for"});
}

std::string CalibrationCheck::CheckImage(int width_px, int height_px) {
  if (has_seen_image_) return "";
  has_seen_image_ = true;
  const Camera& camera = candidates_.front().calibration.camera;
  const double across = camera.cx_px / width_px - 0.5, down = camera.cy_px / height_px - 0.5;
  if (std::max(std::abs(across), std::abs(down)) < kMaxOffCentre) return "";
  std::ostringstream out;
  out << "the camera's principal point (" << camera.cx_px << ", " << camera.cy_px
      << ") px is far from the middle of its images of " << width_px << "x" << height_px
      << " px: were they resized after the calibration?";
  return out.str();
}

double CalibrationCheck::FittingShare(const View& from, const View& to,
                                      const Calibration& calibration) {
  const Rigid3d T_from_to = calibration.T_cam_lidar * from.T_odom_lidar.Inverse() *
                            to.T_odom_lidar * calibration.T_cam_lidar.Inverse();
  const Eigen::Vector3d forward = T_from_to.t().normalized();
  int telling = 0, fitting = 0;
  auto seen = from.tracks.begin();
  for (const FeatureTrack& track : to.tracks) {
    while (seen != from.tracks.end() && seen->id < track.id) ++seen;
    if (seen == from.tracks.end()) break;
    if (seen->id != track.id) continue;
    const auto ray = [&](const FeatureTrack& t) -> Eigen::Vector3d {
      return calibration.camera.Unproject(t.px_cam).homogeneous().normalized();
    };
    const Eigen::Vector3d now = T_from_to.q() * ray(track), before = ray(*seen);
    const double parallax = now.cross(before).norm();
    const Eigen::Vector3d normal = forward.cross(now);
    if (parallax < kMinParallax_rad || normal.norm() < 1e-3) continue;
    const double off_plane = std::abs(normal.normalized().dot(before));
    ++telling;
    fitting += off_plane < kNoise_rad + kFittingSlope * parallax;
  }
  return telling < kMinTracks ? -1.0 : static_cast<double>(fitting) / telling;
}

std::string CalibrationCheck::Add(const FeatureTracks& tracks, const Rigid3d& T_odom_lidar) {
  if (has_contradiction_) return "";
  const View view{tracks.tracks, T_odom_lidar};
  const double way_m = (reference_.T_odom_lidar.t() - T_odom_lidar.t()).norm();
  if (reference_.tracks.empty() || ++frames_ > kMaxFrames) {
    reference_ = view;
    frames_ = 0;
    return "";
  }
  if (way_m < kWay_m) return "";
  const View from = std::exchange(reference_, view);
  frames_ = 0;
  const double share = FittingShare(from, view, candidates_.front().calibration);
  if (share < 0.0) return "";
  if (share >= kContradictingShare) {
    contradicting_ = 0;
    for (Candidate& candidate : candidates_) candidate.share_sum = 0.0;
    return "";
  }
  ++contradicting_;
  for (Candidate& candidate : candidates_) {
    candidate.share_sum += std::max(0.0, FittingShare(from, view, candidate.calibration));
  }
  has_contradiction_ = contradicting_ >= kMinStretches;
  return has_contradiction_ ? Contradiction() : "";
}

std::string CalibrationCheck::Contradiction() const {
  const auto best = std::max_element(
      candidates_.begin(), candidates_.end(),
      [](const Candidate& a, const Candidate& b) { return a.share_sum < b.share_sum; });
  std::ostringstream out;
  out << "the camera's tracks contradict the lidar's motion ("
      << std::lround(100.0 * candidates_.front().share_sum / contradicting_)
      << " % fit): calib.txt may be inverted or the images resized";
  if (!best->mistake.empty() && best->share_sum > kExplainingShare * contradicting_) {
    out << "; " << std::lround(100.0 * best->share_sum / contradicting_) << " % fit if "
        << best->mistake;
  }
  out << ". The camera is left out from here on";
  return out.str();
}

}  // namespace tvl
