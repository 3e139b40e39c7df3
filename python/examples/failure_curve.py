"""Render a capture, match it with a method of one's own, score it, and draw where it fails.

    python3 failure_curve.py SCENE.json CURVES.png

Needs dualpixel and matplotlib. Each part, between lines of "# %%", is a cell where an editor knows such cells.
"""

# %% Render
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import dualpixel

scene, page = sys.argv[1:3]
capture = dualpixel.simulate(
    scene,
    {
        "sensor.width_px": 672,
        "sensor.height_px": 504,
        "sensor.pixel_pitch_um": 5.6,
        "burst.frames": 1,
        "render.samples_per_pixel": 32,
        "render.photograph_samples_per_pixel": 1,
    },
    seed=1,
)


# %% Match: sums of squared differences over a window, and a parabola through the best shift and its neighbors
def box_mean(image, radius):
    """Mean over (2 radius + 1)^2 pixels; the border is repeated."""
    size = 2 * radius + 1
    padded = np.pad(image, radius + 1, mode="edge").cumsum(0).cumsum(1)
    return (padded[size:-1, size:-1] - padded[:-size - 1, size:-1] - padded[size:-1, :-size - 1]
            + padded[: -size - 1, : -size - 1]) / size**2


def shifted(image, d):
    """image(x + d) for a whole d; the border is repeated."""
    columns = np.clip(np.arange(image.shape[1]) + d, 0, image.shape[1] - 1)
    return image[:, columns]


def match(left, right, reach=4, radius=4):
    """Disparity d, with right(x + d) = left(x), and its standard deviation as far as a parabola tells it, in DP pixels."""
    left, right = (view / box_mean(view, 8 * radius) for view in (left.astype(float), right.astype(float)))
    shifts = np.arange(-reach, reach + 1)
    costs = np.stack([box_mean((shifted(right, d) - left) ** 2, radius) for d in shifts])
    best = np.clip(costs.argmin(0), 1, len(shifts) - 2)
    before, at, after = (np.take_along_axis(costs, best[None] + step, 0)[0] for step in (-1, 0, 1))
    curvature = np.maximum(before - 2 * at + after, 1e-12)
    disparity = shifts[best] + np.clip(0.5 * (before - after) / curvature, -0.5, 0.5)
    return disparity, np.sqrt(2 * at / curvature) / (2 * radius + 1)


disparity, sigma = match(capture.left, capture.right)

# %% Score, beside a matcher of the pipeline
found = {"mine": (disparity, sigma)}
likelihood = dualpixel.match(capture, matcher="likelihood")
found["likelihood"] = (likelihood.disparity, likelihood.sigma)
scores = {name: dualpixel.score(capture, disparity=d, sigma=s) for name, (d, s) in found.items()}
for name, score in scores.items():
    everything = score["disparity"]["everything"]
    print(f"{name}: RMSE {everything['rmse_px']:.3f} DP px, within one sigma {everything['within_one_sigma']:.2f}")

# %% Draw: error against defocus, and error of what remains when the least sure pixels are left out
below, right_of = capture.camera["dp_downsample_y"], capture.camera["dp_downsample_x"]
truth = capture.truth.disparity[below // 2 :: below, right_of // 2 :: right_of]
valid = capture.truth.valid[below // 2 :: below, right_of // 2 :: right_of] == 1
figure, (by_defocus, by_sigma) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
edges = np.linspace(truth[valid].min(), truth[valid].max(), 13)
for name, (d, _) in found.items():
    inside = [valid & (truth >= low) & (truth <= high) for low, high in zip(edges, edges[1:])]
    rmse = [np.sqrt(np.mean((d - truth)[i] ** 2)) if i.any() else np.nan for i in inside]
    by_defocus.plot((edges[1:] + edges[:-1]) / 2, rmse, "o-", label=name)
    curve = scores[name]["disparity"]["everything"]["sparsification"]
    by_sigma.plot(curve["removed"], curve["error_px"], label=name)
by_defocus.set(xlabel="true disparity, DP px (0: in focus)", ylabel="RMSE, DP px", ylim=(0, None))
by_sigma.set(xlabel="share of pixels left out, least sure first", ylabel="mean error, DP px", ylim=(0, None))
by_defocus.legend()
figure.savefig(page)
