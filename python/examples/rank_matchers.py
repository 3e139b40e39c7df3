"""Rank ways of matching on real pairs and on rendered ones: is the order the same? (docs/disparity.md, "On rendered scenes")

    python3 rank_matchers.py PROGRAM WORK --rendered                 # six drawn scenes through a phone; an hour, unless WORK has them
    python3 rank_matchers.py PROGRAM WORK --pixel4 DP_data_pixel_4   # the pairs of Xin et al. 2021, as their authors publish them

Needs dualpixel and OpenCV. PROGRAM is build/release/tools/dualpixel; it smooths what every method finds. In WORK are kept the
captures and what was found, so that a second run goes on where the first one was stopped. Errors are those of
Garg et al. 2019 after an affine fit to the truth, which both kinds of pairs have.
"""

# %% Options
import argparse
import json
import subprocess
from pathlib import Path

import cv2
import numpy as np

import dualpixel
from dualpixel.pictures import read_exr
from dualpixel.reader import Capture

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("program")
parser.add_argument("work", type=Path)
parser.add_argument("--pixel4", type=Path)
parser.add_argument("--rendered", action="store_true")
parser.add_argument("--methods", help="names, separated by commas; all")
parser.add_argument("--size", type=int, default=2688, help="photosites across a rendered picture; 2688")
options = parser.parse_args()
DETAIL_PX, SHADING_PX, WINDOW_PX = 6, 20, 12  # of the views: low-pass, high-pass, and the window of a comparison
STEP = 4  # a quarter of the size
RANGE_PX = 16


# %% The pipeline's own
def portrait(views, *arguments):
    """The smoothed disparity, DP px, by the program."""
    folder = options.work / "pair"
    folder.mkdir(exist_ok=True)
    for name, view in zip(("left.png", "right.png"), views):
        cv2.imwrite(str(folder / name), np.clip(np.rint(65535 * view), 0, 65535).astype(np.uint16))
    (folder / "pair.json").write_text('{"encoding": "linear"}')
    files = ["--left", folder / "left.png", "--right", folder / "right.png", "--metadata", folder / "pair.json"]
    subprocess.run([options.program, "portrait", *files, "--mode", "dp", *arguments, "-o", folder / "result"],
                   check=True, capture_output=True)
    return read_exr(folder / "result/maps.exr")["disparity_dp_px"]


def smoothed(views, disparity, **by):
    """by: sigma or confidence."""
    arguments = []
    for name, values in dict(by, disparity=disparity).items():
        path = options.work / f"{name}.npy"
        np.save(path, values.astype(np.float32))
        arguments += [f"--{name}", path]
    return portrait(views, *arguments)


def by_matcher(name):
    return lambda *views: portrait(views, "--matcher", name)


# %% The likelihood matcher on smaller views
def low_pass(view, sigma_px):
    return cv2.GaussianBlur(view, (0, 0), sigma_px, borderType=cv2.BORDER_REFLECT_101) if sigma_px else view


def shrunk(view, by):
    return cv2.resize(view, None, fx=1 / by, fy=1 / by, interpolation=cv2.INTER_AREA) if by > 1 else view


def grown(values, like):
    return cv2.resize(values.astype(np.float32), like.shape[::-1], interpolation=cv2.INTER_LINEAR)


