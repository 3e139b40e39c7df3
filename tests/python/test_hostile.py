"""The NumPy reader on captures and data sets that are broken: one line that names file, field, value and what is allowed."""

import json
import shutil
import struct
import tracemalloc
import zlib

import numpy as np
import pytest

import dualpixel
from dualpixel import reader
from dualpixel.pictures import read_exr, read_png

ABSENT = object()


def read_all(path):
    """Everything that a capture holds."""
    capture = reader.Capture(path)
    for frame in capture.frames:
        assert frame.left is not None and frame.right is not None
        frame.mosaic
    for name in ("depth", "normal", "all_in_focus", "photograph", "left", "motion"):
        getattr(capture.truth, name)
    return capture


def refusal(path, read=read_all):
    with pytest.raises(dualpixel.InputError) as error:
        read(path)
    message = str(error.value)
    assert "\n" not in message
    return message


@pytest.fixture
def copy(folder, tmp_path):
    """A capture to break, and its document."""
    shutil.copytree(folder, tmp_path / "c")
    return tmp_path / "c", json.loads((tmp_path / "c/capture.json").read_text())


def changed(copy, pointer, value):
    """Sets a field of capture.json, or takes it away."""
    path, document = copy
    *parents, last = pointer.strip("/").split("/")
    entry = document
    for parent in parents:
        entry = entry[int(parent) if isinstance(entry, list) else parent]
    if value is ABSENT:
        del entry[last]
    else:
        entry[int(last) if isinstance(entry, list) else last] = value
    (path / "capture.json").write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    "pointer, value, expected",
    [
        ("/format", "other", "/format: \"other\": must be one of 'dualpixel-capture'"),
        ("/version", 2, "/version: 2: must be an integer in [1, 1]"),
        ("/camera", ABSENT, "/camera: is required"),
        ("/camera", [1], "/camera: must be an object"),
        ("/camera/width_px", "many", '/camera/width_px: "many": must be an integer in [2, 65536]'),
        ("/camera/width_px", 1e3, "/camera/width_px: 1000.0: must be an integer in [2, 65536]"),
        ("/camera/height_px", True, "/camera/height_px: true: must be an integer in [4, 65536]"),
        ("/camera/dp_downsample_x", 0, "/camera/dp_downsample_x: 0: must be an integer in [1, 16]"),
        ("/camera/dp_downsample_x", 3, "/camera/dp_downsample_x: 3: must divide the 128 photosites"),
        ("/camera/focus_distance_m", None, "/camera/focus_distance_m: null: must be a number in [0.0001, inf]"),
        ("/camera/f_number", "inf", '/camera/f_number: "inf": must be a number in [0.1, 1e+06]'),
        ("/camera/principal_point_px", [1], "/camera/principal_point_px: [1]: must be 2 finite numbers"),
        ("/exposure/white_level_dn", 0, "/exposure/black_level_dn: 64 must be below the white level 0"),
        ("/exposure/bits", 99, "/exposure/bits: 99: must be an integer in [8, 16]"),
        ("/exposure/dp_noise", 3, "/exposure/dp_noise: must be an object"),
        ("/face_px", [1, 2, 3], "/face_px: [1, 2, 3]: must be 4 finite numbers"),
        ("/frames", [], "/frames: must be an array of 1 to 1000 objects"),
        ("/frames", {}, "/frames: must be an array of 1 to 1000 objects"),
        ("/frames/1", 7, "/frames/1: must be an object"),
        ("/frames/0/left", ABSENT, "/frames/0/left: is required"),
        ("/frames/0/left", 5, "/frames/0/left: 5: must be a string"),
        ("/frames/0/right", "../r.png", '/frames/0/right: "../r.png": must be a path inside the folder'),
        ("/frames/0/mosaic", "/etc/passwd", '/frames/0/mosaic: "/etc/passwd": must be a path inside the folder'),
        ("/frames/0/left", "a\nb.png", '/frames/0/left: "a\\nb.png": must be a path inside the folder'),
        ("/frames/0/left", "\ud800.png", '/frames/0/left: "\\ud800.png": must be a path inside the folder'),
        ("/frames/0/camera_from_world", [0] * 15, "/frames/0/camera_from_world: " + str([0] * 15) + ": must be 16 finite"),
        ("/frames/0/seed", -1, "/frames/0/seed: -1: must be an integer in [0, 18446744073709551615]"),
        ("/truth", "none", "/truth: must be an object"),
        ("/truth/geometry", ABSENT, "/truth/geometry: is required"),
        ("/truth/photograph_aperture_scale", "x", '/truth/photograph_aperture_scale: "x": must be a number in [0.001, 1000]'),
        ("/truth/motion", "x", '/truth/motion: "x": must be an array of paths inside the folder'),
    ],
)
def test_fields_are_named(copy, pointer, value, expected):
    path = changed(copy, pointer, value)
    assert refusal(path).startswith(f"{path}/capture.json: {expected}")


@pytest.mark.parametrize(
    "text, expected",
    [
        (b"", "is not valid JSON: "),
        (b"[1]", "must be an object"),
        (b"\xff\xfe", "is not valid JSON: must be UTF-8"),
        (b'{"format": NaN}', "is not valid JSON: NaN is no number of JSON"),
        (b"[" * 100_000, "is not valid JSON: "),
    ],
)
def test_what_is_no_document_is_refused(copy, text, expected):
    (copy[0] / "capture.json").write_bytes(text)
    assert refusal(copy[0]).startswith(f"{copy[0]}/capture.json: {expected}")


