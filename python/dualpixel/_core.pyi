"""The compiled part: Wadhwa et al. 2018 behind NumPy arrays. Use it through `dualpixel`."""

from collections.abc import Callable, Sequence
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from .pictures import Path

__version__: str

_Floats = npt.NDArray[np.float32]
_Raw = npt.NDArray[np.uint16]

class Frame:
    """One frame of a burst: raw digital numbers, of shape (height, width), read-only."""

    @property
    def mosaic(self) -> Optional[_Raw]:
        """Bayer mosaic of the sensor's size; None in a capture of views alone."""
    @property
    def left(self) -> Optional[_Raw]:
        """None where the camera has no dual pixels."""
    @property
    def right(self) -> Optional[_Raw]: ...
    @property
    def seed(self) -> int: ...
    @property
    def camera_from_world(self) -> npt.NDArray[np.float64]:
        """4 x 4; points are columns, meters; x right, y down, z forward."""

class Truth:
    """Ground truth of the first frame on the sensor's grid, read-only. docs/capture.md defines it."""

    @property
    def depth(self) -> _Floats:
        """Planar depth from the entrance pupil, meters; infinite where nothing was hit."""
    @property
    def blur(self) -> _Floats:
        """Signed blur diameter, photosites; negative in front of the focus."""
    @property
    def disparity(self) -> _Floats:
        """DP pixels: right(x + d) = left(x); negative in front of the focus."""
    @property
    def normal(self) -> _Floats:
        """(height, width, 3), camera axes, unit length, towards the camera; 0 where nothing was hit."""
    @property
    def object_id(self) -> npt.NDArray[np.uint32]:
        """From 1, of the glTF node; 0 where nothing was hit."""
    @property
    def person_mask(self) -> _Floats: ...
    @property
    def valid(self) -> _Floats:
        """1 where the ray hit geometry."""
    @property
    def all_in_focus(self) -> Optional[_Floats]:
        """(height, width, 3): linear RGB through a pinhole, noiseless."""
    @property
    def photograph(self) -> Optional[_Floats]:
        """(height, width, 3): linear RGB through a pupil `photograph_aperture_scale` times as wide."""
    @property
    def left(self) -> Optional[_Floats]:
        """(height, width, 3): the view without the sensor's noise."""
    @property
    def right(self) -> Optional[_Floats]: ...
    @property
    def photograph_aperture_scale(self) -> float: ...
    @property
    def motion(self) -> list[_Floats]:
        """For each further frame (height, width, 2): where the first frame's points are in it, minus where they were."""

class Capture:
    """A capture in memory. Its arrays are read-only views of that memory, which they keep alive."""

    def __init__(self, path: Path, truth: bool = True) -> None:
        """Reads and verifies a capture's folder, or reads a photograph for `portrait`. Raises InputError."""
    @property
    def left(self) -> Optional[_Floats]:
        """The first frame's left view, (height, width) in DP pixels: 0 black, 1 white; None where there are none."""
    @property
    def right(self) -> Optional[_Floats]: ...
    @property
    def frames(self) -> list[Frame]: ...
    @property
    def truth(self) -> Optional[Truth]: ...
    @property
    def camera(self) -> dict[str, Any]:
        """`camera` of capture.json: width_px, height_px, dp_downsample_x, focal_length_mm, alpha, ..."""
    @property
    def exposure(self) -> dict[str, Any]: ...
    @property
    def provenance(self) -> dict[str, Any]: ...
    @property
    def face_px(self) -> Optional[list[float]]:
        """x, y, width, height in photosites."""
    def write(self, path: Path) -> None:
        """Writes a capture's folder, in one step."""

class PortraitResult:
    """What the pipeline makes. Arrays are views of its memory, of the sensor's size unless said."""

    @property
    def input(self) -> _Floats:
        """(height, width, 3): linear RGB before the blur."""
    @property
    def portrait(self) -> _Floats:
        """(height, width, 3): linear RGB."""
    @property
    def portrait_srgb(self) -> _Floats:
        """The same, exposed and encoded for display, 0 to 1."""
    @property
    def disparity(self) -> Optional[_Floats]:
        """Smoothed, DP pixels; None in mode seg."""
    @property
    def confidence(self) -> Optional[_Floats]: ...
    @property
    def matched_disparity(self) -> Optional[_Floats]:
        """Not smoothed, of the views' size."""
    @property
    def matched_confidence(self) -> Optional[_Floats]: ...
    @property
    def matched_sigma(self) -> Optional[_Floats]: ...
    @property
    def mask(self) -> Optional[_Floats]:
        """Of the person, 0 to 1; None in mode dp."""
    @property
    def blur_radius(self) -> _Floats:
        """Photosites."""
    @property
    def focus_disparity(self) -> float: ...
    @property
    def warnings(self) -> list[str]:
        """What makes the result less good than it could be, a line each."""
    @property
    def json(self) -> dict[str, Any]:
        """What result.json holds: format, version, provenance, focus_disparity_dp_px, base_frame, stages."""
    @property
    def provenance(self) -> dict[str, Any]:
        """How it was made. Names the capture where it was read from a folder or written to one."""
    def write(self, path: Path) -> None:
        """Writes a result's folder, as `dualpixel portrait` does."""

def simulate(
    text: str, path: str, overrides: Sequence[str], progress: Optional[Callable[[str, float], None]]
) -> Capture: ...
def lens(
    text: str,
    path: str,
    overrides: Sequence[str],
    focus_distance_m: Optional[float],
    width_px: Optional[int],
    height_px: Optional[int],
    pixel_pitch_um: Optional[float],
) -> dict[str, Any]: ...
def match_arrays(
    left: npt.ArrayLike,
    right: npt.ArrayLike,
    matcher: str,
    options: Sequence[str],
    noise: Optional[tuple[float, float]],
    white: float,
) -> tuple[_Floats, _Floats, Optional[_Floats]]: ...
def match_capture(
    capture: Capture, matcher: str, options: Sequence[str]
) -> tuple[_Floats, _Floats, Optional[_Floats]]: ...
def portrait(
    capture: Capture,
    mode: str,
    matcher: str,
    options: Sequence[str],
    mask: Optional[npt.ArrayLike],
    faces: Sequence[tuple[float, float, float, float]],
    zoom: bool,
    seed: int,
    disparity: Optional[npt.ArrayLike],
    confidence: Optional[npt.ArrayLike],
    sigma: Optional[npt.ArrayLike],
) -> PortraitResult: ...
def score(
    capture: Capture,
    disparity: Optional[npt.ArrayLike],
    confidence: Optional[npt.ArrayLike],
    sigma: Optional[npt.ArrayLike],
    portrait: Optional[npt.ArrayLike],
) -> dict[str, Any]: ...
