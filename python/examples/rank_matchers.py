"""Rank ways of matching on real pairs and on rendered ones: is the order the same? (docs/disparity.md, "On rendered scenes")

    python3 rank_matchers.py PROGRAM WORK --rendered                 # six drawn scenes through a phone: an hour, the first time
    python3 rank_matchers.py PROGRAM WORK --pixel4 DP_data_pixel_4   # six pairs of Xin et al. 2021, those of them that are there
    python3 rank_matchers.py PROGRAM WORK --rendered --methods B,split

Needs dualpixel (PYTHONPATH=build/release/python) and OpenCV. DP_data_pixel_4 is that folder of
https://github.com/cmu-ci-lab/dual_pixel_defocus_estimation_deblurring. WORK keeps the captures and what was found, so that a run
goes on where the last one was stopped: after a change of PROGRAM, of a method or of the pairs, take another WORK, or delete the
*.npy in it. Errors are those of Garg et al. 2019 after an affine fit to the truth, which is 0 to 1 over each picture.

A method of your own is a function of the two views and a row of METHODS, below.
"""

# %% Options
import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np

import dualpixel
from dualpixel.pictures import read_exr
from dualpixel.reader import Capture
from pairs_with_truth import affine_errors, pixel4_pairs, write_pair

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("program", metavar="PROGRAM", help="build/release/tools/dualpixel")
parser.add_argument("work", type=Path, metavar="WORK", help="folder for captures and results")
parser.add_argument("--pixel4", type=Path, metavar="DIR", help="real pairs")
parser.add_argument("--rendered", action="store_true", help="rendered pairs")
parser.add_argument("--methods", metavar="NAMES", help="separated by commas; default: all. A matcher may have an option of portrait: split:smooth.divisor=8")
parser.add_argument("--size", type=int, default=2688, metavar="N",
                    help="photosites across the middle of the sensor that is rendered, a multiple of 32 from 224 on; default: "
                    "2688. Under 1000 only to try the script: so small a part of a scene has hardly any depth")
options = parser.parse_args()
DETAIL_PX, SHADING_PX, WINDOW_PX = 6, 20, 12  # Gaussians' deviations, pixels of the views: low-pass, local mean, window
STEP = 4  # a quarter of the size
RANGE_PX = 16


