"""Data sets that `dualpixel dataset` renders, with NumPy alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any, Optional

import numpy as np

from .errors import InputError
from .fields import Fields, parse_json, read_json
from .pictures import Path, joined, read_exr, read_png
from .reader import camera_of, exposure_of

_READABLE = (".exr", ".npy", ".png")
_UNKEPT = "preview.png"
_SPLITS = ("train", "validation", "test")


def _array(path: str) -> np.ndarray:
    try:
        return np.array(np.load(path, mmap_mode="r"))  # mapped, a header cannot ask for more than the file holds
    except (OSError, ValueError, EOFError) as error:
        raise InputError(f"{path}: cannot be read: {' '.join(str(error).split())}") from error


def _picture(path: str) -> np.ndarray:
    if path.endswith(".npy"):
        return _array(path)
    if path.endswith(".png"):
        return read_png(path)
    channels = read_exr(path)
    if set(channels) not in ({"Y"}, set("RGB")):
        raise InputError(f"{path}: has the channels {', '.join(sorted(channels))}: must have Y, or R, G and B")
    return channels["Y"] if "Y" in channels else joined(channels, *"RGB")


def _planned(plan: str, split: Optional[str]) -> list[str]:
    """Names of the split's samples."""
    names = []
    with open(plan, encoding="utf-8", errors="replace") as file:
        for number, text in enumerate(file, 1):
            line = Fields(parse_json(text, f"{plan}: line {number}"), f"{plan}: line {number}")
            name = line.path("name")
            if line.choice("split", *_SPLITS) == split or split is None:
                names.append(name)
    return names


class Dataset:
    """The rendered samples of a data set, by number: a map-style data set, as torch's DataLoader takes it.

    A sample is a dict: each EXR, NPY and PNG that the recipe keeps as an array by its name (docs/dataset.md), and "name",
    "camera", "exposure", "statistics"; the JPEG of the layout "google" is left out. Holds nothing but paths, so that workers get copies cheaply.

    root       the folder of `dualpixel dataset`; what is rendered when the object is made counts
    split      "train", "validation" or "test"; None: all
    keep       pictures to read, by name; None: all
    transform  called with each sample; what it returns is returned
    """

    def __init__(
        self,
        root: Path,
        split: Optional[str] = None,
        *,
        keep: Optional[Sequence[str]] = None,
        transform: Optional[Callable[[dict[str, Any]], Any]] = None,
    ):
        self.root, self.split, self.keep, self.transform = os.fspath(root), split, keep, transform
        if split not in (None, *_SPLITS):
            raise InputError(f"split: {split!r}: must be 'train', 'validation', 'test' or None")
        plan = os.path.join(self.root, "plan.jsonl")
        if not os.path.exists(plan):
            raise InputError(f"{self.root}: is not a data set: it has no plan.jsonl")
        self.names = [name for name in _planned(plan, split) if os.path.exists(self._file(name))]

    def _file(self, name: str) -> str:
        return os.path.join(self.root, "samples", name, "sample.json")

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index: int) -> Any:
        name = self.names[index]
        document = Fields(read_json(self._file(name)), self._file(name))
        sample: dict[str, Any] = {
            "name": name,
            "camera": camera_of(document),
            "exposure": exposure_of(document),
            "statistics": document.object("statistics").document,
        }
        paths = [entry.path("path") for entry in document.objects("files")]
        files = {os.path.splitext(path)[0]: path for path in paths if path != _UNKEPT and path.endswith(_READABLE)}
        for picture in files if self.keep is None else self.keep:
            if picture not in files:
                raise InputError(f"{self._file(name)}: has no picture {picture!r}; it has {', '.join(files)}")
            sample[picture] = _picture(os.path.join(self.root, "samples", name, files[picture]))
        return sample if self.transform is None else self.transform(sample)
