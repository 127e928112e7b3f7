#!/usr/bin/env python3
"""Our pose graph beside GTSAM's iSAM2 on the same synthetic graphs, and what false loops do.

    cmake --preset dev -DTVL_BUILD_BENCHMARKS=ON && cmake --build --preset dev --target tvl_pose_graph_bench
    pose_graph.py --out DIR [--program build/dev/benchmarks/tvl_pose_graph_bench] [--seeds 1,2,3]

Writes the graphs (g2o) and pose_graph.json into DIR and prints tables. Times are processor time in
milliseconds, on one core. Also compares our g2o files with GTSAM's reader of them.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

import gtsam
import numpy as np

# GTSAM reads the information of g2o as if its half-angle rotation were the whole: 4 and 2 times ours.
GTSAM_ROTATION, GTSAM_MIXED = 4.0, 2.0


def percentile(values, share):
    return float(np.percentile(values, 100.0 * share)) if len(values) else 0.0


def run_ours(program, arguments):
    output = subprocess.run([program, *map(str, arguments)], check=True, capture_output=True)
    return json.loads(output.stdout)


def to_ours(information):
    """GTSAM's information of a g2o edge as the one of Log, [rotation, translation]."""
    ours = np.array(information)
    ours[:3, :3] /= GTSAM_ROTATION
    ours[:3, 3:] /= GTSAM_MIXED
    ours[3:, :3] /= GTSAM_MIXED
    return ours


class Graph:
    """Edges of a g2o file as GTSAM's own reader gives them, with the cost of ours."""

    def __init__(self, path):
        factors, self.initial = gtsam.readG2o(str(path), True)
        self.edges = []  # (from, to, factor)
        for k in range(factors.size()):
            factor = factors.at(k)
            i, j = factor.keys()
            noise = gtsam.noiseModel.Gaussian.Information(to_ours(factor.noiseModel().information()))
            self.edges.append((i, j, gtsam.BetweenFactorPose3(i, j, factor.measured(), noise)))

    def all_factors(self):
        graph = gtsam.NonlinearFactorGraph()
        for _, _, factor in self.edges:
            graph.push_back(factor)
        return graph


def hold_first(graph, pose):
    graph.push_back(gtsam.PriorFactorPose3(0, pose, gtsam.noiseModel.Isotropic.Sigma(6, 1e-6)))


def run_isam2(graph, threshold):
    """Keyframe by keyframe, each with its loops in a second update, as our program does it."""
    parameters = gtsam.ISAM2Params()
    parameters.setRelinearizeThreshold(threshold)
    parameters.relinearizeSkip = 1
    isam, keyframe_ms, loop_ms, eliminated = gtsam.ISAM2(parameters), [], [], []
    by_last = {}
    for edge in graph.edges:
        by_last.setdefault(max(edge[0], edge[1]), []).append(edge)
    first = gtsam.NonlinearFactorGraph()
    start = gtsam.Values()
    start.insert(0, graph.initial.atPose3(0))
    hold_first(first, graph.initial.atPose3(0))
    isam.update(first, start)
    pose = graph.initial.atPose3(0)
    for last in range(1, graph.initial.size()):
        odometry = [e for e in by_last[last] if (e[0], e[1]) == (last - 1, last)][:1]
        loops = [e for e in by_last[last] if e not in odometry]
        factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        factors.push_back(odometry[0][2])
        pose = pose.compose(odometry[0][2].measured())
        values.insert(last, pose)
        begin = time.process_time()
        isam.update(factors, values)
        pose = isam.calculateEstimatePose3(last)
        keyframe_ms.append(1e3 * (time.process_time() - begin))
        if loops:
            factors = gtsam.NonlinearFactorGraph()
            for loop in loops:
                factors.push_back(loop[2])
            begin = time.process_time()
            result = isam.update(factors, gtsam.Values())
            estimate = isam.calculateEstimate()
            loop_ms.append(1e3 * (time.process_time() - begin))
            eliminated.append(result.getVariablesReeliminated())
            pose = estimate.atPose3(last)
    return isam.calculateEstimate(), keyframe_ms, loop_ms, eliminated


def run_batch(graph):
    factors = graph.all_factors()
    hold_first(factors, graph.initial.atPose3(0))
    begin = time.process_time()
    values = gtsam.LevenbergMarquardtOptimizer(factors, graph.initial).optimize()
    return values, 1e3 * (time.process_time() - begin)


def aligned_rmse(values, truth):
    points = np.array([values.atPose3(k).translation() for k in range(truth.size())])
    target = np.array([truth.atPose3(k).translation() for k in range(truth.size())])
    a, b = points - points.mean(0), target - target.mean(0)
    u, _, vt = np.linalg.svd(b.T @ a)
    rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.sqrt(((a @ rotation.T - b) ** 2).sum(1).mean()))


