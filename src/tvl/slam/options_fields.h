// The one list of option fields: loading, dumping and checking all walk it, so they cannot
// disagree.
//
// A new field needs one line (TVL_FIELD with its name) here, or in preprocessing_options_fields.h
// or loop_options_fields.h, and a row in docs/options.md; a new struct needs a VisitFields of its
// own. options_io_test.cc fails until that is done.
//
// A visitor is called as visit("name", field) for each field in the order of the struct; a field
// that is itself a struct of options is handed over whole.
#pragma once

#include "tvl/slam/loop_options_fields.h"
#include "tvl/slam/preprocessing_options_fields.h"
#include "tvl/slam/slam_runner.h"

namespace tvl {

// The name in the code is the name in the file: that takes the preprocessor.
#define TVL_FIELD(name) visit(#name, options.name)

template <typename Visitor>
void VisitFields(Visitor& visit, WeaknessOptions& options) {
  TVL_FIELD(normal_sigma_rad);
  TVL_FIELD(weak_translation);
  TVL_FIELD(held_translation);
  TVL_FIELD(weak_rotation);
  TVL_FIELD(held_rotation);
}

template <typename Visitor>
void VisitFields(Visitor& visit, CovarianceOptions& options) {
  TVL_FIELD(inflation);
  TVL_FIELD(floor_translation);
  TVL_FIELD(floor_rotation_rad_per_m);
  TVL_FIELD(floor_translation_m);
  TVL_FIELD(floor_rotation_rad);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LaserMatchOptions& options) {
  TVL_FIELD(edge_sigma_m);
  TVL_FIELD(plane_sigma_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, VisualMatchOptions& options) {
  TVL_FIELD(sigma_px);
  TVL_FIELD(max_relative_sigma);
  TVL_FIELD(min_baseline_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, RoadMotionOptions& options) {
  TVL_FIELD(sigma_px);
  TVL_FIELD(max_relative_sigma);
  TVL_FIELD(gate_sigmas);
  TVL_FIELD(min_tracks);
  TVL_FIELD(min_share);
  TVL_FIELD(max_sigma_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, OdometryOptions& options) {
  TVL_FIELD(enabled);
  TVL_FIELD(laser);
  TVL_FIELD(visual);
  TVL_FIELD(road);
  TVL_FIELD(kernel_sigmas);
  TVL_FIELD(visual_kernel_sigmas);
  TVL_FIELD(visual_gate_sigmas);
  TVL_FIELD(max_refreshes);
  TVL_FIELD(first_gate_m);
  TVL_FIELD(last_gate_m);
  TVL_FIELD(stop_rotation_rad);
  TVL_FIELD(stop_translation_m);
  TVL_FIELD(min_matches);
  TVL_FIELD(max_start_step_m);
  TVL_FIELD(use_camera);
  TVL_FIELD(weakness);
  TVL_FIELD(covariance);
}

template <typename Visitor>
void VisitFields(Visitor& visit, KeyframeOptions& options) {
  TVL_FIELD(min_translation_m);
  TVL_FIELD(min_rotation_rad);
  TVL_FIELD(dense_keyframes);
  TVL_FIELD(dense_share);
}

template <typename Visitor>
void VisitFields(Visitor& visit, SurfelOptions& options) {
  TVL_FIELD(min_points);
  TVL_FIELD(max_thickness_m);
  TVL_FIELD(min_shape_ratio);
  TVL_FIELD(min_extent_share);
}

template <typename Visitor>
void VisitFields(Visitor& visit, SurfelMapOptions& options) {
  TVL_FIELD(kind);
  TVL_FIELD(sizes_m);
  TVL_FIELD(surfel);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LocalMapOptions& options) {
  TVL_FIELD(keep_path_m);
  TVL_FIELD(connected_radius_m);
  TVL_FIELD(connected_changes);
  TVL_FIELD(connected_tolerance_m);
  TVL_FIELD(planes);
  TVL_FIELD(lines);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LandmarkOptions& options) {
  TVL_FIELD(sigma_px);
  TVL_FIELD(drift_px);
  TVL_FIELD(max_relative_sigma);
  TVL_FIELD(reanchor_share);
  TVL_FIELD(gate_chi2);
  TVL_FIELD(max_rejections);
}

template <typename Visitor>
void VisitFields(Visitor& visit, ScanToMapOptions& options) {
  TVL_FIELD(source_voxel_m);
  TVL_FIELD(sensor_sigma_m);
  TVL_FIELD(beam_sigma_rad);
  TVL_FIELD(common_beam_sigma_rad);
  TVL_FIELD(edge_sigma_m);
  TVL_FIELD(kernel_sigmas);
  TVL_FIELD(visual_kernel_sigmas);
  TVL_FIELD(visual_gate_sigmas);
  TVL_FIELD(max_refreshes);
  TVL_FIELD(first_gate_m);
  TVL_FIELD(last_gate_m);
  TVL_FIELD(stop_rotation_rad);
  TVL_FIELD(stop_translation_m);
  TVL_FIELD(min_matches);
  TVL_FIELD(prior_share);
  TVL_FIELD(use_camera);
  TVL_FIELD(weakness);
  TVL_FIELD(covariance);
  TVL_FIELD(gate_inflation);
}

template <typename Visitor>
void VisitFields(Visitor& visit, BeamCalibrationOptions& options) {
  TVL_FIELD(enabled);
  TVL_FIELD(prior_elevation_rad);
  TVL_FIELD(prior_range_m);
  TVL_FIELD(information_share);
  TVL_FIELD(memory_frames);
  TVL_FIELD(update_every);
}

template <typename Visitor>
void VisitFields(Visitor& visit, KeyframeStoreOptions& options) {
  TVL_FIELD(memory_mib);
  TVL_FIELD(folder);
}

template <typename Visitor>
void VisitFields(Visitor& visit, MapFitOptions& options) {
  TVL_FIELD(max_distance_m);
  TVL_FIELD(max_range_m);
  TVL_FIELD(min_column_points);
  TVL_FIELD(max_points);
}

template <typename Visitor>
void VisitFields(Visitor& visit, MovingTrackOptions& options) {
  TVL_FIELD(sigma_px);
  TVL_FIELD(gate_sigmas);
  TVL_FIELD(min_motion_m);
  TVL_FIELD(drift_share);
  TVL_FIELD(drift_rad);
  TVL_FIELD(min_frames);
  TVL_FIELD(min_cluster_tracks);
  TVL_FIELD(min_cluster_share);
  TVL_FIELD(min_cluster_accord);
}

template <typename Visitor>
void VisitFields(Visitor& visit, MappingOptions& options) {
  TVL_FIELD(interval);
  TVL_FIELD(beams);
  TVL_FIELD(keyframes);
  TVL_FIELD(store);
  TVL_FIELD(local_map);
  TVL_FIELD(landmarks);
  TVL_FIELD(moving_tracks);
  TVL_FIELD(scan_to_map);
  TVL_FIELD(fit);
}

template <typename Visitor>
void VisitFields(Visitor& visit, FrameClockOptions& options) {
  TVL_FIELD(regular_share);
  TVL_FIELD(span_frames);
  TVL_FIELD(window_frames);
}

template <typename Visitor>
void VisitFields(Visitor& visit, MotionModelOptions& options) {
  TVL_FIELD(acceleration_sigma_m);
  TVL_FIELD(acceleration_sigma_rad);
}

template <typename Visitor>
void VisitFields(Visitor& visit, PoseSearchOptions& options) {
  TVL_FIELD(radius_m);
  TVL_FIELD(start_radius_m);
  TVL_FIELD(yaw_window_rad);
  TVL_FIELD(lost_yaw_rate_rad_per_s);
  TVL_FIELD(max_yaw_window_rad);
  TVL_FIELD(min_height_m);
  TVL_FIELD(max_followed);
  TVL_FIELD(bev);
}

template <typename Visitor>
void VisitFields(Visitor& visit, HealthOptions& options) {
  TVL_FIELD(window_frames);
  TVL_FIELD(first_usual_misfit);
  TVL_FIELD(suspicious_rise);
  TVL_FIELD(lost_rise);
  TVL_FIELD(suspicious_innovation_m);
  TVL_FIELD(suspicious_innovation_rad);
  TVL_FIELD(min_judged);
  TVL_FIELD(min_better_sigmas);
}

template <typename Visitor>
void VisitFields(Visitor& visit, TrafficOptions& options) {
  TVL_FIELD(window_frames);
  TVL_FIELD(min_slipping_frames);
  TVL_FIELD(min_slip_m);
  TVL_FIELD(slip_share);
  TVL_FIELD(max_speed_m_s);
  TVL_FIELD(corridor_m);
  TVL_FIELD(min_start_share);
  TVL_FIELD(release_m);
  TVL_FIELD(max_frames_without_road);
  TVL_FIELD(min_moving_misfit);
  TVL_FIELD(max_surroundings_sigma_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, EdgeAlignmentOptions& options) {
  TVL_FIELD(max_edges);
  TVL_FIELD(max_images);
  TVL_FIELD(min_way_m);
  TVL_FIELD(every_frames);
  TVL_FIELD(bias_across_rad);
  TVL_FIELD(bias_up_rad);
  TVL_FIELD(bias_about_rad);
}

template <typename Visitor>
void VisitFields(Visitor& visit, CameraOffsetOptions& options) {
  TVL_FIELD(enabled);
  TVL_FIELD(max_images);
  TVL_FIELD(max_edges);
  TVL_FIELD(every_images);
  TVL_FIELD(max_delay_s);
  TVL_FIELD(prior_delay_s);
  TVL_FIELD(prior_place_m);
  TVL_FIELD(bias_delay_s);
  TVL_FIELD(bias_place_m);
  TVL_FIELD(bias_up_m);
  TVL_FIELD(min_significance);
}

template <typename Visitor>
void VisitFields(Visitor& visit, ExtrinsicCheckOptions& options) {
  TVL_FIELD(enabled);
  TVL_FIELD(bias_rad);
  TVL_FIELD(min_windows);
}

template <typename Visitor>
void VisitFields(Visitor& visit, ExtrinsicCalibrationOptions& options) {
  TVL_FIELD(enabled);
  TVL_FIELD(window_m);
  TVL_FIELD(max_frames);
  TVL_FIELD(min_tracks);
  TVL_FIELD(corner_sigma_px);
  TVL_FIELD(motion_sigma_rad);
  TVL_FIELD(motion_sigma_share);
  TVL_FIELD(prior_rad);
  TVL_FIELD(bias_rad);
  TVL_FIELD(memory_windows);
  TVL_FIELD(doubt_significance);
  TVL_FIELD(min_significance);
  TVL_FIELD(use_edges);
  TVL_FIELD(edges);
  TVL_FIELD(offset);
  TVL_FIELD(check);
}

template <typename Visitor>
void VisitFields(Visitor& visit, PoseUncertaintyOptions& options) {
  TVL_FIELD(noise_share);
  TVL_FIELD(walk_per_m);
  TVL_FIELD(bias_level_rad_per_m);
  TVL_FIELD(bias_yaw_rad_per_m);
  TVL_FIELD(bias_scale);
  TVL_FIELD(independent_path_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, SlamOptions& options) {
  TVL_FIELD(preprocessing);
  TVL_FIELD(clock);
  TVL_FIELD(motion);
  TVL_FIELD(odometry);
  TVL_FIELD(mapping);
  TVL_FIELD(search);
  TVL_FIELD(health);
  TVL_FIELD(traffic);
  TVL_FIELD(extrinsics);
  TVL_FIELD(uncertainty);
  TVL_FIELD(loops);
  TVL_FIELD(use_camera);
}

template <typename Visitor>
void VisitFields(Visitor& visit, DeskewDecisionOptions& options) {
  TVL_FIELD(max_frames);
  TVL_FIELD(min_informative);
  TVL_FIELD(min_rotation_rad);
  TVL_FIELD(min_significance);
}

#undef TVL_FIELD

// A whole file: the system's options at its top level, and the de-skewing. The number of threads is
// no part of it: it belongs to the machine and never changes a result.
template <typename Visitor>
void VisitFields(Visitor& visit, RunOptions& options) {
  visit("deskew", options.deskew);
  visit("deskew_decision", options.decision);
  VisitFields(visit, options.slam);
}

}  // namespace tvl
