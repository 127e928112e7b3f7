// The option fields of preprocessing, see options_fields.h.
#pragma once

#include "tvl/slam/slam_options.h"

namespace tvl {

// The name in the code is the name in the file: that takes the preprocessor.
#define TVL_FIELD(name) visit(#name, options.name)

template <typename Visitor>
void VisitFields(Visitor& visit, ImagePreparationOptions& options) {
  TVL_FIELD(clahe_clip);
  TVL_FIELD(clahe_tiles);
  TVL_FIELD(min_mean_level);
  TVL_FIELD(min_contrast_level);
}

template <typename Visitor>
void VisitFields(Visitor& visit, OpticalFlowOptions& options) {
  TVL_FIELD(window_px);
  TVL_FIELD(max_level);
  TVL_FIELD(seeded_level);
  TVL_FIELD(max_iterations);
  TVL_FIELD(min_step_px);
  TVL_FIELD(max_backward_error_px);
}

template <typename Visitor>
void VisitFields(Visitor& visit, EpipolarFilterOptions& options) {
  TVL_FIELD(reference_focal_px);
  TVL_FIELD(max_distance_px);
  TVL_FIELD(confidence);
  TVL_FIELD(min_median_flow_px);
  TVL_FIELD(min_points);
}

template <typename Visitor>
void VisitFields(Visitor& visit, CornerDetectorOptions& options) {
  TVL_FIELD(min_distance_px);
  TVL_FIELD(quality);
  TVL_FIELD(cell_px);
  TVL_FIELD(min_contrast_sigmas);
  TVL_FIELD(min_contrast_levels);
}

template <typename Visitor>
void VisitFields(Visitor& visit, FeatureTrackerOptions& options) {
  TVL_FIELD(max_features);
  TVL_FIELD(refill_share);
  TVL_FIELD(min_kept_share);
  TVL_FIELD(road_distance_px);
  TVL_FIELD(image);
  TVL_FIELD(flow);
  TVL_FIELD(epipolar);
  TVL_FIELD(corners);
}

template <typename Visitor>
void VisitFields(Visitor& visit, RingRecoveryOptions& options) {
  TVL_FIELD(max_backstep_rad);
  TVL_FIELD(min_range_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, GroundOptions& options) {
  TVL_FIELD(max_slope_rad);
  TVL_FIELD(max_step_m);
  TVL_FIELD(height_noise_m);
  TVL_FIELD(steep_rad);
  TVL_FIELD(seed_radius_m);
  TVL_FIELD(max_seed_tilt_rad);
  TVL_FIELD(seed_tolerance_m);
  TVL_FIELD(min_seed_points);
}

template <typename Visitor>
void VisitFields(Visitor& visit, ClusterOptions& options) {
  TVL_FIELD(min_angle_rad);
  TVL_FIELD(range_noise_m);
  TVL_FIELD(min_line_angle_rad);
  TVL_FIELD(line_tolerance_m);
  TVL_FIELD(line_tolerance_share);
  TVL_FIELD(max_bridged_cells);
  TVL_FIELD(min_points);
  TVL_FIELD(min_rows);
  TVL_FIELD(min_points_with_rows);
}

template <typename Visitor>
void VisitFields(Visitor& visit, SegmentationOptions& options) {
  TVL_FIELD(rings);
  TVL_FIELD(ground);
  TVL_FIELD(clusters);
}

template <typename Visitor>
void VisitFields(Visitor& visit, CurvatureOptions& options) {
  TVL_FIELD(half_window);
  TVL_FIELD(half_window_m);
  TVL_FIELD(max_half_window);
  TVL_FIELD(occlusion_step_m);
  TVL_FIELD(max_gap_columns);
  TVL_FIELD(parallel_share);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LaserFeatureOptions& options) {
  TVL_FIELD(curvature);
  TVL_FIELD(min_edge_curvature);
  TVL_FIELD(edge_noise_sigmas);
  TVL_FIELD(subregions);
  TVL_FIELD(sharp_per_subregion);
  TVL_FIELD(less_sharp_per_subregion);
  TVL_FIELD(flat_per_subregion);
  TVL_FIELD(less_flat_voxel_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, PlanarPointOptions& options) {
  TVL_FIELD(voxel_m);
  TVL_FIELD(coarse_voxel_m);
  TVL_FIELD(neighbourhood_m);
  TVL_FIELD(min_neighbours);
  TVL_FIELD(max_thickness_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, DepthOptions& options) {
  TVL_FIELD(half_height_gaps);
  TVL_FIELD(default_gap_rad);
  TVL_FIELD(half_width_rad);
  TVL_FIELD(min_depth_m);
  TVL_FIELD(max_depth_m);
  TVL_FIELD(use_outlier_points);
  TVL_FIELD(min_triangle_area_rad_sq);
  TVL_FIELD(least_squares_points);
  TVL_FIELD(max_spread_m);
  TVL_FIELD(max_ray_rms);
  TVL_FIELD(min_incidence_rad);
  TVL_FIELD(max_extrapolation);
  TVL_FIELD(sigma_px);
}

template <typename Visitor>
void VisitFields(Visitor& visit, FastCornersOptions& options) {
  TVL_FIELD(count);
  TVL_FIELD(threshold_levels);
  TVL_FIELD(cell_px);
  TVL_FIELD(min_distance_px);
}

template <typename Visitor>
void VisitFields(Visitor& visit, ImageFeatureOptions& options) {
  TVL_FIELD(corners);
  TVL_FIELD(image);
}

template <typename Visitor>
void VisitFields(Visitor& visit, PreprocessingOptions& options) {
  TVL_FIELD(vision);
  TVL_FIELD(loop_features);
  TVL_FIELD(segmentation);
  TVL_FIELD(features);
  TVL_FIELD(planar_points);
  TVL_FIELD(depth);
  TVL_FIELD(road_features);
  TVL_FIELD(calibrated_on_stored_points);
}

#undef TVL_FIELD

}  // namespace tvl
