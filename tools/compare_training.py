#!/usr/bin/env python3
"""Says whether two ways of training differ: compares runs of dualpixel_train in pairs, sample by sample.

    tools/compare_training.py --with out/all_1 out/all_2 out/all_3 --without out/no_pose_1 out/no_pose_2 out/no_pose_3

The n-th run of one list belongs to the n-th of the other: both of the same seed, budget and held-out set. Printed are,
from the runs' scores.csv, of all samples, of those as rendered and of composites: each list's mean, the mean difference
(with minus without), and its two standard errors: over seeds (of the differences of the runs' means) and over pictures
(of the samples' differences, means over runs; a picture and its composites count as one). Their squares are added. A
difference is called significant beyond the limit: the sum's root times Student's t at 95 % with the seeds' degrees of
freedom.
"""

import argparse
import csv
import math
import statistics

# Student's t, two-sided, 95 %, for 1 to 10 degrees of freedom; more count as 10.
T95 = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228]
SCORES = ("iou", "gradient_error")
PARTS = {"all": ("0", "1"), "as rendered": ("0",), "composites": ("1",)}


def read(folder):
    try:
        with open(f"{folder}/scores.csv", newline="") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        raise SystemExit(f"compare_training.py: {error.filename}: {error.strerror}")
    if len({row["seed"] for row in rows}) < 2:
        raise SystemExit(f"compare_training.py: {folder}/scores.csv: must hold two pictures or more")
    return rows


def standard_error(values):
    return statistics.stdev(values) / math.sqrt(len(values))


def error_of_mean_over_clusters(values, clusters):
    """Of the mean of all values, where those of one cluster belong together."""
    mean = statistics.fmean(values)
    sums = {}
    for value, cluster in zip(values, clusters):
        sums[cluster] = sums.get(cluster, 0) + value - mean
    n = len(sums)
    return math.sqrt(sum(s * s for s in sums.values()) * n / (n - 1)) / len(values)


def compare(with_runs, without_runs, score):
    """The means of both, their difference, its standard errors over seeds and pictures, and the limit beyond which it
    counts. Runs are lists of rows; those of one index are a pair."""
    held_out = [[(row["sample"], row["seed"]) for row in run] for run in (*with_runs, *without_runs)]
    if any(samples != held_out[0] for samples in held_out):
        raise SystemExit("compare_training.py: the runs were scored on different held-out sets")
    differences = [[float(x[score]) - float(y[score]) for x, y in zip(a, b)] for a, b in zip(with_runs, without_runs)]
    of_samples = [statistics.fmean(values) for values in zip(*differences)]
    seeds = standard_error([statistics.fmean(d) for d in differences])
    pictures = error_of_mean_over_clusters(of_samples, [row["seed"] for row in with_runs[0]])
    means = [statistics.fmean(statistics.fmean(float(row[score]) for row in run) for run in runs)
             for runs in (with_runs, without_runs)]
    limit = T95[min(len(differences) - 1, len(T95)) - 1] * math.hypot(seeds, pictures)
    return means, statistics.fmean(of_samples), seeds, pictures, limit


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--with", dest="with_runs", nargs="+", required=True, metavar="RUN")
    parser.add_argument("--without", dest="without_runs", nargs="+", required=True, metavar="RUN")
    arguments = parser.parse_args()
    if len(arguments.with_runs) != len(arguments.without_runs) or len(arguments.with_runs) < 2:
        parser.error("--with and --without need as many runs each, two at least")
    runs = [[read(folder) for folder in folders] for folders in (arguments.with_runs, arguments.without_runs)]
    print("score           samples        with without   differ   seeds pictures   limit")
    for score in SCORES:
        for part, wanted in PARTS.items():
            if not any(row["composite"] in wanted for row in runs[0][0]):
                continue
            chosen = [[[row for row in run if row["composite"] in wanted] for run in several] for several in runs]
            means, difference, seeds, pictures, limit = compare(*chosen, score)
            verdict = " significant" if abs(difference) > limit else ""
            print(f"{score:15s} {part:11s} {means[0]:7.5f} {means[1]:7.5f} {difference:+8.5f} {seeds:7.5f} "
                  f"{pictures:8.5f} {limit:7.5f}{verdict}")


if __name__ == "__main__":
    main()
