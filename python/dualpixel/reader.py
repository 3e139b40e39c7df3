"""Reads captures with NumPy alone: no compiled part, and nothing is read before it is asked for.

The attributes are those of `dualpixel.Capture`; hashes are not compared, and arrays are the caller's to change.
docs/capture.md defines the folder.
"""

from __future__ import annotations

import math
import os
from functools import cached_property
from typing import Any, Optional

import numpy as np

from .errors import InputError
from .fields import Fields, read_json
from .pictures import Path, joined, read_exr, read_png

_MOST_FRAMES = 1000


def camera_of(document: Fields) -> dict[str, Any]:
    """The camera of a capture.json or sample.json; a focus at infinity, which JSON cannot say, as math.inf."""
    fields = document.object("camera")
    width, height = fields.integer("width_px", 2, 65536), fields.integer("height_px", 4, 65536)
    camera = {
        **fields.document,
        "name": fields.text("name", "unnamed"),
        "cfa": fields.text("cfa", "RGGB"),
        "dp_downsample_x": fields.integer("dp_downsample_x", 1, 16, 2),
        "dp_downsample_y": fields.integer("dp_downsample_y", 1, 16, 4),
        "focus_distance_m": fields.number("focus_distance_m", 1e-4, math.inf),
        "principal_point_px": fields.numbers("principal_point_px", 2, [width / 2, height / 2]),
        "split": fields.text("split", "unknown"),
        "alpha": fields.number("alpha", 0, 10, 0),
    }
    for name, low, high in (("pixel_pitch_um", 0.01, 1000), ("focal_length_mm", 0.01, 1e5), ("f_number", 0.1, 1e6)):
        fields.number(name, low, high)
    for name, size in (("dp_downsample_x", width), ("dp_downsample_y", height)):
        if size % camera[name]:
            fields.fail(name, f"{camera[name]}: must divide the {size} photosites")
    return camera


def exposure_of(document: Fields) -> dict[str, Any]:
    """The exposure of a capture.json or sample.json."""
    fields = document.object("exposure")
    bits = fields.integer("bits", 8, 16)
    white = fields.number("white_level_dn", 0, 2**bits - 1)
    black = fields.number("black_level_dn", 0, 65535)
    if black >= white:
        fields.fail("black_level_dn", f"{black:g} must be below the white level {white:g}")
    exposure = {
        **fields.document,
        "time_s": fields.number("time_s", 0, 1e6, 0),
        "iso": fields.number("iso", 0, 1e8, 0),
        "white_balance": fields.numbers("white_balance", 3, [1, 1, 1]),
        "lux_s_per_unit": fields.number("lux_s_per_unit", 0, 1e12, 0),
    }
    for name in ("mosaic_noise", "dp_noise"):
        noise = fields.object(name, {})
        exposure[name] = {"shot_dn": noise.number("shot_dn", 0, 1e9, 0), "read_dn2": noise.number("read_dn2", 0, 1e15, 0)}
    return exposure


