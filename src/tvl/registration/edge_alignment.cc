#include "tvl/registration/edge_alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/registration/edge_score.h"

namespace tvl {
namespace {

constexpr double kPlaceSigma_m = 0.02;        // of what is not the rotation: the camera's place
constexpr double kWidthSigma_rad = 9e-4;      // 0.05 deg, half of a beam's divergence
constexpr double kRotationSigma_rad = 0.035;  // 2 deg: the reach
constexpr int kMinEdges = 60;                 // for an answer
// The outlines of one image may all be of one thing, and of one mistake.
constexpr int kMinImages = 4;

EdgePrior PriorOf(double delay_sigma_s) {
  EdgePrior prior;
  prior.sigma.head<3>().setConstant(kRotationSigma_rad);
  prior.sigma.segment<3>(3).setConstant(kPlaceSigma_m);
  prior.sigma[kEdgeWidth] = kWidthSigma_rad;
  prior.sigma[kEdgeDelay] = delay_sigma_s;
  return prior;
}

}  // namespace

void EdgeAlignmentOptions::Check() const {
  TVL_CHECK_INPUT(max_edges >= kMinEdges)
      << "extrinsics.edges.max_edges: must be at least " << kMinEdges;
  TVL_CHECK_INPUT(max_images >= 1) << "extrinsics.edges.max_images: must be at least 1";
  TVL_CHECK_INPUT(min_way_m >= 0.0) << "extrinsics.edges.min_way_m: must not be negative";
  TVL_CHECK_INPUT(every_frames >= 1) << "extrinsics.edges.every_frames: must be at least 1";
  TVL_CHECK_INPUT(bias_across_rad > 0.0) << "extrinsics.edges.bias_across_rad: must be positive";
  TVL_CHECK_INPUT(bias_up_rad > 0.0) << "extrinsics.edges.bias_up_rad: must be positive";
  TVL_CHECK_INPUT(bias_about_rad > 0.0) << "extrinsics.edges.bias_about_rad: must be positive";
}

EdgeAlignment::EdgeAlignment(const EdgeAlignmentOptions& options) : options_(options) {
  options_.Check();
}

bool EdgeAlignment::IsDue(const Rigid3d& T_odom_lidar) {
  constexpr int kSlower = 4;
  ++frames_since_;
  const bool is_full = static_cast<int>(images_.size()) == options_.max_images;
  const double way_m = (T_odom_lidar.t() - T_odom_last_.t()).norm();
  if (has_image_ && (frames_since_ < options_.every_frames * (is_full ? kSlower : 1) ||
                     way_m < options_.min_way_m)) {
    return false;
  }
  has_image_ = true;
  frames_since_ = 0;
  T_odom_last_ = T_odom_lidar;
  return true;
}

void EdgeAlignment::Add(EdgeProfiles edges, const EdgeReading& reading, const DelayBelief& delay) {
  // Read far from where the camera points, a profile lies beside the outline.
  constexpr double kStale_rad = 0.009;  // 0.5 deg
  const Eigen::Vector3d& rotation_rad = reading.rotation_rad;
  while (!images_.empty() &&
         (images_.front().reading.rotation_rad - rotation_rad).norm() > kStale_rad) {
    images_.pop_front();
  }
  images_.push_back({std::move(edges), reading});
  if (static_cast<int>(images_.size()) > options_.max_images) images_.pop_front();

  std::vector<PlacedEdge> placed;
  int number = 0;
  for (const Image& image : images_) {
    PlaceEdges(image.edges, reading - image.reading, number++, &placed);
  }
  const bool is_stale = (estimate_.rotation_rad - rotation_rad).norm() > kStale_rad;
  const bool are_few = static_cast<int>(images_.size()) < kMinImages;
  if (are_few || is_stale) estimate_ = {};  // else kept where there is no new answer
  if (are_few || static_cast<int>(placed.size()) < kMinEdges) return;
  // About the rotation and the delay in use.
  EdgePrior prior = PriorOf(delay.sigma_s);
  prior.expected[kEdgeDelay] = delay.delay_s - reading.delay_s;
  EdgeVector x = prior.expected;
  const EdgeSearch up = SearchAxis(placed, 0, x[kEdgeDelay]);
  const EdgeSearch across = SearchAxis(placed, 1, x[kEdgeDelay]);
  if (up.is_clear) x[0] = up.rotation_rad;
  if (!across.is_clear) return;
  x[1] = across.rotation_rad;
  const EdgeFit fit = FitEdges(placed, prior, x);
  if (!fit.has_converged) return;
  Eigen::Matrix3d covariance = fit.covariance.topLeftCorner<3, 3>();
  covariance(0, 0) += std::pow(options_.bias_up_rad, 2);
  covariance(1, 1) += std::pow(options_.bias_across_rad, 2);
  covariance(2, 2) += std::pow(options_.bias_about_rad, 2);
  if (!up.is_clear) covariance(0, 0) += std::pow(kRotationSigma_rad, 2);
  estimate_.images = static_cast<int>(images_.size());
  estimate_.rotation_rad = rotation_rad + fit.x.head<3>();
  estimate_.information = covariance.inverse();
}

}  // namespace tvl
