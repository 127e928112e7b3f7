#include "tvl/depth/depth_association.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/depth/local_plane.h"

namespace tvl {
namespace {

// Half extents of a neighbourhood on the normalised plane. Constant in angle: away from the
// optical axis a radian covers more of the plane.
struct HalfExtents {
  double width = 0, height = 0;
};

HalfExtents NeighbourhoodAt(const Eigen::Vector2d& ray, double gap_rad,
                            const DepthOptions& options) {
  const double across = 1.0 + ray.x() * ray.x();
  return {options.half_width_rad * across,
          options.half_height_gaps * gap_rad * (across + ray.y() * ray.y()) / std::sqrt(across)};
}

NormalisedRect RectAround(const Eigen::Vector2d& ray, const HalfExtents& half) {
  return {static_cast<float>(ray.x() - half.width), static_cast<float>(ray.y() - half.height),
          static_cast<float>(ray.x() + half.width), static_cast<float>(ray.y() + half.height)};
}

// All neighbourhoods of the tracks.
NormalisedRect Bounds(const FeatureTracks& tracks, double gap_rad, const DepthOptions& options) {
  NormalisedRect all{1e9f, 1e9f, -1e9f, -1e9f};
  for (const FeatureTrack& track : tracks.tracks) {
    const NormalisedRect r =
        RectAround(track.ray_cam, NeighbourhoodAt(track.ray_cam, gap_rad, options));
    all = {std::min(all.min_x, r.min_x), std::min(all.min_y, r.min_y), std::max(all.max_x, r.max_x),
           std::max(all.max_y, r.max_y)};
  }
  return all;
}

bool SpansTwoRings(const std::vector<ProjectedPoint>& points) {
  return std::any_of(points.begin(), points.end(),
                     [&](const ProjectedPoint& p) { return p.ring != points.front().ring; });
}

struct DepthRange {
  double min_m = 0, max_m = 0;
};

DepthRange RangeOf(const std::vector<ProjectedPoint>& points) {
  const auto [low, high] = std::minmax_element(
      points.begin(), points.end(),
      [](const ProjectedPoint& a, const ProjectedPoint& b) { return a.depth_m < b.depth_m; });
  return {static_cast<double>(low->depth_m), static_cast<double>(high->depth_m)};
}

double Square(double v) { return v * v; }

// What the foreground's plane says about the ray.
VisualDepth Intersect(const LocalPlane& plane, const DepthRange& range, const Eigen::Vector2d& ray,
                      double focal_px, const LidarModel& lidar, const DepthOptions& options) {
  const double sin_a = plane.SinIncidence(ray);
  const double spread_m = range.max_m - range.min_m;
  if (spread_m > options.max_spread_m && plane.rms_m > sin_a * options.max_ray_rms * range.min_m) {
    return {DepthStatus::kSpread};
  }
  if (sin_a < std::sin(options.min_incidence_rad)) return {DepthStatus::kGrazing};
  const double depth_m = 1.0 / plane.InverseDepth(ray);
  if (!(depth_m > 0.0)) return {DepthStatus::kBehind};
  if (depth_m > options.max_depth_m) return {DepthStatus::kTooFar};
  const double margin_m = options.max_extrapolation * depth_m;
  if (depth_m < range.min_m - margin_m || depth_m > range.max_m + margin_m) {
    return {DepthStatus::kSpread};
  }
  const double tan_a = sin_a / std::sqrt(std::max(1e-12, 1.0 - sin_a * sin_a));
  const double variance = Square(lidar.range_sigma_m / sin_a) +
                          Square(depth_m * options.sigma_px / (focal_px * tan_a)) +
                          plane.Leverage(ray) * Square(plane.rms_m / sin_a);
  return {DepthStatus::kOk, depth_m, std::sqrt(variance)};
}

// Of points of one label.
VisualDepth DepthOfForeground(const std::vector<ProjectedPoint>& foreground,
                              const Eigen::Vector2d& ray, double focal_px, const LidarModel& lidar,
                              const DepthOptions& options) {
  if (foreground.size() < 3) return {DepthStatus::kNoPoints};
  if (!SpansTwoRings(foreground)) return {DepthStatus::kOneRing};
  const LargestTriangle triangle = FindLargestTriangle(foreground);
  if (triangle.area_rad_sq < options.min_triangle_area_rad_sq) {
    return {DepthStatus::kSmallTriangle};
  }
  const LocalPlane plane = static_cast<int>(foreground.size()) >= options.least_squares_points
                               ? FitPlane(foreground)
                               : PlaneThrough(triangle.corners);
  if (!plane.valid) return {DepthStatus::kSmallTriangle};
  return Intersect(plane, RangeOf(foreground), ray, focal_px, lidar, options);
}

VisualDepth DepthOf(const Eigen::Vector2d& ray, const NormalisedGrid& grid, double gap_rad,
                    double focal_px, const LidarModel& lidar, const DepthOptions& options) {
  std::vector<ProjectedPoint> neighbours;
  grid.ForEach(RectAround(ray, NeighbourhoodAt(ray, gap_rad, options)),
               [&](const ProjectedPoint& p) { neighbours.push_back(p); });
  if (neighbours.size() < 3) return {DepthStatus::kNoPoints};
  const std::vector<ProjectedPoint> foreground = SelectForeground(std::move(neighbours));
  VisualDepth depth = DepthOfForeground(foreground, ray, focal_px, lidar, options);
  depth.label = foreground.front().label;
  return depth;
}

}  // namespace

void DepthOptions::Check() const {
  TVL_CHECK_INPUT(half_height_gaps > 0.0)
      << "half_height_gaps: must be positive, is " << half_height_gaps;
  TVL_CHECK_INPUT(default_gap_rad > 0.0)
      << "default_gap_rad: must be positive, is " << default_gap_rad;
  TVL_CHECK_INPUT(half_width_rad > 0.0)
      << "half_width_rad: must be positive, is " << half_width_rad;
  TVL_CHECK_INPUT(min_depth_m > 0.0) << "min_depth_m: must be positive, is " << min_depth_m;
  TVL_CHECK_INPUT(max_depth_m > min_depth_m)
      << "max_depth_m: must exceed min_depth_m, is " << max_depth_m;
  TVL_CHECK_INPUT(min_triangle_area_rad_sq >= 0.0)
      << "min_triangle_area_rad_sq: must not be negative, is " << min_triangle_area_rad_sq;
  TVL_CHECK_INPUT(least_squares_points >= 3)
      << "least_squares_points: must be at least 3, is " << least_squares_points;
  TVL_CHECK_INPUT(max_spread_m > 0.0) << "max_spread_m: must be positive, is " << max_spread_m;
  TVL_CHECK_INPUT(max_ray_rms > 0.0) << "max_ray_rms: must be positive, is " << max_ray_rms;
  TVL_CHECK_INPUT(min_incidence_rad >= 0.0 && min_incidence_rad < 0.5 * kPi)
      << "min_incidence_rad: must lie in 0..pi/2, is " << min_incidence_rad;
  TVL_CHECK_INPUT(max_extrapolation >= 0.0)
      << "max_extrapolation: must not be negative, is " << max_extrapolation;
  TVL_CHECK_INPUT(sigma_px >= 0.0) << "sigma_px: must not be negative, is " << sigma_px;
}

std::vector<ProjectedPoint> ProjectScan(const std::vector<Eigen::Vector3f>& p_lidar,
                                        const SegmentedScan& scan, const Rigid3d& T_cam_lidar,
                                        const NormalisedRect& bounds, const DepthOptions& options) {
  TVL_CHECK(p_lidar.size() == scan.label.size() && p_lidar.size() == scan.ring.size())
      << "points, labels and rings belong together";
  const Eigen::Matrix3f R = T_cam_lidar.R().cast<float>();
  const Eigen::Vector3f t = T_cam_lidar.t().cast<float>();
  const float nearest_m = static_cast<float>(options.min_depth_m);
  const float farthest_m = static_cast<float>(1.2 * options.max_depth_m);
  std::vector<ProjectedPoint> points;
  points.reserve(p_lidar.size() / 4);
  for (size_t i = 0; i < p_lidar.size(); ++i) {
    const float z = R.row(2).dot(p_lidar[i]) + t.z();
    if (!(z > nearest_m && z < farthest_m)) continue;
    if (scan.label[i] == kLabelOutlier && !options.use_outlier_points) continue;
    const float x = (R.row(0).dot(p_lidar[i]) + t.x()) / z;
    const float y = (R.row(1).dot(p_lidar[i]) + t.y()) / z;
    if (bounds.Contains(x, y)) points.push_back({x, y, z, scan.label[i], scan.ring[i]});
  }
  return points;
}

std::vector<ProjectedPoint> SelectForeground(std::vector<ProjectedPoint> neighbours) {
  std::stable_sort(neighbours.begin(), neighbours.end(),
                   [](const ProjectedPoint& a, const ProjectedPoint& b) {
                     return a.label != b.label ? a.label < b.label : a.depth_m < b.depth_m;
                   });
  size_t best_begin = 0, best_end = 0;
  for (size_t begin = 0, end = 0; begin < neighbours.size(); begin = end) {
    while (end < neighbours.size() && neighbours[end].label == neighbours[begin].label) ++end;
    const auto median_m = [&](size_t b, size_t e) { return neighbours[b + (e - b) / 2].depth_m; };
    if (best_end == 0 || median_m(begin, end) < median_m(best_begin, best_end)) {
      best_begin = begin;
      best_end = end;
    }
  }
  return {neighbours.begin() + static_cast<std::ptrdiff_t>(best_begin),
          neighbours.begin() + static_cast<std::ptrdiff_t>(best_end)};
}

VisualDepths AssociateDepth(const FeatureTracks& tracks,
                            const std::vector<Eigen::Vector3f>& p_lidar, const SegmentedScan& scan,
                            const Camera& camera, const Rigid3d& T_cam_lidar,
                            const LidarModel& lidar, const DepthOptions& options) {
  VisualDepths depths(tracks.tracks.size());
  if (depths.empty()) return depths;
  const double gap_rad =
      lidar.LargestGap_rad() > 0.0 ? lidar.LargestGap_rad() : options.default_gap_rad;
  const double focal_px = 0.5 * (camera.fx_px + camera.fy_px);
  const NormalisedRect bounds = Bounds(tracks, gap_rad, options);
  const NormalisedGrid grid(ProjectScan(p_lidar, scan, T_cam_lidar, bounds, options), bounds,
                            static_cast<float>(options.half_width_rad),
                            static_cast<float>(options.half_height_gaps * gap_rad));
  for (size_t i = 0; i < depths.size(); ++i) {
    depths[i] = DepthOf(tracks.tracks[i].ray_cam, grid, gap_rad, focal_px, lidar, options);
  }
  return depths;
}

}  // namespace tvl
