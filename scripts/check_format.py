#!/usr/bin/env python3
"""Runs clang-format over the C++ files without changing them (--fix changes them).

The style is that of version 14 (Debian 12); other versions lay out a few things differently, so
with them a difference is only a warning.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from structure import sources  # noqa: E402

VERSION = 14


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fix", action="store_true")
    fix = parser.parse_args().fix
    root = pathlib.Path(__file__).resolve().parent.parent
    tool = shutil.which(f"clang-format-{VERSION}") or shutil.which("clang-format")
    if tool is None:
        print("error: clang-format is not installed")
        return 1
    said = subprocess.run([tool, "--version"], check=True, capture_output=True, text=True).stdout
    version = int(re.search(r"version (\d+)", said).group(1))
    files = sources.cpp_files(sources.list_files(root))
    if not files:
        return 0
    mode = ["-i"] if fix else ["--dry-run", "-Werror"]
    result = subprocess.run([tool, *mode, *files], cwd=root, check=False, capture_output=True, text=True)
    good = result.returncode == 0
    for path in sorted({line.split(":")[0] for line in result.stderr.split("\n") if ": error:" in line}):
        print(f"    {path}")
    print(f"clang-format {version}: {len(files)} files, "
          + ("ok" if good else "differences; run scripts/check_format.py --fix"))
    if not good and version != VERSION:
        print(f"warning: the style is pinned to version {VERSION}; not counted as a failure")
        return 0
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
