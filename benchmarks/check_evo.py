#!/usr/bin/env python3
"""Compares `tvl evaluate` with evo, an independent implementation, on one pair of trajectories.

    check_evo.py --truth POSES.txt --estimate trajectory_kitti.txt [--binary tvl]

ATE (aligned and from the first pose) and RPE over one frame come from evo, the devkit's segment errors
and the paper's Table 1 from code written separately (benchmarks/bench/metrics.py). All must agree to
1e-6 relative; exit code 1 if they do not.
"""

import argparse
import json
import pathlib
import sys
import tempfile

import numpy as np

from bench import metrics, ours, poses

TOLERANCE = 1e-6


def evo_figures(truth, estimate):
    """Place in the JSON of `tvl evaluate` (within its first drive) -> value by evo."""
    from evo.core import metrics as evo_metrics
    from evo.core.trajectory import PosePath3D

    def path(poses_se3):
        return PosePath3D(poses_se3=list(poses_se3))

    def ape(align):
        a, b = path(truth), path(estimate)
        if align:
            b.align(a)
        metric = evo_metrics.APE(evo_metrics.PoseRelation.translation_part)
        metric.process_data((a, b))
        return metric.get_statistic(evo_metrics.StatisticsType.rmse)

    def rpe(relation):
        metric = evo_metrics.RPE(relation, delta=1, delta_unit=evo_metrics.Unit.frames,
                                 all_pairs=True)
        metric.process_data((path(truth), path(estimate)))
        return metric.get_statistic(evo_metrics.StatisticsType.rmse)

    return {
        "ate_se3.rmse_m": ape(True),
        "ate_first_pose.rmse_m": ape(False),
        "rpe_1_frame.translation_rmse_m": rpe(evo_metrics.PoseRelation.translation_part),
        "rpe_1_frame.rotation_rmse_deg": rpe(evo_metrics.PoseRelation.rotation_angle_deg),
    }


def table_1(truth, estimate):
    """The paper's end error: D = (G_0^-1 G_N)^-1 (E_0^-1 E_N)."""
    D = (poses.inverse(poses.inverse(truth[0]) @ truth[-1])
         @ poses.inverse(estimate[0]) @ estimate[-1])
    return {"total.translation_m": np.linalg.norm(D[:3, 3]),
            "total.rotation_deg": np.rad2deg(poses.angle_rad(D))}


def expected_figures(truth, estimate):
    t_err, r_err = metrics.kitti_errors(truth, estimate)
    return {**evo_figures(truth, estimate), **table_1(truth, estimate),
            "kitti.t_err_percent": t_err, "kitti.r_err_deg_per_100m": r_err}


def our_figure(drive, place):
    """Value at a dotted place; NaN for null."""
    for key in place.split("."):
        drive = drive[key]
    return float("nan") if drive is None else float(drive)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--truth", type=pathlib.Path, required=True)
    parser.add_argument("--estimate", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    args = parser.parse_args()
    truth, estimate = poses.read_poses(args.truth), poses.read_poses(args.estimate)
    count = min(len(truth), len(estimate))
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "evaluation.json"
        ours.execute(args.binary, "evaluate", "--truth", args.truth, "--estimate", args.estimate,
                     "--json", report)
        drive = json.loads(report.read_text())["drives"][0]
    wrong = 0
    for place, value in expected_figures(truth[:count], estimate[:count]).items():
        figure = our_figure(drive, place)
        agree = bool(np.isclose(figure, value, rtol=TOLERANCE, atol=1e-9, equal_nan=True))
        wrong += not agree
        print(f"{place:<32} expected {value:<14.9g} ours {figure:<14.9g} {'ok' if agree else 'DIFFERS'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
