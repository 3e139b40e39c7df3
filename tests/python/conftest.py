"""Fixtures: the program, and a small capture of slanted planes with a burst of two frames."""

import json
import os
import subprocess
from pathlib import Path

import pytest

import dualpixel

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"  # OpenCV reads no EXR without it

SCENES = Path(os.environ["DUALPIXEL_SCENES_DIR"])
SMALL = {
    "sensor.width_px": 128,
    "sensor.height_px": 96,
    "sensor.pixel_pitch_um": 1.4 * 2688 / 128 / 4,
    "burst.frames": 2,
    "render.samples_per_pixel": 16,
    "render.photograph_samples_per_pixel": 16,
}


def run_program(*arguments):
    """`dualpixel ARGUMENTS`: status, stdout and stderr."""
    return subprocess.run(
        [os.environ["DUALPIXEL_PROGRAM"], *map(str, arguments)], capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="session")
def program():
    return run_program


@pytest.fixture(scope="session")
def scene():
    """A scene as a dict, its paths made absolute."""
    path = SCENES / "slanted_planes.json"
    document = json.loads(path.read_text())
    document["gltf"] = str(SCENES / document["gltf"])
    document["lens"]["file"] = str((SCENES / document["lens"]["file"]).resolve())
    return document


@pytest.fixture(scope="session")
def capture(scene):
    return dualpixel.simulate(scene, SMALL, seed=7)


@pytest.fixture(scope="session")
def folder(capture, tmp_path_factory):
    """The same as a folder."""
    path = tmp_path_factory.mktemp("captures") / "capture"
    capture.write(path)
    return path
