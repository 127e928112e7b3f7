#!/usr/bin/env python3
"""The shipped visual vocabulary beside one trained on real KITTI images.

    vocabulary.py [DRIVE...] --out DIR [--binary tvl] [--stride N] [--repeat N]

Trains a second vocabulary on $TVL_TEST_DATA/vocabulary_images (its licence forbids shipping it) and
prints the recall at 100 % precision of both
  - on simulated drives: DRIVE is a folder written by `tvl simulate`, with a seed that the shipped
    one was not trained on. Positive: a revisit (within 10 m and 45 deg, > 30 s and > 50 m of path
    later); an image counts as found when its best earlier image is within 10 m and more alike than
    any image's best one that is not;
  - on real images neither was trained on: frames of one sequence 2, 3 and 5 apart against all those
    25 or more apart and those of the other sequence (`first`: against those of the same image);
and the time of a query over all images of the first drive, --repeat times over.
"""

import argparse
import os
import pathlib
import subprocess

import numpy as np

GAPS = (2, 3, 5)
FAR_FRAMES = 25
REAL = ("kitti360_3000", "kitti_2011_09_26_0052")


def run(binary, *arguments):
    subprocess.run([binary, "vocabulary", *map(str, arguments)], check=True)


def compare(args, images, name, vocabularies, *options):
    """{vocabulary: {(image, earlier): similarity}}"""
    tables = {v: args.out / f"{name}_{v}.csv" for v in vocabularies}
    pairs = [word for v, file in vocabularies.items()
             for word in ("--vocabulary", file, "--out", tables[v])]
    run(args.binary, "compare", *images, *pairs, *options)
    loaded = {v: np.loadtxt(t, delimiter=",", skiprows=1) for v, t in tables.items()}
    return {v: matrix(rows) for v, rows in loaded.items()}


def matrix(rows):
    """Similarity of each image (row) to each earlier one (column); 0 where nothing is shared."""
    size = int(rows[:, 0].max()) + 1
    table = np.zeros((size, size))
    table[rows[:, 0].astype(int), rows[:, 1].astype(int)] = rows[:, 2]
    return table


def recall_at_full_precision(best_score, is_right, is_positive):
    """Share of the positives found when the threshold lets no wrong one pass."""
    threshold = best_score[~is_right].max(initial=0.0)
    return (is_right & is_positive & (best_score > threshold)).sum() / max(1, is_positive.sum())


def drive_recall(similarity, poses, times_s):
    """Recall on a drive; similarity is cut to the images that lie far enough back."""
    position, forward = poses[:, :, 3], poses[:, :, 2]
    path_m = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1))])
    distance_m = np.linalg.norm(position[:, None] - position[None], axis=2)
    old = ((times_s[:, None] - times_s[None] > 30.0) & (path_m[:, None] - path_m[None] > 50.0))
    same = old & (distance_m < 10.0) & (forward @ forward.T > np.cos(np.pi / 4))
    allowed = np.where(old, similarity, 0.0)
    best = allowed.argmax(axis=1)
    rows = np.arange(len(best))
    is_right = same[rows, best] | (allowed.max(axis=1) == 0.0)
    return recall_at_full_precision(allowed.max(axis=1), is_right, same.any(axis=1)), same.any(axis=1).sum()


def real_recall(similarity, lengths, gap):
    """For pairs `gap` frames apart: the share more alike than every far pair, and the share more
    alike than the far pairs of the same image."""
    start = np.repeat(np.cumsum([0, *lengths[:-1]]), lengths)
    image = np.arange(len(start))
    query = np.array([i for i in image if i - gap >= start[i] and i > FAR_FRAMES])
    right = similarity[query, query - gap]
    far = (start[:, None] != start[None]) | (image[:, None] - image[None] >= FAR_FRAMES)
    far &= image[:, None] > image[None]
    # The first image of a sequence has no predecessor to be measured by.
    far[image == start] = False
    wrong = np.where(far, similarity, 0.0)
    return np.mean(right > wrong.max()), np.mean(right > wrong[query].max(axis=1))


def read_drive(drive, stride):
    poses = np.loadtxt(drive / "poses.txt").reshape(-1, 3, 4)[::stride]
    return poses, np.loadtxt(drive / "times.txt")[::stride]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", nargs="*", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binary", default="tvl")
    parser.add_argument("--stride", type=int, default=1)
    parser.add_argument("--repeat", type=int, default=1)
    args = parser.parse_args()
    data = pathlib.Path(os.environ["TVL_TEST_DATA"])
    args.out.mkdir(parents=True, exist_ok=True)

    trained = args.out / "kitti.bin"
    run(args.binary, "train", data / "vocabulary_images", "--out", trained)
    vocabularies = {"shipped": "default", "kitti": trained}

    rows = []
    for i, drive in enumerate(args.drives):
        repeat = ["--repeat", args.repeat] if i == 0 else []
        tables = compare(args, [drive / "image_0"], drive.name, vocabularies,
                         "--stride", args.stride, *repeat)
        for name, table in tables.items():
            recall, positives = drive_recall(table, *read_drive(drive, args.stride))
            rows.append((f"{drive.name} ({positives} revisits)", name, f"{recall:.2f}"))
    folders = [data / "sequences" / name / "image_2" for name in REAL]
    lengths = [len(list(folder.glob("*.png"))) for folder in folders]
    for name, table in compare(args, folders, "real", vocabularies).items():
        for gap in GAPS:
            recall, first = real_recall(table, lengths, gap)
            rows.append((f"real, {gap} frames apart", name, f"{recall:.2f}  first {first:.2f}"))
    for what, name, figures in sorted(rows):
        print(f"{what:<32} {name:<8} recall at 100 % precision {figures}")


if __name__ == "__main__":
    main()
