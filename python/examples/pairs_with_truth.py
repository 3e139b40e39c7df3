"""Real dual-pixel pairs with a truth, and the errors by which others score them: for the examples beside this file.

Views are float32, linear, 0 black and 1 where they clip. A truth is of the views' size, of unknown scale and offset, larger where
farther; NaN where it is not known. Needs OpenCV.
"""

from pathlib import Path

import cv2
import numpy as np

import dualpixel


def picture(path):
    found = cv2.imread(str(path), -1)
    if found is None:
        raise dualpixel.InputError(f"{path}: must be a picture")
    return found


def pixel4_pairs(folder):
    """Name, (left, right), truth. `folder`: DP_data_pixel_4 of Xin et al. 2021,
    https://github.com/cmu-ci-lab/dual_pixel_defocus_estimation_deblurring. Of its scenes six, of which no two show the same; those
    of them that are there. The truth, 0 to 1, is known in the middle two thirds alone."""
    folder = Path(folder)
    numbers = [n for n in ("001", "003", "005", "007", "009", "011") if (folder / f"{n}_left.png").exists()]
    if not numbers:
        raise dualpixel.InputError(f"{folder}: has no 001_left.png")
    for number in numbers:
        raw = [picture(folder / f"{number}_{side}.png") for side in ("left", "right")]
        views = [np.clip((view.astype(np.float32) - 1024) / (16383 - 1024), 0, 1) for view in raw]
        truth = picture(folder / f"gt_defocus_map/{number}_gt.png") / 255.0
        truth[truth == 0] = np.nan
        height, width = views[0].shape
        yield number, views, np.pad(truth, ((height // 6,) * 2, (width // 6,) * 2), constant_values=np.nan)


def dp119_pairs(folder):
    """As pixel4_pairs. `folder`: DP119, box/NAME and iphone/NAME (or casual/iphone/NAME) of real_sample_set,
    https://github.com/LinYark/Sdirt: a full-frame camera at f/4. The truth is minus the inverse of depth in m."""
    folder = Path(folder)
    scenes = [scene for kind in ("box", "iphone", "casual/iphone") for scene in sorted(folder.glob(f"{kind}/*/l.png"))]
    if not scenes:
        raise dualpixel.InputError(f"{folder}: has no box/*/l.png, nor iphone/*/l.png")
    for scene in (path.parent for path in scenes):
        views = [linear_gray(picture(scene / name)) for name in ("l.png", "r.png")]
        coded = picture(scene / "d.png")
        coded = cv2.resize(coded[..., 0] if coded.ndim > 2 else coded, views[0].shape[::-1], interpolation=cv2.INTER_NEAREST)
        known = (coded > 0) & (coded < 255)
        yield f"{scene.parent.name}_{scene.name}", views, np.where(known, -25.5 / np.where(known, coded, 1), np.nan)


def linear_gray(picture_srgb):
    """The mean of the colors, without the sRGB curve (IEC 61966-2-1)."""
    coded = picture_srgb.astype(np.float32) / np.iinfo(picture_srgb.dtype).max
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    return linear.mean(-1) if linear.ndim > 2 else linear


def write_pair(folder, views):
    """Of the views, for `dualpixel portrait`: the arguments that name them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, view in zip(("left.png", "right.png"), views):
        cv2.imwrite(str(folder / name), np.clip(np.rint(65535 * view), 0, 65535).astype(np.uint16))
    (folder / "pair.json").write_text('{"encoding": "linear"}')
    return ["--left", folder / "left.png", "--right", folder / "right.png", "--metadata", folder / "pair.json"]


# %% Errors after a fit (Garg et al. 2019, section 5)
def fitted(found, truth, weight):
    """scale found + offset, closest to the truth."""
    a = np.stack([found, np.ones_like(found)], 1) * np.sqrt(weight)[:, None]
    return np.stack([found, np.ones_like(found)], 1) @ np.linalg.lstsq(a, truth * np.sqrt(weight), rcond=None)[0]


def ranks(values):
    """From 1; what is equal takes its mean rank."""
    _, which, counts = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - (counts - 1) / 2)[which]


def affine_errors(found, truth, unit_range):
    """AIWE(1), AIWE(2), 1 - |rank correlation|. `unit_range`: the truth is scaled to 0 to 1 over the picture."""
    known = np.isfinite(truth)
    d, t = found[known].astype(float), truth[known].astype(float)
    unit = (t - t.min()) / np.ptp(t) if unit_range else t
    weight = np.ones_like(unit)
    for _ in range(5):
        distance = abs(fitted(d, unit, weight) - unit)
        weight = 1 / np.maximum(distance, 1e-3)
    square = np.sqrt(np.mean((fitted(d, unit, np.ones_like(unit)) - unit) ** 2))
    rank = 1 - abs(np.corrcoef(ranks(d), ranks(t))[0, 1])
    return [distance.mean(), square, rank]
