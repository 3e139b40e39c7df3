"""Dual-pixel camera simulator and portrait pipeline: docs/python.md.

Captures and data sets can be read with NumPy alone (`dualpixel.reader`, `dualpixel.Dataset`); everything else needs the
compiled part, `dualpixel._core`.
"""

from typing import TYPE_CHECKING, Any

from .dataset import Dataset
from .errors import InputError

if TYPE_CHECKING:
    from ._core import Capture, Frame, PortraitResult, Truth
    from .api import Match, lens, match, portrait, score, simulate

_COMPILED = {
    **dict.fromkeys(("Capture", "Frame", "PortraitResult", "Truth"), "_core"),
    **dict.fromkeys(("Match", "lens", "match", "portrait", "score", "simulate"), "api"),
}

__all__ = ["Dataset", "InputError", *_COMPILED]


def __getattr__(name: str) -> Any:
    """Loads the compiled part when it is first used, so that the readers work without it."""
    if name not in _COMPILED:
        raise AttributeError(f"module 'dualpixel' has no attribute {name!r}")
    import importlib

    value = getattr(importlib.import_module(f"{__name__}.{_COMPILED[name]}"), name)
    globals()[name] = value
    return value
