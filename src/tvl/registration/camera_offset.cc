#include "tvl/registration/camera_offset.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/registration/edge_score.h"

namespace tvl {
namespace {

constexpr double kRotationSigma_rad = 0.035;  // 2 deg: the reach
constexpr double kWidthSigma_rad = 9e-4;      // 0.05 deg, half of a beam's divergence
constexpr int kMinImages = 8;
constexpr int kMinEdges = 300;
constexpr int kStretches = 6;  // that the recording is divided into
constexpr double kObservedDelay_s = 0.005;
constexpr double kObservedPlace_m = 0.04;

EdgePrior PriorOf(const CameraOffsetOptions& options) {
  EdgePrior prior;
  prior.sigma.head<3>().setConstant(kRotationSigma_rad);
  prior.sigma.segment<3>(3).setConstant(options.prior_place_m);
  prior.sigma[kEdgeWidth] = kWidthSigma_rad;
  prior.sigma[kEdgeDelay] = options.prior_delay_s;
  return prior;
}

// Mean squares of what the answer changes by when one stretch after the other is left out.
EdgeVector JackknifeVariance(const std::vector<PlacedEdge>& placed, const std::vector<int>& stretch,
                             const EdgePrior& prior, const EdgeVector& x) {
  EdgeVector sum = EdgeVector::Zero();
  for (int left_out = 0; left_out < kStretches; ++left_out) {
    std::vector<PlacedEdge> rest;
    rest.reserve(placed.size());
    for (size_t i = 0; i < placed.size(); ++i) {
      if (stretch[i] != left_out) rest.push_back(placed[i]);
    }
    const EdgeFit fit = FitEdges(rest, prior, x);
    if (!fit.has_converged) return prior.sigma.cwiseAbs2();
    sum += (fit.x - x).cwiseAbs2();
  }
  return sum * (kStretches - 1.0) / kStretches;
}

EdgeProfiles Thinned(const EdgeProfiles& edges, int max_edges) {
  const size_t limit = static_cast<size_t>(max_edges);
  if (edges.profiles.size() <= limit) return edges;
  EdgeProfiles out;
  out.turning_rad_s = edges.turning_rad_s;
  out.profiles.reserve(limit);
  for (size_t i = 0; i < limit; ++i) {
    out.profiles.push_back(edges.profiles[i * edges.profiles.size() / limit]);
  }
  return out;
}

}  // namespace

void CameraOffsetOptions::Check() const {
  TVL_CHECK_INPUT(max_images >= 2 * kMinImages)
      << "extrinsics.offset.max_images: must be at least " << 2 * kMinImages;
  TVL_CHECK_INPUT(max_edges >= 1) << "extrinsics.offset.max_edges: must be at least 1";
  TVL_CHECK_INPUT(every_images >= 1) << "extrinsics.offset.every_images: must be at least 1";
  TVL_CHECK_INPUT(max_delay_s > 0.0) << "extrinsics.offset.max_delay_s: must be positive";
  TVL_CHECK_INPUT(prior_delay_s > 0.0) << "extrinsics.offset.prior_delay_s: must be positive";
  TVL_CHECK_INPUT(prior_place_m > 0.0) << "extrinsics.offset.prior_place_m: must be positive";
  TVL_CHECK_INPUT(bias_delay_s >= 0.0) << "extrinsics.offset.bias_delay_s: must not be negative";
  TVL_CHECK_INPUT(bias_place_m >= 0.0) << "extrinsics.offset.bias_place_m: must not be negative";
  TVL_CHECK_INPUT(bias_up_m >= 0.0) << "extrinsics.offset.bias_up_m: must not be negative";
  TVL_CHECK_INPUT(min_significance > 0.0) << "extrinsics.offset.min_significance: must be positive";
}

bool IsDelayObserved(const CameraOffsetEstimate& estimate) {
  return estimate.images > 0 && estimate.delay_sigma_s < kObservedDelay_s;
}

bool IsPlaceObserved(const CameraOffsetEstimate& estimate, int axis) {
  return estimate.images > 0 && estimate.translation_sigma_m[axis] < kObservedPlace_m;
}

CameraOffset::CameraOffset(const CameraOffsetOptions& options) : options_(options) {
  options_.Check();
  estimate_.delay_sigma_s = options_.prior_delay_s;
  estimate_.translation_sigma_m.setConstant(options_.prior_place_m);
}

void CameraOffset::Keep(const Image& image) {
  if (candidate_.empty() || image.edges.turning_rad_s > candidate_.front().edges.turning_rad_s) {
    candidate_.assign(1, image);
  }
  if (++since_kept_ < stride_) return;
  since_kept_ = 0;
  images_.push_back(std::move(candidate_.front()));
  candidate_.clear();
  if (static_cast<int>(images_.size()) <= options_.max_images) return;
  // Of two neighbours the one in which the vehicle turns more.
  std::vector<Image> kept;
  for (size_t i = 0; i + 1 < images_.size(); i += 2) {
    const bool second = images_[i + 1].edges.turning_rad_s > images_[i].edges.turning_rad_s;
    kept.push_back(std::move(images_[second ? i + 1 : i]));
  }
  if (images_.size() % 2 == 1) kept.push_back(std::move(images_.back()));
  images_ = std::move(kept);
  stride_ *= 2;
}

bool CameraOffset::Add(const EdgeProfiles& edges, const EdgeReading& reading) {
  if (!options_.enabled || edges.profiles.empty()) return false;
  Keep({Thinned(edges, options_.max_edges), reading});
  if (++since_solved_ < options_.every_images) return false;
  since_solved_ = 0;
  return Solve(reading);
}

bool CameraOffset::Solve(const EdgeReading& now) {
  std::vector<PlacedEdge> placed;
  std::vector<int> stretch;
  const int images = static_cast<int>(images_.size());
  for (int i = 0; i < images; ++i) {
    const Image& image = images_[static_cast<size_t>(i)];
    PlaceEdges(image.edges, now - image.reading, i, &placed);
    stretch.resize(placed.size(), i * kStretches / images);
  }
  if (images < kMinImages || static_cast<int>(placed.size()) < kMinEdges) return false;
  const EdgePrior prior = PriorOf(options_);
  const EdgeSearch across = SearchDelay(placed, options_.max_delay_s);
  if (!across.is_clear) return false;
  const EdgeSearch up = SearchAxis(placed, 0, across.delay_s);
  EdgeVector x = EdgeVector::Zero();
  x[1] = across.rotation_rad;
  if (up.is_clear) x[0] = up.rotation_rad;
  x[kEdgeDelay] = across.delay_s;
  const EdgeFit fit = FitEdges(placed, prior, x);
  if (!fit.has_converged) return false;
  // Where the score has no maximum the fit's covariance means nothing: no more than was possible.
  const EdgeVector variance =
      (fit.covariance.diagonal() + JackknifeVariance(placed, stretch, prior, fit.x))
          .cwiseMin(prior.sigma.cwiseAbs2());
  estimate_.images = images;
  estimate_.delay_s = now.delay_s + fit.x[kEdgeDelay];
  estimate_.delay_sigma_s = std::sqrt(variance[kEdgeDelay] + std::pow(options_.bias_delay_s, 2));
  estimate_.translation_m = fit.x.segment<3>(3);
  for (int i = 0; i < 3; ++i) {
    const double bias_m = i == 1 ? options_.bias_up_m : options_.bias_place_m;
    estimate_.translation_sigma_m[i] = std::sqrt(variance[3 + i] + bias_m * bias_m);
  }
  return true;
}

}  // namespace tvl
