"""Reads captures with NumPy alone: no compiled part, and nothing is read before it is asked for.

The attributes are those of `dualpixel.Capture`; hashes are not compared, and arrays are the caller's to change.
docs/capture.md defines the folder.
"""

from __future__ import annotations

import json
import math
import os
from functools import cached_property
from typing import Any, Optional

import numpy as np

from .errors import InputError
from .pictures import Path, joined, read_exr, read_png


def read_json(path: Path) -> Any:
    """A JSON document; InputError with one line where it is none."""
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except OSError as error:
        raise InputError(f"{os.fspath(path)}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{os.fspath(path)}: is not valid JSON: {error}") from error


# What a capture.json that is written by hand may leave out.
_CAMERA = {"name": "unnamed", "cfa": "RGGB", "dp_downsample_x": 2, "dp_downsample_y": 4, "split": "unknown", "alpha": 0}
_EXPOSURE = {
    "time_s": 0,
    "iso": 0,
    "mosaic_noise": {"shot_dn": 0, "read_dn2": 0},
    "dp_noise": {"shot_dn": 0, "read_dn2": 0},
    "white_balance": [1, 1, 1],
    "lux_s_per_unit": 0,
}


def camera_of(document: dict[str, Any]) -> dict[str, Any]:
    """The camera of a capture.json or sample.json; a focus at infinity, which JSON cannot say, as math.inf."""
    camera = {**_CAMERA, **document["camera"]}
    camera.setdefault("principal_point_px", [camera["width_px"] / 2, camera["height_px"] / 2])
    if camera["focus_distance_m"] == "inf":
        camera["focus_distance_m"] = math.inf
    return camera


class Frame:
    """One frame of a burst: raw digital numbers, uint16."""

    def __init__(self, folder: str, entry: dict[str, Any]):
        self._folder, self._entry = folder, entry
        self.seed = entry.get("seed", 0)
        self.camera_from_world = np.array(entry.get("camera_from_world", np.eye(4).ravel().tolist())).reshape(4, 4)

    def _picture(self, kind: str) -> Optional[np.ndarray]:
        return read_png(os.path.join(self._folder, self._entry[kind])) if kind in self._entry else None

    mosaic = cached_property(lambda self: self._picture("mosaic"))
    left = cached_property(lambda self: self._picture("left"))
    right = cached_property(lambda self: self._picture("right"))


class Truth:
    """Ground truth of the first frame on the sensor's grid, float32 but for `object_id`."""

    def __init__(self, folder: str, entry: dict[str, Any]):
        self._folder, self._entry = folder, entry
        self.photograph_aperture_scale = entry["photograph_aperture_scale"]

    def _exr(self, kind: str) -> dict[str, np.ndarray]:
        return read_exr(os.path.join(self._folder, self._entry[kind]))

    def _view(self, side: str) -> Optional[np.ndarray]:
        return joined(self._views, *(f"{side}.{color}" for color in "RGB")) if "views" in self._entry else None

    _geometry = cached_property(lambda self: self._exr("geometry"))
    _views = cached_property(lambda self: self._exr("views"))
    depth = cached_property(lambda self: self._geometry["Z"])
    blur = cached_property(lambda self: self._geometry["blur_px"])
    disparity = cached_property(lambda self: self._geometry["disparity_dp_px"])
    person_mask = cached_property(lambda self: self._geometry["person"])
    valid = cached_property(lambda self: self._geometry["valid"])
    object_id = cached_property(lambda self: self._geometry["id"])
    normal = cached_property(lambda self: joined(self._geometry, "N.X", "N.Y", "N.Z"))
    all_in_focus = cached_property(lambda self: joined(self._exr("all_in_focus"), *"RGB"))
    photograph = cached_property(lambda self: joined(self._exr("photograph"), *"RGB"))
    left = cached_property(lambda self: self._view("left"))
    right = cached_property(lambda self: self._view("right"))

    @cached_property
    def motion(self) -> list[np.ndarray]:
        return [joined(read_exr(os.path.join(self._folder, name)), "x", "y") for name in self._entry.get("motion", [])]


class Capture:
    """A capture's folder, read piece by piece as it is asked for."""

    def __init__(self, path: Path):
        self._folder = os.fspath(path)
        file = os.path.join(self._folder, "capture.json")
        document = read_json(file)
        if not isinstance(document, dict) or document.get("format") != "dualpixel-capture":
            raise InputError(f"{file}: /format: must be 'dualpixel-capture'")
        if document.get("version") != 1:
            raise InputError(f"{file}: /version: {document.get('version')}: must be 1")
        self.camera = camera_of(document)
        self.exposure: dict[str, Any] = {**_EXPOSURE, **document["exposure"]}
        self.provenance: dict[str, Any] = document.get("provenance", {})
        self.face_px: Optional[list[float]] = document.get("face_px")
        self.frames = [Frame(self._folder, entry) for entry in document["frames"]]
        self.truth = Truth(self._folder, document["truth"]) if "truth" in document else None

    def _normalized(self, raw: np.ndarray) -> np.ndarray:
        black, white = self.exposure["black_level_dn"], self.exposure["white_level_dn"]
        return ((raw.astype(np.float64) - black) / (white - black)).astype(np.float32)

    left = cached_property(lambda self: self._normalized(self.frames[0].left))
    right = cached_property(lambda self: self._normalized(self.frames[0].right))
