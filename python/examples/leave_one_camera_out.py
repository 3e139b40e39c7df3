"""Are the constants of matcher split tuned to one camera? Chosen by all cameras but one, and judged on that one.

    python3 leave_one_camera_out.py PROGRAM WORK                         # three rendered cameras: half an hour on two cores
    python3 leave_one_camera_out.py PROGRAM WORK --pixel4 DP_data_pixel_4 --dp119 real_sample_set    # and two real ones

Needs dualpixel (PYTHONPATH=build/release/python) and OpenCV; pairs_with_truth.py says where real pairs are from. Each constant is
varied alone, the others at their defaults. A camera's figure is the geometric mean of its errors: DP px of rendered views, AIWE(1)
of real pairs (Garg et al. 2019). For each camera, the others choose each constant's value: that of the least geometric mean of
their figures. Then all that they chose is tried on the camera. WORK keeps each camera's figures, scenes and walls, so that a run
goes on where the last one was stopped: after a change of PROGRAM or of the pairs, take another WORK.
"""

# %% Options
import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import dualpixel
from dualpixel.pictures import read_exr
from pairs_with_truth import affine_errors, dp119_pairs, pixel4_pairs, write_pair

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("program", metavar="PROGRAM", help="build/release/tools/dualpixel")
parser.add_argument("work", type=Path, metavar="WORK", help="folder for captures and results")
parser.add_argument("--pixel4", type=Path, metavar="DIR", help="a phone's pairs")
parser.add_argument("--dp119", type=Path, metavar="DIR", help="a full-frame camera's pairs")
parser.add_argument("--cameras", metavar="NAMES", help="of thin, prescription, scenes, pixel4, dp119, separated by commas; "
                    "default: the rendered ones and those whose pairs are given")
parser.add_argument("--scenes", type=int, default=24, metavar="N", help="drawn scenes; default: 24")
options = parser.parse_args()

# The first value of each is the default (pipeline/disparity/split/options.h).
CONSTANTS = {
    "low_pass_px": (4.5, 4, 6, 9),
    "high_pass_px": (20, 14, 28),
    "window_px": (12, 9, 15, 17),
    "near_focus_dp_px": (1.2, 0.8, 1.8),
}
WALLS = {"defocus": (6, 32), "near_defocus": (6, 32), "edges": (4, 24), "thin": (32, 96)}  # rows of the atlas: |value| from, to
RECIPE = Path(__file__).resolve().parents[2] / "datasets/recipes/phone_matching.json"


def assignments(values):
    """["split_match.low_pass_px=6", ...], without defaults."""
    return [f"split_match.{name}={value}" for name, value in values.items() if value != CONSTANTS[name][0]]


def method(values):
    """As --method of `dualpixel evaluate` has it."""
    return ":".join(filter(None, ["split", ",".join(assignments(values))]))


