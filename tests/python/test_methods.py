"""Matching, portraits, scores and lenses from Python."""

import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import dualpixel
from conftest import SCENES, SMALL
from dualpixel import _core


def texture(width, height, seed=1):
    """Noise blurred to about two pixels, around 0.3."""
    noise = np.random.default_rng(seed).normal(size=(height, width))
    kernel = np.exp(-np.arange(-4, 5) ** 2 / 4.0)
    for axis in (0, 1):
        noise = np.apply_along_axis(lambda line: np.convolve(line, kernel / kernel.sum(), "same"), axis, noise)
    return (0.3 + 0.3 * noise).astype(np.float32)


@pytest.mark.parametrize("matcher", ["paper", "likelihood", "split"])
def test_match_finds_a_shift(matcher):
    wide = texture(200, 96)
    left, right = wide[:, 8:-8], wide[:, 7:-9]  # right(x + 1) = left(x)
    found = dualpixel.match(left, right, matcher=matcher)
    assert found.disparity.shape == left.shape
    # a whole pixel needs no interpolation, and there is no noise
    assert abs(np.median(found.disparity[16:-16, 16:-16]) - 1) < 0.02
    assert (found.sigma is None) == (matcher == "paper")


def test_match_takes_options_and_refuses_others():
    view = texture(64, 64)
    dualpixel.match(view, view, options={"split_match.range_px": 12})
    with pytest.raises(dualpixel.InputError, match="split_match.range_px"):
        dualpixel.match(view, view, options={"split_match.range_px": -4})
    with pytest.raises(dualpixel.InputError, match="match.range_px: matcher split does not use it"):
        dualpixel.match(view, view, options={"match.range_px": 4})
    with pytest.raises(dualpixel.InputError, match="did you mean 'likelihood'"):
        dualpixel.match(view, view, matcher="likelyhood")
    with pytest.raises(dualpixel.InputError, match="^left: an array of 1 axes"):
        dualpixel.match(view[0], view)


@pytest.mark.parametrize("matcher", ["paper", "likelihood", "split"])
def test_match_takes_views_of_one_channel(matcher):
    view = np.stack(3 * [texture(64, 64)], axis=-1)
    with pytest.raises(dualpixel.InputError, match="^disparity: left view: 3 channels: must have one$"):
        dualpixel.match(view, view, matcher=matcher)


def test_what_is_no_capture_is_refused():
    with pytest.raises(dualpixel.InputError, match="^capture: a dict: must be a Capture, or the path of its folder$"):
        dualpixel.score({"left": None}, disparity=np.zeros((4, 4)))


def test_match_of_a_capture_is_the_portraits(capture):
    np.testing.assert_array_equal(
        dualpixel.match(capture).disparity, dualpixel.portrait(capture).matched_disparity
    )


