#!/usr/bin/env python3
"""Checks the structure rules of CONTRIBUTING.md and prints the figures; exit code 1 if one is broken.

Needs Python 3 and git only.
"""

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from structure import functions, includes, sources, words  # noqa: E402

FUNCTION_LINES = 60        # hard limit ...
FUNCTION_SHARE = 0.03      # ... that this share may exceed
FILE_LINES = 500
TEST_RATIO = 0.4           # test lines to source lines
TEXT_SUFFIXES = (".h", ".cc", ".py", ".md", ".txt", ".cmake", ".json", ".yaml", ".yml", ".sh", "")


def line_count(text):
    return text.count("\n") + (not text.endswith("\n") and bool(text))


def percentile(values, share):
    """Nearest rank; 0 for no values."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else 0


def function_report(name, found):
    """Prints the lengths; returns errors."""
    lengths = [f.lines for f in found]
    long = sorted((f for f in found if f.lines > FUNCTION_LINES), key=lambda f: -f.lines)
    share = len(long) / len(found) if found else 0.0
    print(f"functions, {name:<8} {len(found):5d}   lines: median {percentile(lengths, 0.5)}, "
          f"p90 {percentile(lengths, 0.9)}, longest {max(lengths, default=0)}, "
          f"> 30: {100 * sum(x > 30 for x in lengths) / max(1, len(found)):.1f} %, "
          f"> {FUNCTION_LINES}: {len(long)} ({100 * share:.1f} %, limit {100 * FUNCTION_SHARE:.0f} %)")
    for f in long:
        print(f"    {f.lines:4d} lines  {f.path}:{f.line} {f.name}")
    if share > FUNCTION_SHARE:
        return [f"{100 * share:.1f} % of the {name} functions exceed {FUNCTION_LINES} lines"]
    return []


def size_report(texts):
    """Prints file sizes and the test ratio of C++ files; returns errors."""
    lines = {path: line_count(text) for path, text in texts.items()}
    source = {p: n for p, n in lines.items() if not sources.is_test(p)}
    test = {p: n for p, n in lines.items() if sources.is_test(p)}
    for name, group in (("source", source), ("test", test)):
        values = list(group.values())
        print(f"files, {name:<12} {len(group):5d}   lines: {sum(values)} in all, median "
              f"{percentile(values, 0.5)}, p90 {percentile(values, 0.9)}, "
              f"longest {max(values, default=0)} (limit {FILE_LINES})")
    ratio = sum(test.values()) / max(1, sum(source.values()))
    print(f"test lines to source lines  {ratio:.2f} (at least {TEST_RATIO})")
    errors = [f"{p}: {n} lines (limit {FILE_LINES})" for p, n in lines.items() if n > FILE_LINES]
    if ratio < TEST_RATIO:
        errors.append(f"test lines to source lines {ratio:.2f} < {TEST_RATIO}")
    return errors


def include_report(texts):
    """Prints the include graph's figures; returns errors."""
    file_graph, folder_graph = includes.graphs(texts, sources.is_test)
    file_cycles, folder_cycles = includes.cycles(file_graph), includes.cycles(folder_graph)
    wrong = includes.direction_errors(texts, sources.is_test)
    print(f"includes                    {sum(map(len, file_graph.values()))} edges between "
          f"{len(file_graph)} files in {len(folder_graph)} folders; cycles between files "
          f"{len(file_cycles)}, between folders {len(folder_cycles)}; wrong direction {len(wrong)}")
    return wrong + ["include cycle: " + " -> ".join(c) for c in file_cycles + folder_cycles]


def word_report(root, files):
    errors, count = [], 0
    for path in files:
        if pathlib.PurePath(path).suffix in TEXT_SUFFIXES:
            count += 1
            errors += words.errors(path, sources.read(root, path))
    print(f"forbidden words             {len(errors)} in {count} text files")
    return errors


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", default=pathlib.Path(__file__).resolve().parent.parent)
    root = pathlib.Path(parser.parse_args().root)
    files = sources.list_files(root)
    texts = {path: sources.read(root, path) for path in sources.cpp_files(files)}
    found = [f for path, text in texts.items() for f in functions.functions(path, text)]
    errors = function_report("source", [f for f in found if not sources.is_test(f.path)])
    errors += function_report("test", [f for f in found if sources.is_test(f.path)])
    errors += size_report(texts)
    errors += include_report(texts)
    errors += word_report(root, files)
    for error in errors:
        print(f"error: {error}")
    print("structure: " + ("BROKEN" if errors else "ok"))
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