def test_pictures_must_be_those_of_the_camera(copy):
    path, document = copy
    shutil.copy(path / document["frames"][0]["mosaic"], path / document["frames"][0]["left"])
    name = f"{path}/{document['frames'][0]['left']}"
    assert refusal(path) == f"{name}: 128 x 96: must be 64 x 24 pixels of one channel, as /camera says"
    shutil.copy(path / document["frames"][1]["left"], path / document["frames"][0]["left"])
    shutil.copy(path / document["truth"]["photograph"], path / document["truth"]["geometry"])
    assert refusal(path) == f"{path}/{document['truth']['geometry']}: has no channel 'Z'; it has B, G, R"
    (path / document["truth"]["geometry"]).unlink()
    assert refusal(path) == f"{path}/{document['truth']['geometry']}: cannot be read: No such file or directory"


@pytest.mark.slow
def test_any_byte_may_be_wrong(folder, tmp_path):
    """Either the picture is read, of its own size, or it is refused in one line."""
    rng = np.random.default_rng(3)
    for name, read in (("frames/000_left.png", read_png), ("truth/photograph.exr", read_exr)):
        data = bytearray((folder / name).read_bytes())
        for _ in range(300):
            broken = bytearray(data)
            for at in rng.integers(0, min(len(data), 600), 3):
                broken[at] = rng.integers(256)
            (tmp_path / "broken").write_bytes(broken)
            try:
                read(tmp_path / "broken")
            except dualpixel.InputError as error:
                assert "\n" not in str(error) and str(tmp_path / "broken") in str(error)


def gray_png(width, height, packed):
    chunk = lambda name, body: struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed)


@pytest.mark.parametrize(
    "width, height, packed, expected",
    [
        (2**31 - 1, 2**31 - 1, b"", "2147483647 x 2147483647 pixels: must be 1 to 65536 a side"),
        (65536, 65536, b"", "65536 x 65536 pixels: must be 1 to 65536 a side, and at most 2147483648 bytes in all"),
        (0, 4, zlib.compress(b""), "0 x 4 pixels: must be"),
        (4, 4, zlib.compress(bytes(3)), "3 bytes where 20 are needed"),
    ],
)
def test_sizes_that_no_file_holds_are_refused(tmp_path, width, height, packed, expected):
    (tmp_path / "p.png").write_bytes(gray_png(width, height, packed))
    assert expected in refusal(tmp_path / "p.png", read_png)


def test_no_more_is_unpacked_than_the_picture_needs(tmp_path):
    """A stream of 50 MB for a picture of 16 pixels."""
    (tmp_path / "p.png").write_bytes(gray_png(4, 4, zlib.compress(bytes(50_000_000))))
    tracemalloc.start()
    read_png(tmp_path / "p.png")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5_000_000


@pytest.fixture
def samples(tmp_path):
    """A data set of one sample with one picture, by hand."""
    camera = {"width_px": 4, "height_px": 4, "pixel_pitch_um": 1, "focal_length_mm": 4, "f_number": 2, "focus_distance_m": 1}
    exposure = {"bits": 10, "black_level_dn": 64, "white_level_dn": 1023}
    sample = {"camera": camera, "exposure": exposure, "statistics": {}, "files": [{"path": "left.npy"}]}
    (tmp_path / "samples/000000").mkdir(parents=True)
    (tmp_path / "plan.jsonl").write_text('{"name": "000000", "split": "train"}\n')
    (tmp_path / "samples/000000/sample.json").write_text(json.dumps(sample))
    np.save(tmp_path / "samples/000000/left.npy", np.zeros((1, 2), np.float32))
    return tmp_path, sample


def test_data_sets_name_what_is_wrong(samples):
    root, sample = samples
    read = lambda root: dualpixel.Dataset(root)[0]
    assert read(root)["left"].shape == (1, 2)

    (root / "plan.jsonl").write_text('{"name": "000000", "split": "train"}\n{"name": 4}\n')
    assert refusal(root, read) == f"{root}/plan.jsonl: line 2: /name: 4: must be a string"
    (root / "plan.jsonl").write_text('{"name": "../x", "split": "train"}\n')
    assert refusal(root, read) == f'{root}/plan.jsonl: line 1: /name: "../x": must be a path inside the folder'
    (root / "plan.jsonl").write_text("{\n")
    assert refusal(root, read).startswith(f"{root}/plan.jsonl: line 1: is not valid JSON: ")
    (root / "plan.jsonl").write_text('{"name": "000000", "split": "train"}\n')

    file = root / "samples/000000/sample.json"
    for field, value, expected in (
        ("exposure", ABSENT, "/exposure: is required"),
        ("statistics", 3, "/statistics: must be an object"),
        ("files", None, "/files: must be an array of objects"),
        ("files", [{"path": "/etc/passwd.png"}], '/files/0/path: "/etc/passwd.png": must be a path inside the folder'),
    ):
        broken = {name: entry for name, entry in {**sample, field: value}.items() if entry is not ABSENT}
        file.write_text(json.dumps(broken))
        assert refusal(root, read) == f"{file}: {expected}"
    file.write_text(json.dumps(sample))

    array = root / "samples/000000/left.npy"
    whole = array.read_bytes()
    for data in (b"", whole[:50], whole[:-1], whole.replace(b"(1, 2)", b"(9, 9)")):
        array.write_bytes(data)
        assert refusal(root, read).startswith(f"{array}: cannot be read: ")
    np.save(array, np.array([{}], dtype=object), allow_pickle=True)
    assert refusal(root, read).startswith(f"{array}: cannot be read: ")
