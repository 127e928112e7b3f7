#!/usr/bin/env python3
"""Compares `tvl evaluate` with evo, an independent implementation, on one pair of trajectories.

    check_evo.py --truth POSES.txt --estimate trajectory_kitti.txt [--binary tvl]

ATE (aligned and from the first pose) and RPE over one frame must agree to 1e-6 relative; exit code 1
if they do not. The devkit's segment errors are checked against benchmarks/bench/metrics.py, which
was written separately.
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
    """name -> value, by evo."""
    from evo.core import metrics as evo_metrics
    from evo.core.trajectory import PosePath3D

    def ape(align):
        a, b = PosePath3D(poses_se3=list(truth)), PosePath3D(poses_se3=list(estimate))
        if align:
            b.align(a)
        metric = evo_metrics.APE(evo_metrics.PoseRelation.translation_part)
        metric.process_data((a, b))
        return metric.get_statistic(evo_metrics.StatisticsType.rmse)

    def rpe(relation):
        metric = evo_metrics.RPE(relation, delta=1, delta_unit=evo_metrics.Unit.frames,
                                 all_pairs=True)
        metric.process_data((PosePath3D(poses_se3=list(truth)),
                             PosePath3D(poses_se3=list(estimate))))
        return metric.get_statistic(evo_metrics.StatisticsType.rmse)

    return {
        "ate_aligned_m": ape(True),
        "ate_first_pose_m": ape(False),
        "rpe_frame_m": rpe(evo_metrics.PoseRelation.translation_part),
        "rpe_frame_deg": rpe(evo_metrics.PoseRelation.rotation_angle_deg),
    }


def flat(tree, prefix=""):
    """Nested JSON objects as dotted names."""
    out = {}
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            out.update(flat(value, name + "."))
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            out[name] = float(value)
    return out


def closest(value, figures):
    """The figure of ours that is nearest to `value`, relative difference."""
    name = min(figures, key=lambda n: abs(figures[n] - value))
    return name, abs(figures[name] - value) / max(abs(value), 1e-12)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--truth", type=pathlib.Path, required=True)
    parser.add_argument("--estimate", type=pathlib.Path, required=True)
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY)
    args = parser.parse_args()
    truth, estimate = poses.read_poses(args.truth), poses.read_poses(args.estimate)
    count = min(len(truth), len(estimate))
    expected = evo_figures(truth[:count], estimate[:count])
    expected["kitti_t_err_percent"], expected["kitti_r_err_deg_per_100m"] = (
        metrics.kitti_errors(truth[:count], estimate[:count]))
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "evaluation.json"
        ours.execute(args.binary, "evaluate", "--truth", args.truth, "--estimate", args.estimate,
                     "--json", report)
        figures = flat(json.loads(report.read_text()))
    wrong = 0
    for name, value in expected.items():
        if np.isnan(value):
            print(f"{name:<26} not defined (too short)")
            continue
        key, difference = closest(value, figures)
        wrong += difference > TOLERANCE
        print(f"{name:<26} {value:.9g}   ours {key} = {figures[key]:.9g}   "
              f"{'ok' if difference <= TOLERANCE else 'DIFFERS'} ({difference:.1e})")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
