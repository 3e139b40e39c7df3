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

    try:
        value = getattr(importlib.import_module(f"{__name__}.{_COMPILED[name]}"), name)
    except ImportError as error:
        if "_core" not in str(error):
            raise
        raise ImportError(
            f"dualpixel.{name} needs the compiled part, which is not beside {__file__}: "
            "pip install the project, or set PYTHONPATH to the build's build/release/python"
        ) from None
    globals()[name] = value
    return value