def test_portrait_is_the_programs(program, capture, folder, tmp_path):
    done = program("portrait", folder, "-o", tmp_path / "program", "--seed", 3)
    assert done.returncode == 0, done.stderr
    result = dualpixel.portrait(capture, seed=3)
    result.write(tmp_path / "python")
    for name in ("portrait.exr", "maps.exr", "matched.exr", "portrait.png"):
        assert (tmp_path / "program" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    assert result.mask is None and result.portrait.shape == (96, 128, 3)


@pytest.mark.slow
def test_portrait_says_what_result_json_does(program, folder, tmp_path):
    """The program's, but for times, memory and paths."""
    done = program("portrait", folder, "-o", tmp_path / "program", "--seed", 3, "--set", "split_match.range_px=12")
    assert done.returncode == 0, done.stderr
    result = dualpixel.portrait(folder, seed=3, options={"split_match.range_px": 12})
    expected = json.loads((tmp_path / "program/result.json").read_text())
    assert result.json["provenance"] == expected["provenance"]
    for field in ("format", "version", "focus_disparity_dp_px", "base_frame"):
        assert result.json[field] == expected[field], field
    assert [stage["name"] for stage in result.json["stages"]] == [stage["name"] for stage in expected["stages"]]
    assert result.warnings == expected["provenance"].get("warnings", [])
    # what is written can be told from another capture's
    result.write(tmp_path / "python")
    assert json.loads((tmp_path / "python/result.json").read_text()) == result.json
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    document = json.loads((other / "capture.json").read_text())
    document["camera"]["name"] = "another"
    (other / "capture.json").write_text(json.dumps(document))
    assert "is not a result of" in program("score", other, tmp_path / "python").stderr
    assert "capture" not in dualpixel.portrait(dualpixel.simulate(SCENES / "slanted_planes.json", SMALL)).provenance


def test_portrait_takes_a_disparity(capture):
    plain = dualpixel.portrait(capture, matcher="paper")
    given = dualpixel.portrait(capture, disparity=plain.matched_disparity, confidence=plain.matched_confidence)
    np.testing.assert_array_equal(given.portrait, plain.portrait)
    np.testing.assert_array_equal(given.disparity, plain.disparity)
    assert "matcher" not in given.provenance
    with pytest.raises(dualpixel.InputError, match="disparity: 3 x 2 pixels .* must be one channel of 64 x 24"):
        dualpixel.portrait(capture, disparity=np.zeros((2, 3)))
    with pytest.raises(dualpixel.InputError, match="split_match.range_px: disparity is given"):
        dualpixel.portrait(capture, disparity=np.zeros((24, 64)), options={"split_match.range_px": 12})
    with pytest.raises(dualpixel.InputError, match="not given"):
        dualpixel.portrait(capture, sigma=np.ones((24, 64)))
    with pytest.raises(dualpixel.InputError, match="mode seg: uses no disparity"):
        dualpixel.portrait(capture, mode="seg", mask=np.ones((96, 128)), disparity=np.zeros((24, 64)))


def test_portrait_takes_a_mask(capture):
    mask = np.zeros((96, 128))
    mask[30:70, 40:80] = 1
    np.testing.assert_array_equal(dualpixel.portrait(capture, mode="dp+seg", mask=mask).mask, mask)
    with pytest.raises(dualpixel.InputError, match="every value must lie in"):
        dualpixel.portrait(capture, mode="dp+seg", mask=2 * mask)
    with pytest.raises(dualpixel.InputError, match="mode dp: uses no person mask"):
        dualpixel.portrait(capture, mode="dp", mask=mask)
    with pytest.raises(dualpixel.InputError, match="mask: 96 x 128 pixels; must have the shape of the picture"):
        dualpixel.portrait(capture, mode="dp+seg", mask=mask.T)


def test_score_of_known_errors(capture):
    truth = capture.truth
    scored = dualpixel.score(capture, disparity=truth.disparity + 0.3, sigma=np.full((96, 128), 0.2))
    everything = scored["disparity"]["everything"]
    assert everything["bias_px"] == pytest.approx(0.3, abs=1e-6)
    assert everything["rmse_affine_px"] == pytest.approx(0, abs=1e-4)  # the fit's ridge of 1e-5 is left
    assert everything["within_one_sigma"] == 0 and everything["within_two_sigma"] == 1
    assert "image" not in scored
    only_portrait = dualpixel.score(capture, portrait=truth.photograph)
    assert "disparity" not in only_portrait and only_portrait["image"]["psnr_db"] is None
    with pytest.raises(dualpixel.InputError, match="^capture: nothing to score"):
        dualpixel.score(capture)
    with pytest.raises(dualpixel.InputError, match=r"disparity: 5 x 4 pixels .*; portrait: 5 x 4"):
        dualpixel.score(capture, disparity=np.zeros((4, 5)), portrait=np.zeros((4, 5, 3)))


def test_score_is_the_programs(program, folder, tmp_path):
    disparity = texture(64, 24)
    np.save(tmp_path / "d.npy", disparity)
    done = program("score", folder, "--disparity", tmp_path / "d.npy", "--json")
    expected = json.loads(done.stdout)
    del expected["capture"]
    assert dualpixel.score(folder, disparity=disparity) == expected


def test_lens_is_the_programs(program):
    path = (SCENES / "../lens_models/phone_thin_4.4mm_f1.8.json").resolve()
    assert dualpixel.lens(path, focus_distance_m=0.5) == json.loads(
        program("lens", path, "--focus-distance-m", 0.5, "--json").stdout
    )
    assert dualpixel.lens(json.loads(path.read_text()), {"f_number": 4})
    camera = SCENES / "cameras/phone_2019.json"
    assert dualpixel.lens(camera) == json.loads(program("lens", camera, "--json").stdout)
    with pytest.raises(dualpixel.InputError, match="^lens: /f_number"):
        dualpixel.lens(json.loads(path.read_text()), {"f_number": -4})


def test_overrides_may_be_numpys():
    path = (SCENES / "../lens_models/phone_thin_4.4mm_f1.8.json").resolve()
    plain = dualpixel.lens(path, {"f_number": 4, "split": {"model": "ramp", "k": 1.5}})
    split = {"model": "ramp", "k": np.float32(1.5)}
    assert dualpixel.lens(path, {"f_number": np.int64(4), "split": split}) == plain
    tiny = {**SMALL, "sensor.width_px": np.uint16(16), "sensor.height_px": 12, "render.samples_per_pixel": 1}
    light = {"environment.model": "constant", "environment.nits": np.array([1, 2.5, 4], dtype=np.float32)}
    scene = dualpixel.simulate(SCENES / "slanted_planes.json", {**tiny, **light}, seed=np.int32(3)).provenance["scene"]
    assert scene["environment"]["nits"] == [1, 2.5, 4] and scene["render"]["seed"] == 3
    with pytest.raises(dualpixel.InputError, match="^f_number: Object of type set is not JSON serializable: must be"):
        dualpixel.lens(path, {"f_number": {4}})
    for seed in (True, 1.5, -1, "1"):
        with pytest.raises(dualpixel.InputError, match="^seed: .*: must be an integer in"):
            dualpixel.simulate(SCENES / "slanted_planes.json", tiny, seed=seed)


@pytest.mark.parametrize(
    "field, value, allowed",
    [
        ("pixel_pitch_um", float("nan"), "nan: must be a number in [0.1, 1000]"),
        ("pixel_pitch_um", 1e300, "1e+300: must be a number in [0.1, 1000]"),
        ("pixel_pitch_um", 0, "0: must be a number in [0.1, 1000]"),
        ("focus_distance_m", float("nan"), "nan: must be a number in [0.001, inf]"),
        ("width_px", -5, "-5: must be an integer in [2, 32768]"),
        ("height_px", 2**30, "1073741824: must be an integer in [2, 32768]"),
    ],
)
def test_lens_refuses_what_is_no_sensor(field, value, allowed):
    path = (SCENES / "../lens_models/phone_thin_4.4mm_f1.8.json").resolve()
    with pytest.raises(dualpixel.InputError) as error:
        dualpixel.lens(path, **{field: value})
    assert str(error.value) == f"{path}: {field}: {allowed}"


def test_stubs_name_what_there_is():
    stub = ast.parse((Path(_core.__file__).parent / "_core.pyi").read_text())
    for node in stub.body:
        if isinstance(node, ast.ClassDef):
            own = {entry.name for entry in node.body if isinstance(entry, ast.FunctionDef)} - {"__init__"}
            there = {name for name in dir(getattr(_core, node.name)) if not name.startswith("_")}
            assert own == there, node.name
    named = {node.name for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    assert named == {name for name in dir(_core) if not name.startswith("_")}
    assert set(dualpixel.__all__) == {name for name in dualpixel.__all__ if hasattr(dualpixel, name)}


@pytest.mark.slow
def test_the_example_draws_its_curves(tmp_path):
    pytest.importorskip("matplotlib")
    example = Path(__file__).resolve().parents[2] / "python/examples/failure_curve.py"
    done = subprocess.run(
        [sys.executable, example, SCENES / "slanted_planes.json", tmp_path / "curves.png"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "likelihood: RMSE" in done.stdout
    assert (tmp_path / "curves.png").stat().st_size > 10_000


STEP_DP_PX = 4.0


def write_pixel4_pair(folder, height, width):
    """001, as Xin et al. 2021 have it: the right half lies STEP_DP_PX behind the left one."""
    cv2 = pytest.importorskip("cv2")
    random = np.random.default_rng(3)
    texture = cv2.GaussianBlur(random.random((height, width)).astype(np.float32), (0, 0), 4)
    texture = (texture - texture.min()) / np.ptp(texture)
    edge = np.arange(width) < width // 2
    views = {"left": texture, "right": np.where(edge, texture, np.roll(texture, int(STEP_DP_PX), 1))}
    (folder / "gt_defocus_map").mkdir(parents=True)
    for name, view in views.items():
        cv2.imwrite(str(folder / f"001_{name}.png"), (1024 + 8000 * view).astype(np.uint16))
    truth = np.tile(np.where(edge, 100, 200), (height, 1))[height // 6 : -(height // 6), width // 6 : -(width // 6)]
    cv2.imwrite(str(folder / "gt_defocus_map/001_gt.png"), truth.astype(np.uint8))


def run_example(name, *arguments):
    example = Path(__file__).resolve().parents[2] / "python/examples" / name
    return subprocess.run(
        [sys.executable, example, os.environ["DUALPIXEL_PROGRAM"], *arguments],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_the_example_ranks_matchers_on_pairs_with_a_truth(tmp_path):
    write_pixel4_pair(tmp_path / "pairs", 384, 576)
    done = run_example("rank_matchers.py", tmp_path / "work", "--pixel4", tmp_path / "pairs")
    assert done.returncode == 0, done.stderr
    scores = {line.split()[0]: float(line.split()[1]) for line in done.stdout.splitlines()[1:]}
    assert set(scores) == {"paper", "likelihood", "averaged", "low_passed", "A", "B", "C", "split"}
    # What sees nothing has an AIWE(1) of .2, half of the truth's step. No edge of the picture stops the smoothing at it.
    for name in ("averaged", "low_passed", "A", "B", "C"):  # the others are the product's
        assert scores[name] < (200 - 100) / 255 / 2 / 2, name
        found = np.load(tmp_path / f"work/real_001_{name}.npy")
        quarter = found.shape[1] // 4
        assert found[:, -quarter:].mean() - found[:, :quarter].mean() > STEP_DP_PX / 2, name


@pytest.mark.slow
def test_the_example_leaves_one_camera_out(tmp_path):
    """Of two, each chooses for the other what errs least with itself."""
    cv2 = pytest.importorskip("cv2")
    height, width = 192, 288
    write_pixel4_pair(tmp_path / "pixel4", height, width)
    scene = tmp_path / "dp119/box/001"  # the same, of 8 bits and with depth for disparity
    scene.mkdir(parents=True)
    for name, side in (("l.png", "left"), ("r.png", "right")):
        view = cv2.imread(str(tmp_path / f"pixel4/001_{side}.png"), -1) / 65535
        cv2.imwrite(str(scene / name), np.rint(255 * view ** (1 / 2.2)).astype(np.uint8))
    depth = np.tile(np.where(np.arange(width) < width // 2, 51, 102), (height, 1)).astype(np.uint8)
    cv2.imwrite(str(scene / "d.png"), depth)
    cameras = ["--pixel4", tmp_path / "pixel4", "--dp119", tmp_path / "dp119", "--cameras", "pixel4,dp119"]
    done = run_example("leave_one_camera_out.py", tmp_path / "work", *cameras)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines() if line]
    varied = {(line[0], line[1]): [float(value) for value in line[-2:]] for line in lines[2:-3]}
    assert len(varied) == 14 and varied["window_px", "12"] == varied["low_pass_px", "4.5"]
    assert varied["window_px", "9"] != varied["window_px", "12"]
    for line, other in zip(lines[-2:], (1, 0)):
        for constant, value in zip(line[1:-2:2], line[2:-2:2]):
            least = min(both[other] for (name, _), both in varied.items() if name == constant)
            assert varied[constant, value.rstrip(",:")][other] == least, (line[0], constant)
    again = run_example("leave_one_camera_out.py", tmp_path / "work", *cameras)
    assert again.stdout == done.stdout and again.stderr == ""  # nothing is measured twice


@pytest.mark.parametrize(
    "arguments, refusal",
    [
        (["--cameras", "thin,pixel4"], "--cameras: pixel4: must be of thin, prescription, scenes"),
        (["--cameras", "thin"], "--cameras: must name two at least"),
        (["--cameras", "thin,pixel4", "--pixel4", "."], "has no 001_left.png"),
        (["--scenes", "0"], "--scenes: 0: must be at least 1"),
    ],
)
def test_the_example_that_leaves_one_camera_out_refuses_what_it_cannot_use(tmp_path, arguments, refusal):
    pytest.importorskip("cv2")
    done = run_example("leave_one_camera_out.py", tmp_path / "work", *arguments)
    assert done.returncode == 2
    assert refusal in done.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    "arguments, refusal",
    [
        ([], "--pixel4 or --rendered is required"),
        (["--rendered", "--methods", "A, D"], "--methods: D: must be of paper, likelihood"),
        (["--rendered", "--methods", ""], "--methods: : must be of paper, likelihood"),
        (["--rendered", "--size", "1000"], "--size: 1000: must be a multiple of 32"),
        (["--pixel4", "."], "has no 001_left.png"),
    ],
)
def test_the_example_that_ranks_matchers_refuses_what_it_cannot_use(tmp_path, arguments, refusal):
    pytest.importorskip("cv2")
    done = run_example("rank_matchers.py", tmp_path / "work", *arguments)
    assert done.returncode == 2
    assert refusal in done.stderr.splitlines()[-1]