def likelihood_at(views, by, before_px=0, after_px=0):
    """Disparity and sigma, DP px of `views`, with a low-pass before and after these are made smaller."""
    small = [low_pass(shrunk(low_pass(view, before_px), by), after_px) for view in views]
    small = [view[: view.shape[0] // 2 * 2, : view.shape[1] // 2 * 2] for view in small]
    found = dualpixel.match(*small, matcher="likelihood")
    return [by * grown(map_, views[0]) for map_ in (found.disparity, found.sigma)]


def averaged(*views):
    disparity, sigma = likelihood_at(views, STEP)
    return smoothed(views, disparity, sigma=sigma)


def low_passed(*views):
    disparity, sigma = likelihood_at(views, STEP, before_px=DETAIL_PX)
    return smoothed(views, disparity, sigma=sigma)


def pyramid(*views):
    """A: at 1/8, 1/4, 1/2 and 1/1, each after a low-pass of 1.5 of its pixels, weighted by the inverse variance."""
    levels = [likelihood_at(views, by, after_px=1.5) for by in (8, 4, 2, 1)]
    weights = [1 / np.maximum(sigma, 1e-3) ** 2 for _, sigma in levels]
    disparity = sum(weight * found for weight, (found, _) in zip(weights, levels)) / sum(weights)
    return smoothed(views, disparity, sigma=sum(weights) ** -0.5)


# %% Squared differences of a band of low frequencies
def bands(views):
    """At a quarter of the size, without detail and shading, divided by the contrast around."""
    small = [shrunk(low_pass(view, DETAIL_PX), STEP) for view in views]
    small = [view / np.maximum(low_pass(view, SHADING_PX / STEP), 1e-6) - 1 for view in small]
    contrast = np.sqrt(low_pass(sum(view**2 for view in small), 2 * SHADING_PX / STEP)) + 1e-4
    return [view / contrast for view in small]


def cheapest(views, shifts, costs):
    """By a parabola through the least cost and its neighbors; trusted the more, the more curved it is."""
    costs = np.stack([low_pass(cost.astype(np.float32), WINDOW_PX / STEP) for cost in costs])
    best = np.clip(costs.argmin(0), 1, len(shifts) - 2)
    before, at, after = (np.take_along_axis(costs, best[None] + i, 0)[0] for i in (-1, 0, 1))
    curvature = np.maximum(before - 2 * at + after, 1e-9)
    step = shifts[1] - shifts[0]
    disparity = shifts[best] + step * np.clip((before - after) / 2 / curvature, -0.5, 0.5)
    confidence = curvature / (curvature + np.median(curvature))
    return smoothed(views, grown(disparity, views[0]), confidence=grown(confidence, views[0]))


def mirrored(view, pad):
    return np.fft.rfft2(np.pad(view, pad, mode="reflect"))


def shifts_of_a_band(*views):
    """B: the views shifted against each other."""
    pad = 2 * RANGE_PX // STEP
    left, right = (mirrored(view, pad) for view in bands(views))
    shape = [n + 2 * pad for n in bands(views)[0].shape]
    waves = 2j * np.pi * np.fft.rfftfreq(shape[1])
    shifts = np.arange(-RANGE_PX, RANGE_PX + 0.1, 0.5)
    costs = []
    for d in shifts / STEP:
        apart = left * np.exp(-waves * d / 2) - right * np.exp(waves * d / 2)
        costs.append(np.fft.irfft2(apart, shape)[pad:-pad, pad:-pad] ** 2)
    return cheapest(views, shifts, costs)


def ramp_kernels(disparity, alpha, steps=8):
    """Of the left and the right view, pixels of a quarter: discs weighted by a ramp, whose centroids lie `disparity` apart."""
    radius = max(abs(disparity) / alpha / 2, 0.5)
    reach = int(np.ceil(radius)) + 1
    points = np.arange(-reach, reach + 1)[:, None] + (np.arange(steps) + 0.5) / steps - 0.5
    x, y = np.meshgrid(points.ravel(), points.ravel())
    ramp = np.clip(4 * alpha * x / radius, -1, 1) * np.sign(disparity)
    halves = [(x * x + y * y <= radius**2) * (1 + side * ramp) for side in (-1, 1)]
    size = 2 * reach + 1
    halves = [half.reshape(size, steps, size, steps).sum((1, 3)) for half in halves]
    return [half / half.sum() for half in halves]


def kernels_of_a_band(*views, alpha=0.21):
    """C: the left view through the right one's kernel against the right view through the left one's, whitened."""
    pad = 24
    left, right = (mirrored(view, pad) for view in bands(views))
    shape = [n + 2 * pad for n in bands(views)[0].shape]
    shifts = np.arange(-RANGE_PX, RANGE_PX + 1.0)
    costs = []
    for d in shifts / STEP:
        spectra = []
        for kernel in ramp_kernels(d, alpha):
            whole = np.zeros(shape)
            whole[: len(kernel), : len(kernel)] = kernel
            spectra.append(np.fft.rfft2(np.roll(whole, -(len(kernel) // 2), (0, 1))))
        power = abs(spectra[0]) ** 2 + abs(spectra[1]) ** 2 + 1e-3
        apart = (spectra[1] * left - spectra[0] * right) / np.sqrt(power)
        costs.append(np.fft.irfft2(apart, shape)[pad:-pad, pad:-pad] ** 2)
    return cheapest(views, shifts, costs)


METHODS = {"paper": by_matcher("paper"), "likelihood": by_matcher("likelihood"), "averaged by 4": averaged,
           "low-passed quarter": low_passed, "A": pyramid, "B": shifts_of_a_band, "C": kernels_of_a_band,
           "split": by_matcher("split")}

# %% Pairs with a truth
CLOSE_UPS = {  # `dualpixel scene KIND --seed N --set ...`, focused before everything
    "still_life_304": ["light=window", "distance_m=0.25", "camera.focus_distance_m=0.13"],
    "portrait_201": ["people=1", "place=garden", "light=sun", "distance_m=0.8", "camera.focus_distance_m=0.15"],
    "still_life_301": ["light=window", "distance_m=0.35", "camera.focus_distance_m=0.15"],
    "outdoors_12": ["light=sun", "camera.focus_distance_m=0.14"],
    "room_7": ["camera.focus_distance_m=0.14"],
    "still_life_309": ["light=sun", "distance_m=0.18", "camera.focus_distance_m=0.11"],
}
CAMERA = Path(__file__).resolve().parents[2] / "scenes/cameras/phone_2019.json"


def simulated(name, settings):
    """The capture's folder: one frame at rest."""
    folder = options.work / name
    if not (folder / "capture/capture.json").exists():
        kind, seed = name.rsplit("_", 1)
        own = ["lens=phone_thin", "burst.hand_shake=0", "burst.frames=1", *settings]
        taken = [f"camera.file={CAMERA}", "lens=null", f"sensor.width_px={options.size}",
                 f"sensor.height_px={options.size * 3 // 4 // 8 * 8}", "render.photograph_samples_per_pixel=1",
                 "render.all_in_focus_samples_per_pixel=1", "render.light_samples=16",
                 f"render.samples_per_pixel={64 if kind == 'portrait' else 16}"]
        sets = lambda values: [word for value in values for word in ("--set", value)]
        subprocess.run([options.program, "scene", kind, "--seed", seed, *sets(own), "-o", folder / "scene"], check=True)
        subprocess.run([options.program, "simulate", folder / "scene/scene.json", *sets(taken), "-o", folder / "capture"],
                       check=True)
    return folder / "capture"


def rendered_pairs():
    """Name, views with 1 where they clip, truth (NaN: unknown), and a map of the views' size on the truth's grid."""
    for name, settings in CLOSE_UPS.items():
        folder = simulated(name, settings)
        capture, exposure = Capture(folder), json.loads((folder / "capture.json").read_text())["exposure"]
        black, white = exposure["black_level_dn"], exposure["white_level_dn"]
        clips = (exposure.get("dp_white_level_dn", white) - black) / (white - black)
        views = [np.clip(view / clips, 0, 1) for view in (capture.left, capture.right)]
        step = capture.truth.disparity.shape[1] // views[0].shape[1]
        truth = capture.truth.disparity[step // 2 :: step, step // 2 :: step]
        yield name, views, np.where(np.isfinite(truth), truth, np.nan), lambda found: found


def pixel4_pairs():
    """As rendered_pairs; the truth is of the middle two thirds, 0 to 1, of unknown scale and offset."""
    for path in sorted(options.pixel4.glob("*_left.png")):
        number = path.name[:3]
        raw = [cv2.imread(str(options.pixel4 / f"{number}_{side}.png"), -1) for side in ("left", "right")]
        views = [np.clip((view.astype(np.float32) - 1024) / (16383 - 1024), 0, 1) for view in raw]
        truth = cv2.imread(str(options.pixel4 / f"gt_defocus_map/{number}_gt.png"), -1) / 255.0
        height, width = views[0].shape
        middle = np.s_[height // 6 : height - height // 6, width // 6 : width - width // 6]
        yield number, views, np.where(truth > 0, truth, np.nan), lambda found, middle=middle: found[middle]


# %% Errors after a fit (Garg et al. 2019, section 5)
def fitted(found, truth, weight):
    """scale found + offset, closest to the truth."""
    a = np.stack([found, np.ones_like(found)], 1) * np.sqrt(weight)[:, None]
    return np.stack([found, np.ones_like(found)], 1) @ np.linalg.lstsq(a, truth * np.sqrt(weight), rcond=None)[0]


def ranks(values):
    """From 1; what is equal takes its mean rank."""
    _, which, counts = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - (counts - 1) / 2)[which]


def errors(found, truth, absolute):
    """AIWE(1), AIWE(2), 1 - |rank correlation|, and, of an absolute truth, without a fit the RMSE, DP px."""
    known = np.isfinite(truth)
    d, t = found[known].astype(float), truth[known].astype(float)
    unit = (t - t.min()) / np.ptp(t) if absolute else t
    weight = np.ones_like(unit)
    for _ in range(5):
        distance = abs(fitted(d, unit, weight) - unit)
        weight = 1 / np.maximum(distance, 1e-3)
    square = np.sqrt(np.mean((fitted(d, unit, np.ones_like(unit)) - unit) ** 2))
    rank = 1 - abs(np.corrcoef(ranks(d), ranks(t))[0, 1])
    return [distance.mean(), square, rank] + ([np.sqrt(np.mean((d - t) ** 2))] if absolute else [])


def table(kind, pairs):
    """One line for each method, the best by AIWE(1) first."""
    names = options.methods.split(",") if options.methods else list(METHODS)
    rows = {name: [] for name in names}
    for scene, views, truth, on_grid in pairs:
        for name in names:
            kept = options.work / f"{kind}_{scene}_{name.replace(' ', '_')}.npy"
            if not kept.exists():
                np.save(kept, METHODS[name](*views).astype(np.float32))
            rows[name].append(errors(on_grid(np.load(kept)), truth, kind == "rendered"))
    print(f"{kind}: AIWE(1), AIWE(2), 1 - |rank|" + (", RMSE in DP px" if kind == "rendered" else ""))
    for name in sorted(rows, key=lambda name: np.mean(rows[name], 0)[0]):
        print(f"  {name:22s}" + "".join(f"{value:8.3f}" for value in np.mean(rows[name], 0)))


options.work.mkdir(parents=True, exist_ok=True)
if options.pixel4:
    table("real", pixel4_pairs())
if options.rendered:
    table("rendered", rendered_pairs())
