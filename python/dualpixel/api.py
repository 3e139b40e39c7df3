"""What the compiled part does, with Python's manners: dicts for JSON, None for what is absent."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import InputError
from .pictures import Path

Overrides = Union[Mapping[str, Any], Iterable[str]]


class Match(NamedTuple):
    """A disparity for each pixel of the views, float32."""

    disparity: np.ndarray
    """DP pixels: right(x + d) = left(x)."""
    confidence: np.ndarray
    """0 to 1."""
    sigma: Optional[np.ndarray]
    """Predicted standard deviation of the error, DP pixels; None where the matcher predicts none."""


def _plain(value: Any) -> Any:
    """What NumPy holds as Python's own; infinity as files say it, "inf", since JSON has none."""
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, float) and math.isinf(value) and value > 0:
        return "inf"
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    return value


def _json(name: str, value: Any) -> str:
    try:
        return json.dumps(_plain(value))
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: {error}: must be numbers, text, lists or dicts, as JSON has them") from None


def _assignments(overrides: Overrides) -> list[str]:
    if isinstance(overrides, Mapping):
        return [f"{field}={_json(field, value)}" for field, value in overrides.items()]
    return list(overrides)


def _seed(seed: Any) -> int:
    if isinstance(seed, (int, np.integer)) and not isinstance(seed, bool) and 0 <= seed < 2**64:
        return int(seed)
    raise InputError(f"seed: {seed!r}: must be an integer in [0, {2**64 - 1}]")


def _document(document: Union[Mapping[str, Any], Path], name: str, folder: Path = "") -> tuple[str, str]:
    """Text and name of a document of the caller's, as if it lay in `folder`, or no text and the path of a file."""
    if isinstance(document, Mapping):
        return _json(name, document), os.path.join(folder, name)
    return "", os.fspath(document)


def _loaded(capture: Union[_core.Capture, Path], truth: bool) -> _core.Capture:
    if isinstance(capture, _core.Capture):
        return capture
    if not isinstance(capture, (str, os.PathLike)):
        raise InputError(f"capture: a {type(capture).__name__}: must be a Capture, or the path of its folder")
    return _core.Capture(capture, truth=truth)


def simulate(
    scene: Union[Mapping[str, Any], Path],
    overrides: Overrides = (),
    *,
    seed: Optional[int] = None,
    folder: Path = "",
    progress: Optional[Callable[[str, float], None]] = None,
) -> _core.Capture:
    """Renders a scene into a capture with its truth: `dualpixel simulate` without the folder.

    scene      the path of a scene file or of a glTF file (docs/scene.md says what is chosen for it), or what a scene
               file holds as a dict
    overrides  fields to set, as `--set` does: {"camera.focus_distance_m": 0.9} or ["camera.focus_distance_m=0.9"]
    seed       of rendering and noise; the same seed gives the same bytes for any number of threads
    folder     to which a dict's paths are relative; "": the current one
    progress   called with the stage's name and the share of it that is done
    """
    assignments = _assignments(overrides) + ([f"render.seed={_seed(seed)}"] if seed is not None else [])
    return _core.simulate(*_document(scene, "scene", folder), assignments, progress)


def lens(
    lens: Union[Mapping[str, Any], Path],
    overrides: Overrides = (),
    *,
    focus_distance_m: Optional[float] = None,
    width_px: Optional[int] = None,
    height_px: Optional[int] = None,
    pixel_pitch_um: Optional[float] = None,
) -> dict[str, Any]:
    """What a lens does on its sensor: a lens file, a camera file or a scene.

    What is None is as the file says; where it says nothing, the focus is at 1 m, and 2688 x 2016 photosites fill the
    lens's picture. The dict is what `dualpixel lens --json` prints.
    """
    return _core.lens(
        *_document(lens, "lens"),
        _assignments(overrides),
        focus_distance_m,
        width_px,
        height_px,
        pixel_pitch_um,
    )


def match(
    left: Union[_core.Capture, npt.ArrayLike, Path],
    right: Optional[npt.ArrayLike] = None,
    *,
    matcher: str = "split",
    options: Overrides = (),
    noise: Optional[tuple[float, float]] = None,
    white: float = 1,
) -> Match:
    """Disparity between two views, or of a capture (its frames are merged first), by one of the pipeline's matchers.

    left, right  linear views of shape (height, width), 0 black; or a capture and None
    matcher      "split", "likelihood" or "paper"
    options      e.g. {"split_match.range_px": 24}: what `dualpixel portrait --options` lists under the matcher's name
    noise        variance shot * x + read of a view's pixel of mean x; None: the matcher estimates it. A capture states
                 its own noise and white
    white        signal at which a view clips
    """
    assignments = _assignments(options)
    if right is None:
        return Match(*_core.match_capture(_loaded(left, truth=False), matcher, assignments))
    return Match(*_core.match_arrays(left, right, matcher, assignments, noise, white))


def portrait(
    capture: Union[_core.Capture, Path],
    *,
    mode: str = "auto",
    matcher: str = "split",
    options: Overrides = (),
    mask: Optional[npt.ArrayLike] = None,
    faces: Iterable[tuple[float, float, float, float]] = (),
    zoom: bool = False,
    seed: int = 1,
    disparity: Optional[npt.ArrayLike] = None,
    confidence: Optional[npt.ArrayLike] = None,
    sigma: Optional[npt.ArrayLike] = None,
) -> _core.PortraitResult:
    """The portrait mode, all stages: burst, disparity, mask, smoothing, blur, noise. Truth is never used.

    capture  or the path of a photograph of people: JPEG, PNG, TIFF or DNG

    mode     "auto": "dp+seg" (disparity with a person mask) where there are views and people, "dp" (disparity alone)
             without people, "seg" (mask alone) without views
    options  e.g. {"layers.bands": 8}: what `dualpixel portrait --options` lists
    mask     of the person, 0 to 1, of the picture's shape; None: people are found where the mode needs them
    faces    x, y, width, height in photosites of people to keep sharp
    zoom     the middle of the picture alone, two thirds as wide and high; mask, faces and disparity are the whole picture's

    disparity, confidence, sigma  of any method, in place of the matcher's: of the views' size, as those of `score`
    """
    if disparity is None and not (confidence is None and sigma is None):
        raise InputError("confidence and sigma: are those of a disparity, which is not given")
    people = [tuple(face) for face in faces]
    loaded = _loaded(capture, truth=False)
    return _core.portrait(
        loaded, mode, matcher, _assignments(options), mask, people, zoom, _seed(seed), disparity, confidence, sigma
    )


def score(
    capture: Union[_core.Capture, Path],
    *,
    disparity: Optional[npt.ArrayLike] = None,
    confidence: Optional[npt.ArrayLike] = None,
    sigma: Optional[npt.ArrayLike] = None,
    portrait: Optional[npt.ArrayLike] = None,
) -> dict[str, Any]:
    """Compares what any method found with the capture's truth. Only what is given is scored.

    disparity   DP pixels, of the sensor's size or the views'; not finite where nothing was found
    confidence  0 to 1, likewise
    sigma       predicted standard deviation of the disparity's error, likewise
    portrait    linear RGB, 1 where the capture clips, of the sensor's size; compared with the true photograph

    The dict has what `dualpixel score --json` prints: ["disparity"][region][figure] and ["image"][figure].
    """
    return _core.score(_loaded(capture, truth=True), disparity, confidence, sigma, portrait)
