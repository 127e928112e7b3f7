"""A trajectory against its truth, the same figures for every system."""

import numpy as np

from . import metrics, poses as se3


def truth_at(truth_cam0, T_cam0_lidar, instants):
    """Lidar truth at an instant (0..1) of each sweep; poses.txt belongs to the middle."""
    return se3.shifted(se3.to_lidar(truth_cam0, T_cam0_lidar), np.asarray(instants) - 0.5)


def figures(truth_lidar, estimate_lidar, T_cam0_lidar):
    """name -> value; positions are those of camera 0, as KITTI has it, headings those of the lidar."""
    truth = se3.to_camera(truth_lidar, T_cam0_lidar)
    estimate = se3.to_camera(estimate_lidar, T_cam0_lidar)
    t_err, r_err = metrics.kitti_errors(truth, estimate)
    end_m, end_deg = metrics.end_error(truth, estimate)
    heading = metrics.heading_deg_per_km(truth_lidar, estimate_lidar)
    return {"t_err_pct": t_err, "r_err_deg_per_100m": r_err,
            "ate_m": metrics.ate_m(truth, estimate),
            "ate_first_m": metrics.ate_first_m(truth, estimate),
            "heading_deg_per_km": abs(heading), "heading_signed_deg_per_km": heading,
            "end_m": end_m, "end_deg": end_deg}
