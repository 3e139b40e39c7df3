"""Data sets that `dualpixel dataset` renders, with NumPy alone."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from typing import Any, Optional

import numpy as np

from .errors import InputError
from .pictures import Path, joined, read_exr, read_png
from .reader import camera_of, read_json

_READABLE = (".exr", ".npy", ".png")
_UNKEPT = "preview.png"


def _picture(path: str) -> np.ndarray:
    if path.endswith(".npy"):
        return np.load(path)
    if path.endswith(".png"):
        return read_png(path)
    channels = read_exr(path)
    return channels["Y"] if len(channels) == 1 and "Y" in channels else joined(channels, *"RGB")


class Dataset:
    """The rendered samples of a data set, by number: a map-style data set, as torch's DataLoader takes it.

    A sample is a dict: each picture that the recipe keeps as an array by its name (docs/dataset.md), and "name",
    "camera", "exposure", "statistics". Holds nothing but paths, so that workers get copies cheaply.

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
        if split not in (None, "train", "validation", "test"):
            raise InputError(f"split: {split!r}: must be 'train', 'validation', 'test' or None")
        plan = os.path.join(self.root, "plan.jsonl")
        if not os.path.exists(plan):
            raise InputError(f"{self.root}: is not a data set: it has no plan.jsonl")
        with open(plan, encoding="utf-8") as file:
            planned = [line["name"] for line in map(json.loads, file) if split in (None, line["split"])]
        self.names = [name for name in planned if os.path.exists(self._file(name))]

    def _file(self, name: str) -> str:
        return os.path.join(self.root, "samples", name, "sample.json")

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index: int) -> Any:
        name = self.names[index]
        document = read_json(self._file(name))
        sample: dict[str, Any] = {
            "name": name,
            "camera": camera_of(document),
            "exposure": document["exposure"],
            "statistics": document["statistics"],
        }
        files = {os.path.splitext(entry["path"])[0]: entry["path"] for entry in document["files"]
                 if entry["path"] != _UNKEPT and entry["path"].endswith(_READABLE)}
        for picture in files if self.keep is None else self.keep:
            if picture not in files:
                raise InputError(f"{self._file(name)}: has no picture {picture!r}; it has {', '.join(files)}")
            sample[picture] = _picture(os.path.join(self.root, "samples", name, files[picture]))
        return sample if self.transform is None else self.transform(sample)
