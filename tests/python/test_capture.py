"""Captures: what simulate gives, its memory, and the reader that needs NumPy alone."""

import gc
import json
import os
import shutil
import struct
import subprocess
import sys
import threading
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

import dualpixel
from conftest import SCENES, SMALL
from dualpixel import reader
from dualpixel.pictures import read_exr, read_png

TRUTH = ("depth", "blur", "disparity", "normal", "object_id", "person_mask", "valid", "all_in_focus", "photograph")


@pytest.mark.slow
def test_simulates_the_bytes_of_the_program(program, capture, tmp_path):
    overrides = [word for field, value in SMALL.items() for word in ("--set", f"{field}={value}")]
    done = program("simulate", SCENES / "slanted_planes.json", "-o", tmp_path / "program", "--seed", 7, *overrides)
    assert done.returncode == 0, done.stderr
    dualpixel.simulate(SCENES / "slanted_planes.json", SMALL, seed=7).write(tmp_path / "python")
    for path in sorted((tmp_path / "program").rglob("*")):
        if path.is_file():
            other = tmp_path / "python" / path.relative_to(tmp_path / "program")
            assert path.read_bytes() == other.read_bytes(), path
    of_a_dict = [np.array_equal(a, b) for a, b in zip(raws(capture), raws(dualpixel.Capture(tmp_path / "program")))]
    assert all(of_a_dict)


def raws(capture):
    return [getattr(frame, name) for frame in capture.frames for name in ("mosaic", "left", "right")]


def test_arrays_have_shapes_and_types(capture):
    assert capture.left.shape == (24, 64) and capture.left.dtype == np.float32
    assert capture.truth.disparity.shape == (96, 128) and capture.truth.disparity.dtype == np.float32
    assert capture.truth.normal.shape == (96, 128, 3)
    assert capture.truth.object_id.dtype == np.uint32
    assert capture.frames[1].mosaic.dtype == np.uint16
    assert capture.camera["width_px"] == 128
    # d = alpha b, and one DP pixel is dp_downsample_x photosites (docs/capture.md)
    expected = capture.camera["alpha"] / capture.camera["dp_downsample_x"] * capture.truth.blur
    np.testing.assert_allclose(capture.truth.disparity, expected, atol=1e-5)
    signal = (capture.frames[0].left.astype(float) - capture.exposure["black_level_dn"]) / (
        capture.exposure["white_level_dn"] - capture.exposure["black_level_dn"]
    )
    np.testing.assert_allclose(capture.left, signal, atol=1e-6)


def test_arrays_are_the_captures_own_memory_and_outlive_it(folder):
    capture = dualpixel.Capture(folder)
    disparity, frame = capture.truth.disparity, capture.frames[0]
    assert np.shares_memory(disparity, capture.truth.disparity)
    assert not disparity.flags.writeable and not disparity.flags.owndata
    kept = disparity.copy()
    del capture
    gc.collect()
    np.testing.assert_array_equal(disparity, kept)
    assert frame.left.mean() > 0


def test_other_threads_run_while_it_renders(scene):
    ticks, done = 0, threading.Event()

    def tick():
        nonlocal ticks
        while not done.wait(0.001):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    before = time.monotonic()
    dualpixel.simulate(scene, SMALL)
    elapsed = time.monotonic() - before
    done.set()
    thread.join()
    # With the lock held nothing would tick. On a machine full of work a tick of 1 ms may take a hundred.
    assert ticks > elapsed / 0.1


def test_progress_is_reported_and_may_end_the_work(scene):
    stages = set()
    dualpixel.simulate(scene, SMALL, progress=lambda stage, fraction: stages.add(stage))
    assert stages

    def stop(stage, fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dualpixel.simulate(scene, SMALL, progress=stop)


def test_errors_have_the_programs_text(program, scene, tmp_path):
    bad = SCENES / "slanted_planes.json"
    for field, value in (("camera.focus_distance_m", -1), ("camera.focal_lenght_mm", 4)):
        done = program("simulate", bad, "-o", tmp_path / "c", "--set", f"{field}={value}")
        with pytest.raises(dualpixel.InputError) as error:
            dualpixel.simulate(bad, {field: value})
        assert done.stderr == f"dualpixel: {error.value}\n"
    with pytest.raises(dualpixel.InputError, match="^scene: /camera/focus_distance_m: -1: must be a number"):
        dualpixel.simulate(scene, {"camera.focus_distance_m": -1})
    with pytest.raises(ValueError, match="no such folder"):
        dualpixel.Capture(tmp_path / "nowhere")


def test_warnings_of_a_scene_are_pythons(scene):
    dark = {"environment": {"model": "constant", "nits": [1e-4] * 3}, "unlit_white_nits": 1e-3}
    with pytest.warns(UserWarning, match=r"slanted_planes.glb: exposure: .* are asked for; the limit is 10.7 s"):
        dualpixel.simulate(scene["gltf"], {**SMALL, **dark})


def test_infinity_goes_in_and_out(scene):
    capture = dualpixel.simulate(scene, {**SMALL, "camera.focus_distance_m": float("inf"), "burst.frames": 1})
    assert capture.camera["focus_distance_m"] == float("inf")


def test_the_numpy_reader_gives_the_same(folder):
    compiled, plain = dualpixel.Capture(folder), reader.Capture(folder)
    for name in TRUTH:
        np.testing.assert_array_equal(getattr(plain.truth, name), getattr(compiled.truth, name), name)
    for a, b in zip(plain.frames, compiled.frames):
        for name in ("mosaic", "left", "right", "camera_from_world", "seed"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), name)
    np.testing.assert_array_equal(plain.left, compiled.left)
    np.testing.assert_array_equal(plain.right, compiled.right)
    for name in ("camera", "exposure", "provenance", "face_px"):
        assert getattr(plain, name) == getattr(compiled, name), name
    assert plain.truth.disparity.flags.writeable


