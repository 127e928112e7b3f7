"""KISS-SLAM, a peer that closes loops: KISS-ICP, local maps of 100 m, closures between them.

One frame after the other through its own class, with its default configuration and its own order of
work: a local map that is full is searched for a closure in line, and at the end all frames are
optimised once more, as its pipeline does.
"""

import concurrent.futures
import contextlib
import dataclasses
import importlib.metadata
import io
import multiprocessing
import os
import time

import numpy as np

from . import clouds
from .closures import Closure, Stretch

PACKAGE = "kiss-slam"


@dataclasses.dataclass(frozen=True)
class Result:
    T_world_lidar: np.ndarray    # optimised
    T_odom_lidar: np.ndarray     # the same run as its odometry alone has it
    stretches: list              # its local maps
    closures: list
    ms: np.ndarray               # a frame, wall
    end_s: float                 # the last map and the final optimisation
    cpu_ms: float                # a frame, of all its threads, with the end
    memory_mib: float            # peak
    loaded_mib: float            # of it, before the first scan: Python and its libraries


def version():
    return importlib.metadata.version(PACKAGE)


class KissSlam:
    def __init__(self, threads, deskew):
        from kiss_slam.config import load_config
        from kiss_slam.slam import KissSLAM
        config = load_config(None)
        config.odometry.preprocessing.deskew = deskew
        config.odometry.registration.max_num_threads = threads
        self._slam = KissSLAM(config)
        self._frames, self._firsts, self._closures = 0, [0], []
        self._compute = self._slam.closer.compute
        self._slam.closer.compute = self._recorded

    def _recorded(self, query_id, points, graph):
        """Its search; the transform of what it accepts is not kept by the class itself."""
        is_good, reference, query, T_query_reference = self._compute(query_id, points, graph)
        if is_good:
            self._closures.append(Closure(int(query), int(reference), np.array(T_query_reference)))
        return is_good, reference, query, T_query_reference

    def register(self, points, share):
        self._slam.process_scan(points, np.zeros(0) if share is None else share)
        if len(self._slam.get_keyposes()) > len(self._firsts):
            self._firsts.append(self._frames)  # a full map ends with the frame the next begins with
        self._frames += 1

    def finish(self):
        """(optimised poses, poses without loops, local maps, closures)."""
        self._slam.generate_new_node()
        self._slam.local_map_graph.erase_last_local_map()
        optimised, _ = self._slam.fine_grained_optimization()
        local = [np.array(m.local_trajectory) for m in self._slam.local_map_graph.local_maps()]
        stretches = [Stretch(first, poses) for first, poses in zip(self._firsts, local)]
        return np.array(optimised), chained(local), stretches, self._closures


def chained(local):
    """Poses of all frames from those of the stretches; each begins with the last frame before."""
    world, start = [], np.eye(4)
    for number, poses in enumerate(local):
        world.extend(start @ poses[min(number, 1):])
        start = start @ poses[-1]
    return np.array(world)


def _peak_mib():
    """Of this process since it began; getrusage would count the parent's before exec."""
    with open("/proc/self/status", encoding="ascii") as status:
        line = next(line for line in status if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def _work(files, correction_deg, threads, spin):
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # its optimiser reports each iteration
    with contextlib.redirect_stdout(io.StringIO()):
        slam = KissSlam(threads, deskew=spin is not None)
        loaded_mib, ms, cpu_s = _peak_mib(), [], 0.0
        for path in files:
            points, share = clouds.for_peer(path, correction_deg, spin)
            start, cpu_start = time.perf_counter(), time.process_time()
            slam.register(points, share)
            ms.append(1e3 * (time.perf_counter() - start))
            cpu_s += time.process_time() - cpu_start
        start, cpu_start = time.perf_counter(), time.process_time()
        found = slam.finish()
        end_s = time.perf_counter() - start
        cpu_s += time.process_time() - cpu_start
    return Result(*found, np.array(ms), end_s, 1e3 * cpu_s / len(files), _peak_mib(), loaded_mib)


def run(files, correction_deg, threads, spin=None):
    """In a process of its own, for its memory to be its own. Reading scans is not counted in times."""
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(_work, files, correction_deg, threads, spin).result()
