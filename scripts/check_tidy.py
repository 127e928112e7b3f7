#!/usr/bin/env python3
"""Runs clang-tidy over the sources, the most recently changed first, within a time budget.

Files that the budget leaves out are counted and named as such: they are the ones that have gone
longest without a change. Without --budget-s every file is checked.
"""

import argparse
import concurrent.futures
import json
import pathlib
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from structure import sources  # noqa: E402


def recent_first(root, files):
    """Files by the time of their last commit, newest first; uncommitted ones before all."""
    log = subprocess.run(["git", "-C", str(root), "log", "--format=%x00", "--name-only"],
                         check=True, capture_output=True, text=True).stdout
    order = {}
    for position, name in enumerate(log.split("\n")):
        order.setdefault(name, position)
    return sorted(files, key=lambda f: (order.get(f, -1), f))


def compiled_sources(root, build):
    """Sources (no tests) that the build compiles."""
    entries = json.loads((build / "compile_commands.json").read_text())
    known = {str(pathlib.Path(e["directory"], e["file"]).resolve()) for e in entries}
    files = sources.cpp_files(sources.list_files(root))
    return [f for f in files if str(root / f) in known and not sources.is_test(f)]


def lint(tool, root, build, path, deadline):
    """Result of one file; None if the budget ran out before it started."""
    if deadline is not None and time.monotonic() > deadline:
        return None
    return subprocess.run([tool, "-p", str(build), "--quiet", "--warnings-as-errors=*", path],
                          cwd=root, check=False, capture_output=True, text=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", required=True, help="build folder with compile_commands.json")
    parser.add_argument("--budget-s", type=float, default=None)
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    root = pathlib.Path(__file__).resolve().parent.parent
    build = (root / args.build).resolve()
    tool = shutil.which("clang-tidy")
    if tool is None:
        print("error: clang-tidy is not installed")
        return 1
    files = recent_first(root, compiled_sources(root, build))
    start = time.monotonic()
    deadline = None if args.budget_s is None else start + args.budget_s
    bad, left = [], 0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        path_of = {pool.submit(lint, tool, root, build, f, deadline): f for f in files}
        for done in concurrent.futures.as_completed(path_of):
            result = done.result()
            if result is None:
                left += 1
            elif result.returncode != 0:
                bad.append(path_of[done])
                # At once: a log that is cut still names the finding.
                print(result.stdout.strip() or result.stderr.strip(), flush=True)
    print(f"clang-tidy: {len(files) - left} of {len(files)} sources in {time.monotonic() - start:.0f} s, "
          f"{len(bad)} with findings" + (": " + ", ".join(sorted(bad)) if bad else "")
          + (f"; {left} left out by the time budget" if left else ""))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