def test_the_numpy_reader_fills_in_what_may_be_left_out(folder, tmp_path):
    document = json.loads((folder / "capture.json").read_text())
    for field in ("name", "cfa", "dp_downsample_x", "dp_downsample_y", "split", "alpha", "principal_point_px"):
        document["camera"].pop(field)
    for field in ("time_s", "iso", "mosaic_noise", "dp_noise", "white_balance", "lux_s_per_unit"):
        document["exposure"].pop(field, None)
    document.pop("files")
    for name in ("frames", "truth"):
        shutil.copytree(folder / name, tmp_path / name)
    (tmp_path / "capture.json").write_text(json.dumps(document))
    plain, compiled = reader.Capture(tmp_path), dualpixel.Capture(tmp_path)
    assert plain.camera == compiled.camera
    assert plain.exposure == compiled.exposure


def test_reads_without_the_compiled_part(folder):
    source = Path(__file__).resolve().parents[2] / "python"
    code = (
        f"import dualpixel; from dualpixel import reader; c = reader.Capture({str(folder)!r});"
        "print(c.left.shape, c.truth.disparity.shape)\n"
        "try: dualpixel.simulate({})\nexcept ImportError: print('no compiled part')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(source)}
    )
    assert done.stdout == "(24, 64) (96, 128)\nno compiled part\n", done.stderr


def png(pixels, kinds):
    """A PNG whose lines have the filters `kinds`, written byte by byte as the specification has it (section 9)."""
    height, width, channels = pixels.shape
    data = pixels.astype(">u2" if pixels.dtype == np.uint16 else "u1").tobytes()
    step, size = channels * pixels.itemsize, width * channels * pixels.itemsize
    lines = b""
    for y in range(height):
        line = data[y * size : (y + 1) * size]
        above = data[(y - 1) * size : y * size] if y else bytes(size)
        kind = kinds[y % len(kinds)]
        lines += bytes([kind])
        for i in range(size):
            a, b, c = (line[i - step], above[i], above[i - step]) if i >= step else (0, above[i], 0)
            nearest = min((abs(a + b - c - v), order, v) for order, v in enumerate((a, b, c)))[2]
            lines += bytes([(line[i] - (0, a, b, (a + b) // 2, nearest)[kind]) % 256])
    chunk = lambda name, body: struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    color = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    head = struct.pack(">IIBBBBB", width, height, 8 * pixels.itemsize, color, 0, 0, 0)
    packed = zlib.compress(lines)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed[:9]) + chunk(b"IDAT", packed[9:]) + chunk(b"IEND", b"")


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_png_of_every_filter(tmp_path, channels, kind):
    pixels = np.random.default_rng(1).integers(0, np.iinfo(kind).max, (10, 7, channels), endpoint=True).astype(kind)
    (tmp_path / "p.png").write_bytes(png(pixels, [0, 1, 2, 3, 4]))
    read = read_png(tmp_path / "p.png")
    assert read.dtype == kind
    np.testing.assert_array_equal(read, pixels[:, :, 0] if channels == 1 else pixels)


def test_broken_files_are_refused_in_one_line(folder, tmp_path):
    files = [folder / "frames/000_left.png", folder / "truth/geometry.exr"]
    for path, read in zip(files, (read_png, read_exr)):
        data = path.read_bytes()
        for cut in (0, 3, 20, len(data) // 2):
            (tmp_path / "cut").write_bytes(data[:cut])
            with pytest.raises(dualpixel.InputError) as error:
                read(tmp_path / "cut")
            assert "\n" not in str(error.value) and str(tmp_path / "cut") in str(error.value)
    (tmp_path / "capture.json").write_text("{}")
    with pytest.raises(dualpixel.InputError, match="capture.json: /format: is required"):
        reader.Capture(tmp_path)
