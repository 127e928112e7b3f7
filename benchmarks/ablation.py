#!/usr/bin/env python3
"""What each part of the odometry is worth: options left out or changed, one at a time.

    benchmarks/ablation.py --out DIR --binary tvl                    # all variants on all scenes
    benchmarks/ablation.py --out DIR --scenes beams-sine --variants default,no-beam-calibration
    benchmarks/ablation.py --out DIR --resume --update-docs          # the tables of docs/evaluation.md

Simulated drives that nothing was tuned on, written once to DIR/drives, some with beam errors of
another size or shape than the program assumes; and real recordings of TVL_TEST_DATA. One thread,
`--no-loops`, one run at a time. Writes DIR/ablation.json (figures of every run, what they were made
with) and DIR/ablation.md. Runs are kept in DIR/runs; --resume takes those made of the same scans,
program and options. Exit code 1 if a run failed. docs/evaluation.md says what the figures mean.
"""

import argparse
import json
import os
import pathlib
import sys

from bench import ablation, ablation_tables, accuracy_tables, machine, ours

DOCUMENT = pathlib.Path(__file__).resolve().parents[1] / "docs/evaluation.md"


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True,
                        help="folder for drives, runs and results")
    parser.add_argument("--binary", type=pathlib.Path, default=ours.DEFAULT_BINARY,
                        help="the program tvl; default: build/release/tvl")
    parser.add_argument("--binary-commit", help="what it was built from, if not from this checkout")
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get("TVL_TEST_DATA"),
                        help="folder with sequences/ and trajectories/; default: TVL_TEST_DATA")
    parser.add_argument("--variants", help=f"default: all of {', '.join(ablation.VARIANTS)}")
    parser.add_argument("--scenes", help=f"default: all of {', '.join(ablation.SCENES)}")
    parser.add_argument("--resume", action="store_true", help="do not repeat what is done")
    parser.add_argument("--update-docs", action="store_true",
                        help="write the tables into docs/evaluation.md")
    args = parser.parse_args(arguments)
    for name, known in (("variants", ablation.VARIANTS), ("scenes", ablation.SCENES)):
        chosen = getattr(args, name)
        chosen = list(known) if chosen is None else chosen.split(",")
        unknown = [key for key in chosen if key not in known]
        if unknown:
            parser.error(f"--{name}: no {unknown[0]}, there are {', '.join(known)}")
        setattr(args, name, chosen)
    args.out, args.binary = args.out.resolve(), args.binary.resolve()
    args.data = None if args.data is None else pathlib.Path(args.data)
    return args


def with_data(args):
    """The scenes that can be made; of the others it is said what is missing."""
    if args.data is not None:
        return args.scenes
    scenes = [name for name in args.scenes
              if ablation.SCENES[name].is_simulated and ablation.SCENES[name].trajectory is None]
    if scenes != args.scenes:
        print("notice: real recordings and recorded ways are left out: set TVL_TEST_DATA")
    return scenes


def main(arguments=None):
    args = parse(arguments)
    args.out.mkdir(parents=True, exist_ok=True)
    binary = machine.program(args.binary) | {"commit": args.binary_commit}
    made = {"date": machine.now(), "command": " ".join(sys.argv), "checkout": machine.checkout(),
            "binary": binary, "machine": machine.machine(), "packages": machine.packages()}
    result = {"made": made, "scenes": [ablation.measure_scene(args, name, args.variants)
                                       for name in with_data(args)]}
    (args.out / "ablation.json").write_text(json.dumps(result, indent=1) + "\n")
    tables = ablation_tables.markdown(result)
    (args.out / "ablation.md").write_text(tables)
    print(tables)
    if args.update_docs:
        markers = (ablation_tables.BEGIN, ablation_tables.END)
        DOCUMENT.write_text(accuracy_tables.replaced(DOCUMENT.read_text(), tables, markers))
    failed = any("error" in run for scene in result["scenes"] for run in scene["runs"])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