def check_reader(path):
    """Our numbers against GTSAM's reading of them: largest differences."""
    graph = Graph(path)
    lines = [line.split() for line in open(path)]
    edges = [line for line in lines if line[0] == "EDGE_SE3:QUAT"]
    worst = {"translation_m": 0.0, "rotation_rad": 0.0, "information": 0.0}
    for line, (i, j, factor) in zip(edges, graph.edges):
        v = [float(x) for x in line[3:]]
        if (int(line[1]), int(line[2])) != (i, j):
            raise SystemExit(f"{path}: edges in another order")
        rotation = gtsam.Rot3.Quaternion(v[6], v[3], v[4], v[5])
        upper = np.zeros((6, 6))
        upper[np.triu_indices(6)] = v[7:]
        file_information = upper + np.triu(upper, 1).T
        # Translation first there, rotation first here; d [t, q_vec] / d [rotation, translation].
        jacobian = np.zeros((6, 6))
        jacobian[:3, 3:], jacobian[3:, :3] = np.eye(3), 0.5 * np.eye(3)
        expected = jacobian.T @ file_information @ jacobian
        found = factor.noiseModel().information()
        measured = factor.measured()
        worst["translation_m"] = max(worst["translation_m"],
                                     np.abs(measured.translation() - v[:3]).max())
        worst["rotation_rad"] = max(worst["rotation_rad"], np.linalg.norm(
            gtsam.Rot3.Logmap(measured.rotation().between(rotation))))
        worst["information"] = max(worst["information"],
                                   np.abs(found / np.diag(expected).max() -
                                          expected / np.diag(expected).max()).max())
    return {key: float(value) for key, value in worst.items()}


def print_times(name, keyframe_ms, loop_ms, eliminated, cost_ratio, ate_m):
    print(f"  {name:<22} {percentile(keyframe_ms, 0.5):8.3f} {percentile(keyframe_ms, 0.99):8.3f} "
          f"{percentile(loop_ms, 0.5):8.2f} {max(loop_ms):8.2f} {int(np.median(eliminated)):6d} "
          f"{max(eliminated):6d} {cost_ratio:11.6f} {ate_m:8.4f}")


def compare_speed(args, seed, noise):
    g2o, truth = args.out / f"graph_{seed}_{noise}.g2o", args.out / f"truth_{seed}_{noise}.g2o"
    ours = run_ours(args.program, ["--seed", seed, "--rotation-noise", noise, "--g2o", g2o,
                                   "--truth", truth])
    cost, ate = ours["cost"], ours["ate_m"]
    print(f"seed {seed}, {noise} rad/m; odometry alone {ate['odometry']:.3f} m\n"
          f"  {'':<22} {'kf p50':>8} {'p99 ms':>8} {'loop p50':>8} {'max ms':>8} {'elim':>6} "
          f"{'max':>6} {'cost/batch':>11} {'ATE m':>8}")
    loops = ours["loops"]
    print_times("ours, incremental", [u["ms"] for u in ours["keyframes"]],
                [u["ms"] for u in loops], [u["eliminated"] for u in loops],
                cost["incremental"] / cost["batch"], ate["incremental"])
    graph, true_poses = Graph(g2o), gtsam.readG2o(str(truth), True)[1]
    factors = graph.all_factors()
    summary = {"ours": ours, "gtsam": {}, "reader": check_reader(g2o)}
    for threshold in (0.1, 0.01):
        values, keyframe_ms, loop_ms, eliminated = run_isam2(graph, threshold)
        error, rmse = factors.error(values), aligned_rmse(values, true_poses)
        print_times(f"GTSAM iSAM2, {threshold}", keyframe_ms, loop_ms, eliminated,
                    error / cost["batch"], rmse)
        summary["gtsam"][str(threshold)] = {"cost": error, "ate_m": rmse, "keyframe_ms": keyframe_ms,
                                            "loop_ms": loop_ms, "eliminated": eliminated}
    values, ms = run_batch(graph)
    print(f"  batch: ours {ours['batch_ms']:.0f} ms in {ours['batch_iterations']} iterations, polish "
          f"{ours['polish_ms']:.0f} ms to {cost['polished'] / cost['batch']:.6f} of its cost; GTSAM "
          f"{ms:.0f} ms to {factors.error(values) / cost['batch']:.6f}")
    worst = summary["reader"]
    print(f"  g2o against GTSAM's reader: {worst['translation_m']:.1e} m, "
          f"{worst['rotation_rad']:.1e} rad, information {worst['information']:.1e}")
    return summary


def compare_robustness(args, seed, noise, share):
    false_loops = round(share / (1.0 - share) * args.loops)  # a share of all loops
    ours = run_ours(args.program, ["--seed", seed, "--rotation-noise", noise, "--loops", args.loops,
                                   "--false-loops", false_loops])
    clean = ours["clean"]["ate_m"]
    print(f"seed {seed}, {noise} rad/m, {false_loops} false loops to {args.loops} true ones; "
          f"clean {clean:.4f} m")
    for name, v in ours.items():
        if name != "clean":
            print(f"  {name:<24} ATE {v['ate_m']:9.4f} m = {v['ate_m'] / clean:8.2f} x clean, false "
                  f"kept {v['false_kept']:3d}, true lost {v['true_lost']:3d}, {v['ms']:7.0f} ms"
                  + (f", worst loop {v['loop_ms_max']:.1f} ms" if "loop_ms_max" in v else ""))
    return ours


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--program", default="build/dev/benchmarks/tvl_pose_graph_bench")
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--noise", default="2e-4,1e-3", help="rad a metre of odometry")
    parser.add_argument("--loops", type=int, default=300)
    parser.add_argument("--skip-robustness", action="store_true")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    summary = {"gtsam": gtsam.__version__ if hasattr(gtsam, "__version__") else "", "runs": []}
    for seed in map(int, args.seeds.split(",")):
        for noise in args.noise.split(","):
            run = {"seed": seed, "noise": noise, "speed": compare_speed(args, seed, noise)}
            if not args.skip_robustness:
                run["robustness"] = {share: compare_robustness(args, seed, noise, share)
                                     for share in (0.05, 0.2)}
            summary["runs"].append(run)
    (args.out / "pose_graph.json").write_text(json.dumps(summary, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