class _Files:
    """The pictures of a folder, whose size the camera gives."""

    def __init__(self, folder: str, camera: dict[str, Any]):
        self.folder = folder
        self.sensor = (camera["height_px"], camera["width_px"])
        self.views = (self.sensor[0] // camera["dp_downsample_y"], self.sensor[1] // camera["dp_downsample_x"])

    def png(self, name: str, shape: tuple[int, int]) -> np.ndarray:
        """uint16, whatever its bits are."""
        path = os.path.join(self.folder, name)
        return _of_shape(read_png(path), shape, path).astype(np.uint16, copy=False)

    def exr(self, name: str, *channels: str) -> dict[str, np.ndarray]:
        """Those channels of the sensor's size."""
        path = os.path.join(self.folder, name)
        read = read_exr(path)
        for channel in channels:
            if channel not in read:
                raise InputError(f"{path}: has no channel '{channel}'; it has {', '.join(sorted(read))}")
            _of_shape(read[channel], self.sensor, path)
        return read


def _of_shape(image: np.ndarray, shape: tuple[int, int], path: str) -> np.ndarray:
    if image.shape == shape:
        return image
    size = " x ".join(map(str, image.shape[1::-1])) + (f" x {image.shape[2]} channels" if image.ndim > 2 else "")
    raise InputError(f"{path}: {size}: must be {shape[1]} x {shape[0]} pixels of one channel, as /camera says")


class Frame:
    """One frame of a burst: raw digital numbers, uint16."""

    def __init__(self, files: _Files, entry: Fields):
        self._files = files
        mosaic = entry.path("mosaic", None)
        # views come in pairs; only beside a mosaic may they be missing
        views_missing = mosaic is not None and not {"left", "right"} & entry.document.keys()
        views = {side: None if views_missing else entry.path(side) for side in ("left", "right")}
        self._names = {"mosaic": mosaic, **views}
        self.seed = entry.integer("seed", 0, 2**64 - 1, 0)
        self.camera_from_world = np.array(entry.numbers("camera_from_world", 16, np.eye(4).ravel().tolist())).reshape(4, 4)

    def _view(self, side: str) -> Optional[np.ndarray]:
        name = self._names[side]
        return None if name is None else self._files.png(name, self._files.views)

    @cached_property
    def mosaic(self) -> Optional[np.ndarray]:
        name = self._names["mosaic"]
        return None if name is None else self._files.png(name, self._files.sensor)

    left = cached_property(lambda self: self._view("left"))
    right = cached_property(lambda self: self._view("right"))


class Truth:
    """Ground truth of the first frame on the sensor's grid, float32 but for `object_id`."""

    def __init__(self, files: _Files, entry: Fields):
        self._files = files
        self._names = {kind: entry.path(kind) for kind in ("geometry", "all_in_focus", "photograph")}
        self._names["views"] = entry.path("views", None)
        self._motion = entry.paths("motion")
        self.photograph_aperture_scale = entry.number("photograph_aperture_scale", 1e-3, 1e3)

    def _colors(self, kind: str) -> np.ndarray:
        return joined(self._files.exr(self._names[kind], *"RGB"), *"RGB")

    def _view(self, side: str) -> Optional[np.ndarray]:
        return None if self._views is None else joined(self._views, *(f"{side}.{color}" for color in "RGB"))

    @cached_property
    def _geometry(self) -> dict[str, np.ndarray]:
        normal = ("N.X", "N.Y", "N.Z")
        return self._files.exr(
            self._names["geometry"], "Z", "blur_px", "disparity_dp_px", "person", "valid", "id", *normal
        )

    @cached_property
    def _views(self) -> Optional[dict[str, np.ndarray]]:
        name = self._names["views"]
        colors = [f"{side}.{color}" for side in ("left", "right") for color in "RGB"]
        return None if name is None else self._files.exr(name, *colors)

    depth = cached_property(lambda self: self._geometry["Z"])
    blur = cached_property(lambda self: self._geometry["blur_px"])
    disparity = cached_property(lambda self: self._geometry["disparity_dp_px"])
    person_mask = cached_property(lambda self: self._geometry["person"])
    valid = cached_property(lambda self: self._geometry["valid"])
    object_id = cached_property(lambda self: self._geometry["id"])
    normal = cached_property(lambda self: joined(self._geometry, "N.X", "N.Y", "N.Z"))
    all_in_focus = cached_property(lambda self: self._colors("all_in_focus"))
    photograph = cached_property(lambda self: self._colors("photograph"))
    left = cached_property(lambda self: self._view("left"))
    right = cached_property(lambda self: self._view("right"))

    @cached_property
    def motion(self) -> list[np.ndarray]:
        return [joined(self._files.exr(name, "x", "y"), "x", "y") for name in self._motion]


class Capture:
    """A capture's folder, read piece by piece as it is asked for.

    Whatever is wrong with it is an InputError of one line: of capture.json at once, of a picture when it is read.
    """

    def __init__(self, path: Path):
        folder = os.fspath(path)
        file = os.path.join(folder, "capture.json")
        document = Fields(read_json(file), file)
        document.choice("format", "dualpixel-capture")
        document.integer("version", 1, 1)
        self.camera = camera_of(document)
        self.exposure = exposure_of(document)
        self.provenance: dict[str, Any] = document.object("provenance", {}).document
        self.face_px: Optional[list[float]] = document.numbers("face_px", 4, None)
        files = _Files(folder, self.camera)
        self.frames = [Frame(files, entry) for entry in document.objects("frames", _MOST_FRAMES)]
        self.truth = Truth(files, document.object("truth")) if "truth" in document.document else None

    def _normalized(self, raw: Optional[np.ndarray]) -> Optional[np.ndarray]:
        if raw is None:
            return None
        black, white = self.exposure["black_level_dn"], self.exposure["white_level_dn"]
        return ((raw.astype(np.float64) - black) / (white - black)).astype(np.float32)

    left = cached_property(lambda self: self._normalized(self.frames[0].left))
    right = cached_property(lambda self: self._normalized(self.frames[0].right))
