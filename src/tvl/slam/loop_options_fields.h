// The option fields of loop closing, see options_fields.h.
#pragma once

#include "tvl/slam/slam_options.h"

namespace tvl {

// The name in the code is the name in the file: that takes the preprocessor.
#define TVL_FIELD(name) visit(#name, options.name)

template <typename Visitor>
void VisitFields(Visitor& visit, LoopSeparationOptions& options) {
  TVL_FIELD(min_time_s);
  TVL_FIELD(min_path_m);
  TVL_FIELD(pass_gap_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, DriftOptions& options) {
  TVL_FIELD(visual_floor_m);
  TVL_FIELD(visual_share);
  TVL_FIELD(vicinity_floor_m);
  TVL_FIELD(vicinity_share);
  TVL_FIELD(lidar_floor_m);
  TVL_FIELD(lidar_share);
}

template <typename Visitor>
void VisitFields(Visitor& visit, FeatureMatchingOptions& options) {
  TVL_FIELD(max_distance_bits);
  TVL_FIELD(max_ratio);
}

template <typename Visitor>
void VisitFields(Visitor& visit, GuidedMatchingOptions& options) {
  TVL_FIELD(max_error_rad);
  TVL_FIELD(max_distance_bits);
}

template <typename Visitor>
void VisitFields(Visitor& visit, PnpOptions& options) {
  TVL_FIELD(max_error_rad);
  TVL_FIELD(min_inliers);
  TVL_FIELD(min_inlier_share);
  TVL_FIELD(confidence);
  TVL_FIELD(max_iterations);
  TVL_FIELD(seed);
}

template <typename Visitor>
void VisitFields(Visitor& visit, VisualProposerOptions& options) {
  TVL_FIELD(direct_level);
  TVL_FIELD(min_relative_similarity);
  TVL_FIELD(min_reference_similarity);
  TVL_FIELD(island_gap);
  TVL_FIELD(min_consistent);
  TVL_FIELD(max_islands);
  TVL_FIELD(matching);
  TVL_FIELD(min_start_inliers);
  TVL_FIELD(guided);
  TVL_FIELD(pnp);
}

template <typename Visitor>
void VisitFields(Visitor& visit, VicinityOptions& options) {
  TVL_FIELD(max_passes);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LidarDescriptorOptions& options) {
  TVL_FIELD(range_m);
  TVL_FIELD(cell_m);
  TVL_FIELD(min_height_m);
  TVL_FIELD(max_height_m);
  TVL_FIELD(ground_cell_m);
  TVL_FIELD(ground_slope);
  TVL_FIELD(max_wavelength_m);
  TVL_FIELD(min_wavelength_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LidarProposerOptions& options) {
  TVL_FIELD(shortlist);
  TVL_FIELD(shortlist_gap);
  TVL_FIELD(max_offset_m);
  TVL_FIELD(min_similarity);
  TVL_FIELD(max_ambiguity);
  TVL_FIELD(max_proposals);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopSubmapOptions& options) {
  TVL_FIELD(keyframes_each_way);
  TVL_FIELD(every_keyframe);
  TVL_FIELD(every_point);
  TVL_FIELD(voxel_m);
  TVL_FIELD(every_view);
  TVL_FIELD(view_range_m);
  TVL_FIELD(view_margin_m);
  TVL_FIELD(planes);
  TVL_FIELD(lines);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopSourceOptions& options) {
  TVL_FIELD(keyframes_back);
  TVL_FIELD(every_keyframe);
  TVL_FIELD(range_m);
  TVL_FIELD(plane_voxel_m);
  TVL_FIELD(edge_voxel_m);
  TVL_FIELD(raised_voxel_m);
  TVL_FIELD(raised_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, BevAlignmentOptions& options) {
  TVL_FIELD(cell_m);
  TVL_FIELD(yaw_step_rad);
  TVL_FIELD(range_m);
  TVL_FIELD(peak_distance_m);
  TVL_FIELD(peak_yaw_rad);
  TVL_FIELD(peaks);
}

template <typename Visitor>
void VisitFields(Visitor& visit, MatchNoise& options) {
  TVL_FIELD(sensor_sigma_m);
  TVL_FIELD(beam_sigma_rad);
  TVL_FIELD(edge_sigma_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopRegistrationOptions& options) {
  TVL_FIELD(coarse_gates_m);
  TVL_FIELD(fine_gates_m);
  TVL_FIELD(gate_share);
  TVL_FIELD(coarse_every_point);
  TVL_FIELD(kernel_sigmas);
  TVL_FIELD(noise);
  TVL_FIELD(weakness);
  TVL_FIELD(covariance);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopEvidenceOptions& options) {
  TVL_FIELD(trim_share);
  TVL_FIELD(unmatched_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopVerificationOptions& options) {
  TVL_FIELD(submap);
  TVL_FIELD(source);
  TVL_FIELD(bev);
  TVL_FIELD(registration);
  TVL_FIELD(evidence);
  TVL_FIELD(pose_radius_m);
  TVL_FIELD(pose_yaw_rad);
  TVL_FIELD(yaw_radius_m);
  TVL_FIELD(yaw_yaw_rad);
  TVL_FIELD(graph_yaw_rad);
  TVL_FIELD(rival_radius_m);
  TVL_FIELD(max_rms_m);
  TVL_FIELD(max_raised_rms_m);
  TVL_FIELD(min_overlap);
  TVL_FIELD(max_seen_through);
  TVL_FIELD(min_fit);
  TVL_FIELD(max_ambiguity);
  TVL_FIELD(min_translation_ratio);
  TVL_FIELD(min_rotation_ratio);
  TVL_FIELD(min_points);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopConsistencyOptions& options) {
  TVL_FIELD(max_chi2);
  TVL_FIELD(drift_share);
  TVL_FIELD(drift_floor_m);
  TVL_FIELD(drift_rad_per_m);
  TVL_FIELD(link_floor_m);
  TVL_FIELD(link_floor_rad);
  TVL_FIELD(linked_path_m);
  TVL_FIELD(min_support);
  TVL_FIELD(min_support_gap_m);
  TVL_FIELD(max_support_path_m);
  TVL_FIELD(max_doubt_path_m);
  TVL_FIELD(min_support_share);
  TVL_FIELD(max_chi2_of_rows);
  TVL_FIELD(min_row_m);
}

template <typename Visitor>
void VisitFields(Visitor& visit, IncrementalPoseGraphOptions& options) {
  TVL_FIELD(relinearize_rotation_rad);
  TVL_FIELD(relinearize_translation_m);
  TVL_FIELD(settle_rotation_rad);
  TVL_FIELD(settle_translation_m);
  TVL_FIELD(max_iterations);
  TVL_FIELD(loop_loss);
  TVL_FIELD(loop_width_sq);
  TVL_FIELD(max_innovation_sq);
  TVL_FIELD(min_weight_change);
}

template <typename Visitor>
void VisitFields(Visitor& visit, BatchPoseGraphOptions& options) {
  TVL_FIELD(loop_loss);
  TVL_FIELD(loop_width_sq);
  TVL_FIELD(gnc_step);
  TVL_FIELD(max_iterations);
  TVL_FIELD(min_cost_decrease);
}

template <typename Visitor>
void VisitFields(Visitor& visit, LoopOptions& options) {
  TVL_FIELD(enabled);
  TVL_FIELD(use_visual);
  TVL_FIELD(use_vicinity);
  TVL_FIELD(use_lidar);
  TVL_FIELD(lag_keyframes);
  TVL_FIELD(max_verifications);
  TVL_FIELD(connected_path_m);
  TVL_FIELD(vocabulary);
  TVL_FIELD(separation);
  TVL_FIELD(drift);
  TVL_FIELD(visual);
  TVL_FIELD(vicinity);
  TVL_FIELD(lidar_descriptor);
  TVL_FIELD(lidar);
  TVL_FIELD(verification);
  TVL_FIELD(consistency);
  TVL_FIELD(graph);
  TVL_FIELD(polish);
}

#undef TVL_FIELD

}  // namespace tvl
