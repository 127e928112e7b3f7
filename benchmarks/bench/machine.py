"""What a measurement was made with: commit, program, processor, packages."""

import datetime
import hashlib
import importlib.metadata
import os
import pathlib
import platform
import subprocess

from . import ours

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = ("kiss-icp", "genz-icp", "small-gicp", "kiss-slam", "map_closures", "numpy", "scipy")


def _git(*arguments):
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True,
                          check=False)
    return done.stdout.strip() if done.returncode == 0 else None


def checkout():
    """Commit of this checkout; dirty if files that git follows differ from it."""
    changed = _git("status", "--porcelain", "--untracked-files=no")
    return {"commit": _git("rev-parse", "HEAD"), "dirty": None if changed is None else bool(changed)}


def cpu_model():
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def machine():
    return {"cpu": cpu_model(), "cores": os.cpu_count(), "system": platform.platform(),
            "load_average": os.getloadavg()}


def digest(path):
    """Tells one build of the program from another."""
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()[:16]


def program(binary):
    return {"version": ours.execute(binary, "--version").strip(), "sha256": digest(binary)}


def version(package):
    """None of what is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def packages():
    return {name: version(name) for name in PACKAGES}


def now():
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