def run(*arguments):
    """The program, silent unless it fails."""
    done = subprocess.run([options.program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr or f"{options.program} {arguments[0]}: ended with status {done.returncode}")


# %% Cameras: each gives the errors of several methods, which are dictionaries of constants
def walls(camera):
    """Walls, and strips before a wall, through a lens: the RMSE of each blur, DP px."""

    def measure(methods, folder):
        sets = [word for values in methods for word in ("--method", method(values))]
        rows = [word for row in WALLS for word in ("--row", row)]
        run("experiment", "failures", "-o", folder, "--camera", camera, *rows, *sets)
        steps = [step for row in json.loads((folder / "failures.json").read_text())["rows"] for step in row["steps"]
                 if WALLS[row["name"]][0] <= abs(step["value"]) <= WALLS[row["name"]][1]]
        return [[step["methods"][i]["rmse_dp_px"] for step in steps] for i in range(len(methods))]

    return measure


def drawn_scenes(methods, folder):
    """A phone's everyday scenes: the RMSE over all, DP px."""
    scenes = options.work / f"drawn_{options.scenes}"
    if not scenes.exists():
        recipe = json.loads(RECIPE.read_text())
        del recipe["set"]["render.noise_fraction"]  # takes minutes for a portrait
        recipe["set"]["render.samples_per_pixel"] = 64
        (options.work / "recipe.json").write_text(json.dumps(recipe, indent=1))
        run("dataset", "plan", options.work / "recipe.json", "--count", options.scenes, "-o", scenes)
    run("dataset", "render", scenes)
    sets = [word for values in methods for word in ("--method", method(values))]
    shutil.rmtree(folder, ignore_errors=True)
    run("evaluate", scenes, "-o", folder, *sets)
    scores = json.loads((folder / "evaluation.json").read_text())["methods"]
    return [[scores[method(values)]["regions"]["everything"]["rmse_dp_px"]] for values in methods]


def real(option, pairs, folder_of_pairs, unit_range):
    """AIWE(1) of each pair after the pipeline's smoothing; none where no folder is given."""
    if folder_of_pairs is None:
        return None
    try:
        next(pairs(folder_of_pairs))
    except dualpixel.InputError as error:
        parser.error(f"{option}: {error}")

    def measure(methods, folder):
        found = [[] for _ in methods]
        for _, views, truth in pairs(folder_of_pairs):
            files = write_pair(folder, views)
            for values, errors in zip(methods, found):
                sets = [word for assignment in assignments(values) for word in ("--set", assignment)]
                run("portrait", *files, "--mode", "dp", "--matcher", "split", *sets, "-o", folder / "result")
                disparity = read_exr(folder / "result/maps.exr")["disparity_dp_px"]
                errors.append(affine_errors(disparity, truth, unit_range)[0])
        return found

    return measure


ALL_CAMERAS = {"thin": walls("thin"), "prescription": walls("prescription"), "scenes": drawn_scenes,
               "pixel4": real("--pixel4", pixel4_pairs, options.pixel4, unit_range=False),
               "dp119": real("--dp119", dp119_pairs, options.dp119, unit_range=True)}
CAMERAS = {name: camera for name, camera in ALL_CAMERAS.items() if camera}
if options.cameras is not None:
    chosen_cameras = [name.strip() for name in options.cameras.split(",")]
    if unknown := [name for name in chosen_cameras if name not in CAMERAS]:
        parser.error(f"--cameras: {', '.join(unknown)}: must be of {', '.join(CAMERAS)}; pixel4 and dp119 need their pairs")
    CAMERAS = {name: CAMERAS[name] for name in chosen_cameras}
if len(CAMERAS) < 2:
    parser.error("--cameras: must name two at least")


def figures(camera, methods):
    """For each method the geometric mean of the camera's errors; of WORK/CAMERA.json where it is there."""
    name = f"{camera}_{options.scenes}" if camera == "scenes" else camera
    path = options.work / f"{name}.json"
    known = json.loads(path.read_text()) if path.exists() else {}
    missing = list({method(values): values for values in methods if method(values) not in known}.values())
    if missing:
        print(f"{camera}: {len(missing)} settings", file=sys.stderr)
        folder = options.work / f"{name}_with_{len(known)}"
        for values, errors in zip(missing, CAMERAS[camera](missing, folder)):
            known[method(values)] = float(np.exp(np.mean(np.log(errors))))
        path.write_text(json.dumps(known, indent=1) + "\n")
    return np.array([known[method(values)] for values in methods])


# %% The table
if options.scenes < 1:
    parser.error(f"--scenes: {options.scenes}: must be at least 1")
if shutil.which(options.program) is None:
    parser.error(f"{options.program}: must be a program")
if options.work.exists() and not options.work.is_dir():
    parser.error(f"{options.work}: must be a folder")
options.work.mkdir(parents=True, exist_ok=True)

DEFAULTS = {name: values[0] for name, values in CONSTANTS.items()}
alone = [{**DEFAULTS, name: value} for name, values in CONSTANTS.items() for value in values]
try:
    measured = {camera: figures(camera, alone) for camera in CAMERAS}
except dualpixel.InputError as error:
    parser.error(str(error))

print("figure of each camera (DP px; AIWE(1) of pixel4 and dp119), one constant varied; * default:\n" + " " * 25 + "".join(f"{camera:>14s}" for camera in CAMERAS))
for i, (name, value) in enumerate((name, value) for name, values in CONSTANTS.items() for value in values):
    print(f"{name:17s}{value:6g} {'*' if value == DEFAULTS[name] else ' '}" + "".join(f"{measured[camera][i]:14.4f}" for camera in CAMERAS))
print("\nleft out: what the others choose, the camera's figure at the defaults, and at that")
for left_out in CAMERAS:
    votes = sum(np.log(measured[camera]) for camera in CAMERAS if camera != left_out)
    chosen, first = {}, 0
    for name, values in CONSTANTS.items():
        chosen[name] = values[int(np.argmin(votes[first : first + len(values)]))]
        first += len(values)
    default, other = figures(left_out, [DEFAULTS, chosen])
    print(f"{left_out:13s}" + ", ".join(f"{name} {value:g}" for name, value in chosen.items())
          + f": {default:.4f} {other:.4f}")
