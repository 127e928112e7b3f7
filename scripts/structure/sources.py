"""Which files there are, and what counts as a test."""

import pathlib
import re
import subprocess

CPP_ROOTS = ("src", "tests", "examples")
TEST_NAME = re.compile(r"(_test|_matchers|_testing|/test_\w+|/temp_folder)\.(h|cc)$")


def list_files(root):
    """Paths relative to root of the files git tracks or would track, sorted."""
    out = subprocess.run(
        ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        check=True, capture_output=True).stdout.decode()
    return sorted(p for p in out.split("\0") if p and (pathlib.Path(root) / p).is_file())


def cpp_files(files):
    return [f for f in files if f.endswith((".h", ".cc")) and f.split("/")[0] in CPP_ROOTS]


def is_test(path):
    """Unit tests lie beside the code and are told by name; tests/ holds nothing else."""
    return bool(TEST_NAME.search(path)) or path.startswith("tests/")


def read(root, path):
    return (pathlib.Path(root) / path).read_text(encoding="utf-8", errors="replace")