# %% The pipeline's own
def run(*arguments):
    """The program, silent unless it fails."""
    done = subprocess.run([options.program, *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)


def portrait(views, *arguments):
    """The smoothed disparity, DP px, by the program."""
    folder = options.work / "pair"
    run("portrait", *write_pair(folder, views), "--mode", "dp", *arguments, "-o", folder / "result")
    return read_exr(folder / "result/maps.exr")["disparity_dp_px"]


def smoothed(views, disparity, **by):
    """by: sigma or confidence."""
    arguments = []
    for name, values in dict(by, disparity=disparity).items():
        path = options.work / f"{name}.npy"
        np.save(path, values.astype(np.float32))
        arguments += [f"--{name}", path]
    return portrait(views, *arguments)


def by_matcher(text):
    """A matcher, or one with an option of `portrait`, MATCHER:GROUP.OPTION=VALUE."""
    name, _, assignment = text.partition(":")
    return lambda *views: portrait(views, "--matcher", name, *(["--set", assignment] if assignment else []))


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
    height, width = small[0].shape
    even = [np.pad(view, ((0, height % 2), (0, width % 2)), mode="edge") for view in small]
    found = dualpixel.match(*even, matcher="likelihood")
    return [by * grown(map_[:height, :width], views[0]) for map_ in (found.disparity, found.sigma)]


def at_a_quarter(before_px):
    def find(*views):
        disparity, sigma = likelihood_at(views, STEP, before_px)
        return smoothed(views, disparity, sigma=sigma)

    return find


def pyramid(*views):
    """A: at 1/8, 1/4, 1/2 and 1/1, each after a low-pass of 1.5 of its pixels, weighted by the inverse variance."""
    levels = [likelihood_at(views, by, after_px=1.5) for by in (8, 4, 2, 1)]
    weights = [1 / np.maximum(sigma, 1e-3) ** 2 for _, sigma in levels]
    disparity = sum(weight * found for weight, (found, _) in zip(weights, levels)) / sum(weights)
    return smoothed(views, disparity, sigma=sum(weights) ** -0.5)


# %% Squared differences of a band of low frequencies
def bands(views):
    """At a quarter of the size, without detail and local mean, divided by the contrast of twice as wide surroundings."""
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


PAD = 24  # samples: wider than any kernel, 16 / 4 / .21 across, and any shift


def spectra_of_bands(views):
    """Of both, mirrored beyond their borders; and the mirrored pictures' shape."""
    padded = [np.pad(view, PAD, mode="reflect") for view in bands(views)]
    return [np.fft.rfft2(view) for view in padded], padded[0].shape


def square_of(spectrum, shape):
    return np.fft.irfft2(spectrum, shape)[PAD : -PAD, PAD : -PAD] ** 2


def shifts_of_a_band(*views):
    """B: the views shifted against each other."""
    (left, right), shape = spectra_of_bands(views)
    waves = 2j * np.pi * np.fft.rfftfreq(shape[1])
    shifts = np.arange(-RANGE_PX, RANGE_PX + 0.1, 0.5)
    costs = [square_of(left * np.exp(-waves * d / 2) - right * np.exp(waves * d / 2), shape) for d in shifts / STEP]
    return cheapest(views, shifts, costs)


def ramp_kernels(disparity, alpha, steps=8):
    """Of the left and the right view, pixels of a quarter: discs weighted by a ramp, whose centroids lie `disparity` apart."""
    radius = max(abs(disparity) / alpha / 2, 0.5)
    reach = int(np.ceil(radius)) + 1
    points = np.arange(-reach, reach + 1)[:, None] + (np.arange(steps) + 0.5) / steps - 0.5
    x, y = np.meshgrid(points.ravel(), points.ravel())
    ramp = 4 * alpha * x / radius * np.sign(disparity)  # under 1 for a factor under 1/4
    halves = [(x * x + y * y <= radius**2) * (1 + side * ramp) for side in (-1, 1)]
    size = 2 * reach + 1
    halves = [half.reshape(size, steps, size, steps).sum((1, 3)) for half in halves]
    return [half / half.sum() for half in halves]


def kernels_of_a_band(*views, alpha=0.21):
    """C: the left view through the right one's kernel against the right view through the left one's, whitened."""
    (left, right), shape = spectra_of_bands(views)
    shifts = np.arange(-RANGE_PX, RANGE_PX + 1.0)
    costs = []
    for d in shifts / STEP:
        spectra = []
        for kernel in ramp_kernels(d, alpha):
            whole = np.zeros(shape)
            whole[: len(kernel), : len(kernel)] = kernel
            spectra.append(np.fft.rfft2(np.roll(whole, -(len(kernel) // 2), (0, 1))))
        power = abs(spectra[0]) ** 2 + abs(spectra[1]) ** 2 + 1e-3
        costs.append(square_of((spectra[1] * left - spectra[0] * right) / np.sqrt(power), shape))
    return cheapest(views, shifts, costs)


# Each takes the left and the right view, float32 of one size, 0 black and 1 where they clip, and returns disparity of that size,
# DP px, right(x + d) = left(x), smoothed by the pipeline as the others are: see smoothed().
MATCHERS = ("paper", "likelihood", "split")
METHODS = {"paper": by_matcher("paper"), "likelihood": by_matcher("likelihood"), "averaged": at_a_quarter(0),
           "low_passed": at_a_quarter(DETAIL_PX), "A": pyramid, "B": shifts_of_a_band, "C": kernels_of_a_band,
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
    folder = options.work / f"{name}_{options.size}"
    if not (folder / "capture/capture.json").exists():
        kind, seed = name.rsplit("_", 1)
        own = ["lens=phone_thin", "burst.hand_shake=0", "burst.frames=1", *settings]
        taken = [f"camera.file={CAMERA}", "lens=null", f"sensor.width_px={options.size}",
                 f"sensor.height_px={options.size * 3 // 4 // 8 * 8}", "render.photograph_samples_per_pixel=1",
                 "render.all_in_focus_samples_per_pixel=1", "render.light_samples=16",
                 f"render.samples_per_pixel={64 if kind == 'portrait' else 16}"]
        sets = lambda values: [word for value in values for word in ("--set", value)]
        run("scene", kind, "--seed", seed, *sets(own), "-o", folder / "scene")
        run("simulate", folder / "scene/scene.json", *sets(taken), "-o", folder / "capture")
    return folder / "capture"


def rendered_pairs():
    """Name, views with 1 where they clip, and truth of their size, DP px; not finite where it is unknown."""
    for name, settings in CLOSE_UPS.items():
        capture = Capture(simulated(name, settings))
        black, white = capture.exposure["black_level_dn"], capture.exposure["white_level_dn"]
        clips = (capture.exposure.get("dp_white_level_dn", white) - black) / (white - black)
        views = [np.clip(view / clips, 0, 1) for view in (capture.left, capture.right)]
        below, right_of = capture.camera["dp_downsample_y"], capture.camera["dp_downsample_x"]
        yield name, views, capture.truth.disparity[below // 2 :: below, right_of // 2 :: right_of]


def errors(found, truth, absolute):
    """AIWE(1), AIWE(2), 1 - |rank correlation|, and, of an absolute truth, without a fit the RMSE, DP px."""
    known = np.isfinite(truth)
    rmse = [np.sqrt(np.mean((found[known].astype(float) - truth[known]) ** 2))] if absolute else []
    return affine_errors(found, truth, unit_range=absolute) + rmse


def found_by(name, kind, scene, views):
    """A method's disparity, of a kept file where there is one."""
    kept = options.work / f"{kind}_{scene}_{name}.npy"
    if not kept.exists():
        print(f"{scene}: {name}", file=sys.stderr)
        found = METHODS[name](*views)
        if found.shape != views[0].shape or not np.isfinite(found).all():
            sys.exit(f"{name}: {scene}: must be finite, and of the views' shape {views[0].shape}: is of {found.shape}")
        np.save(options.work / "unfinished.npy", found.astype(np.float32))
        os.replace(options.work / "unfinished.npy", kept)
    return np.load(kept)


def table(kind, pairs, names):
    """One line for each method, the best by AIWE(1) first."""
    absolute = kind != "real"
    rows = {name: [] for name in names}
    count = 0
    for scene, views, truth in pairs:
        count += 1
        for name in names:
            rows[name].append(errors(found_by(name, kind, scene, views), truth, absolute))
    width = max(12, *(len(name) for name in names))
    print(f"{kind}, {count} pairs: AIWE(1), AIWE(2), 1 - |rank|" + (", RMSE in DP px" if absolute else ""))
    for name in sorted(rows, key=lambda name: np.mean(rows[name], 0)[0]):
        print(f"  {name:{width}s}" + "".join(f"{value:8.3f}" for value in np.mean(rows[name], 0)))


chosen = list(METHODS) if options.methods is None else [name.strip() for name in options.methods.split(",")]
METHODS.update({name: by_matcher(name) for name in chosen if name.partition(":")[0] in MATCHERS and "=" in name})
if unknown := [name for name in chosen if name not in METHODS]:
    parser.error(f"--methods: {', '.join(unknown)}: must be of {', '.join(METHODS)}")
if not options.pixel4 and not options.rendered:
    parser.error("--pixel4 or --rendered is required")
if options.size < 224 or options.size % 32:
    parser.error(f"--size: {options.size}: must be a multiple of 32, at least 224")
if shutil.which(options.program) is None:
    parser.error(f"{options.program}: must be a program")
if options.work.exists() and not options.work.is_dir():
    parser.error(f"{options.work}: must be a folder")
options.work.mkdir(parents=True, exist_ok=True)
if options.pixel4:
    try:
        table("real", pixel4_pairs(options.pixel4), chosen)
    except dualpixel.InputError as error:
        parser.error(f"--pixel4: {error}")
if options.rendered:
    table(f"rendered_{options.size}", rendered_pairs(), chosen)
