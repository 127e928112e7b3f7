#include "tvl/vision/ground_warp.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr size_t kMinPoints = 10;
// Kerbs and potholes stay below this; what rises further is not the road.
constexpr double kMaxMedian_m = 0.1;
constexpr int kIterations = 5;

std::vector<Eigen::Vector3d> GroundPoints(const FeatureTracks& tracks, const VisualDepths& depths) {
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].status != DepthStatus::kOk || depths[i].label != kLabelGround) continue;
    points.push_back(depths[i].depth_m * tracks.tracks[i].ray_cam.homogeneous());
  }
  return points;
}

double Distance_m(const Eigen::Vector3d& inverse_m, const Eigen::Vector3d& p) {
  return std::abs(inverse_m.dot(p) - 1.0) / inverse_m.norm();
}

double MedianDistance_m(const Eigen::Vector3d& inverse_m,
                        const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> distances;
  for (const Eigen::Vector3d& p : points) distances.push_back(Distance_m(inverse_m, p));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace

std::optional<Eigen::Vector3d> FitGroundPlane(const FeatureTracks& tracks,
                                              const VisualDepths& depths) {
  TVL_CHECK(tracks.tracks.size() == depths.size()) << "one depth a track";
  const std::vector<Eigen::Vector3d> points = GroundPoints(tracks, depths);
  if (points.size() < kMinPoints) return std::nullopt;
  Eigen::Vector3d inverse_m = Eigen::Vector3d::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d A = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) {
      const double distance_m = iteration == 0 ? 0.0 : Distance_m(inverse_m, p);
      const double robust = 1.0 / (1.0 + std::pow(distance_m / kMaxMedian_m, 2));
      const double weight = robust / p.squaredNorm();  // far points span the plane as well as near
      A += weight * p * p.transpose();
      b += weight * p;
    }
    inverse_m = A.ldlt().solve(b);
  }
  if (!inverse_m.allFinite() || inverse_m.norm() < 1e-3) return std::nullopt;
  if (MedianDistance_m(inverse_m, points) > kMaxMedian_m) return std::nullopt;
  return inverse_m;
}

cv::Matx33d PlaneHomography(const Eigen::Vector3d& inverse_m, const Rigid3d& T_cur_prev,
                            const Camera& camera) {
  TVL_CHECK(!camera.IsDistorted()) << "a homography is one of undistorted images";
  Eigen::Matrix3d K;
  K << camera.fx_px, 0.0, camera.cx_px, 0.0, camera.fy_px, camera.cy_px, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d H =
      K * (T_cur_prev.R() + T_cur_prev.t() * inverse_m.transpose()) * K.inverse();
  return {H(0, 0), H(0, 1), H(0, 2), H(1, 0), H(1, 1), H(1, 2), H(2, 0), H(2, 1), H(2, 2)};
}

}  // namespace tvl
