"""tools/compare_training.py: its errors are those of simulated scores, and it calls nothing significant too often."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

SPEC = importlib.util.spec_from_file_location(
    "compare_training", Path(__file__).parents[2] / "tools" / "compare_training.py"
)
compare_training = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(compare_training)

PICTURES, COPIES, SEEDS = 20, 3, 4


def runs_of(scores):
    """`scores`: (runs, pictures, copies), the first copy as rendered."""
    return [
        [
            {"sample": str(COPIES * p + c), "seed": str(p), "composite": str(int(c > 0)), "iou": str(value)}
            for p, copies in enumerate(run)
            for c, value in enumerate(copies)
        ]
        for run in scores
    ]


def simulated(random, effect):
    """Two ways of training: errors of pictures that all runs share, of seeds, and of pictures in one of the two ways."""
    shared = random.normal(0.8, 0.1, (1, PICTURES, COPIES))
    way = [shared + random.normal(0, 0.03, (SEEDS, 1, 1)) + random.normal(0, 0.02, (1, PICTURES, 1)) for _ in range(2)]
    return runs_of(way[0] + effect), runs_of(way[1])


def test_errors_and_false_alarms():
    random, draws = np.random.default_rng(1), 400
    found = [compare_training.compare(*simulated(random, 0), "iou")[1:] for _ in range(draws)]
    difference, seeds, pictures, limit = np.array(found).T
    # Closed forms: each way's spread counts once.
    assert math.isclose(np.mean(seeds**2), 2 * 0.03**2 / SEEDS, rel_tol=0.15)
    assert math.isclose(np.mean(pictures**2), 2 * 0.02**2 / PICTURES, rel_tol=0.15)
    assert math.isclose(np.var(difference), 2 * 0.03**2 / SEEDS + 2 * 0.02**2 / PICTURES, rel_tol=0.25)
    # 5 % of false alarms, +- three standard errors; a little fewer, as pictures have more degrees of freedom than seeds
    assert 0.01 < np.mean(np.abs(difference) > limit) < 0.05 + 3 * math.sqrt(0.05 * 0.95 / draws)


def test_the_difference_is_with_minus_without():
    with_runs, without_runs = simulated(np.random.default_rng(2), 0.5)
    means, difference, _, _, limit = compare_training.compare(with_runs, without_runs, "iou")
    assert math.isclose(means[0] - means[1], difference, abs_tol=1e-12)
    assert difference > limit


def test_other_held_out_sets_are_refused():
    with_runs, without_runs = simulated(np.random.default_rng(3), 0)
    without_runs[1][0]["seed"] = "77"
    with pytest.raises(SystemExit, match="different held-out sets"):
        compare_training.compare(with_runs, without_runs, "iou")
    with_runs[1] = without_runs[1]  # the pair agrees, the pairs do not
    with pytest.raises(SystemExit, match="different held-out sets"):
        compare_training.compare(with_runs, without_runs, "iou")


def test_missing_and_too_few_scores_are_named(tmp_path):
    with pytest.raises(SystemExit, match="scores.csv: No such file"):
        compare_training.read(tmp_path)
    (tmp_path / "scores.csv").write_text("sample,seed,composite,iou\n0,7,0,.9\n1,7,1,.8\n")
    with pytest.raises(SystemExit, match="two pictures or more"):
        compare_training.read(tmp_path)
