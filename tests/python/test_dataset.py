"""Data sets from Python."""

import json
import multiprocessing
import pickle

import numpy as np
import pytest

import dualpixel
from conftest import SCENES, SMALL


@pytest.fixture(scope="module", params=["exr", "npy"])
def rendered(request, program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("datasets")
    recipe = {
        "version": 1,
        "count": 4,
        "seed": 1,
        "scenes": [{"file": str(SCENES / "slanted_planes.json")}, {"file": str(SCENES / "occlusion_edges.json")}],
        "set": {**SMALL, "burst.frames": 1, "camera.focus_distance_m": {"uniform": [0.5, 1]}},
        "split": {"train": 0.5, "validation": 0, "test": 0.5},
        "layout": request.param,
        "keep": ["left", "right", "view_disparity_dp_px", "view_normal"],
    }
    (folder / "recipe.json").write_text(json.dumps(recipe))
    for command in (("plan", folder / "recipe.json", "-o", folder / "set"), ("render", folder / "set")):
        done = program("dataset", *command)
        assert done.returncode == 0, done.stderr
    return folder / "set"


def test_samples_are_what_was_rendered(rendered):
    samples = dualpixel.Dataset(rendered)
    assert len(samples) == 4
    sample = samples[0]
    assert sample["left"].shape == (24, 64) and sample["left"].dtype == np.float32
    assert sample["view_normal"].shape == (24, 64, 3)
    assert sample["camera"]["width_px"] == 128
    scene = json.loads((rendered / "samples" / sample["name"] / "sample.json").read_text())["provenance"]["scene"]
    capture = dualpixel.simulate(scene, folder=SCENES)
    np.testing.assert_array_equal(sample["left"], capture.left)
    # a view's truth is that of the photosite below and to the right of its pixel's center
    np.testing.assert_array_equal(sample["view_disparity_dp_px"], capture.truth.disparity[2::4, 1::2])


def test_opencv_reads_the_same(rendered):
    """OpenCV takes channels of other names than Y, R, G, B for zeros in silence, and has blue first."""
    cv2 = pytest.importorskip("cv2")
    if not list(rendered.glob("samples/*/left.exr")):
        pytest.skip("NumPy's layout")
    for sample in dualpixel.Dataset(rendered):
        folder = rendered / "samples" / sample["name"]
        for name in ("left", "right", "view_disparity_dp_px"):
            np.testing.assert_array_equal(cv2.imread(str(folder / f"{name}.exr"), cv2.IMREAD_UNCHANGED), sample[name])
        normal = cv2.imread(str(folder / "view_normal.exr"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(normal[..., ::-1], sample["view_normal"])
        assert sample["left"].any() and sample["view_disparity_dp_px"].any() and sample["view_normal"].any()


def test_splits_share_nothing(rendered):
    train, test = dualpixel.Dataset(rendered, "train"), dualpixel.Dataset(rendered, "test")
    assert sorted(train.names + test.names) == dualpixel.Dataset(rendered).names
    assert not set(train.names) & set(test.names)
    with pytest.raises(dualpixel.InputError, match="split: 'tain'"):
        dualpixel.Dataset(rendered, "tain")


@pytest.mark.slow
def test_truth_is_of_single_rays(program, tmp_path):
    """Planes before a void, seen from so far that it shows around them."""
    names = ["depth_m", "blur_px", "disparity_dp_px", "normal", "valid", "object_id", "person"]
    recipe = {
        "version": 1,
        "count": 2,
        "scenes": [{"file": str(SCENES / "occlusion_edges.json")}],
        "set": {
            **SMALL,
            "burst.frames": 1,
            "camera": {"constant": {"position_m": [0, 0, 18], "look_at_m": [0, 0, 0], "focus_distance_m": 19}},
        },
        "layout": "npy",
        "keep": names + ["view_" + name for name in names],
    }
    (tmp_path / "recipe.json").write_text(json.dumps(recipe))
    for command in (("plan", tmp_path / "recipe.json", "-o", tmp_path / "set"), ("render", tmp_path / "set")):
        done = program("dataset", *command)
        assert done.returncode == 0, done.stderr
    for sample in dualpixel.Dataset(tmp_path / "set"):
        valid = sample["valid"] == 1
        assert 0.05 < valid.mean() < 0.95
        assert set(np.unique(sample["valid"])) == {0, 1}
        for name in names:
            finite = np.isfinite(sample[name])
            assert finite[valid].all()
            assert finite.all() or (name == "depth_m" and np.isposinf(sample[name][~valid]).all())
            np.testing.assert_array_equal(sample["view_" + name], sample[name][2::4, 1::2])
        np.testing.assert_array_equal(sample["object_id"] == 0, ~valid)
        assert ((sample["person"] >= 0) & (sample["person"] <= 1)).all() and (sample["person"][~valid] == 0).all()
        # float32
        np.testing.assert_allclose(np.linalg.norm(sample["normal"][valid], axis=-1), 1, atol=1e-6)
        # the scene's planes face the camera: as many depths as objects, up to float32
        for node in np.unique(sample["object_id"][valid]):
            depth = sample["depth_m"][sample["object_id"] == node]
            np.testing.assert_allclose(depth, np.median(depth), rtol=1e-5)


def mean_of(sample):
    return sample["name"], float(sample["left"].mean())


def test_workers_get_it_pickled(rendered):
    samples = dualpixel.Dataset(rendered, keep=["left"], transform=mean_of)
    assert len(pickle.dumps(samples)) < 2000
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(samples.__getitem__, range(4)) == [samples[i] for i in range(4)]


def test_works_in_a_data_loader(rendered):
    data = pytest.importorskip("torch.utils.data")
    samples = dualpixel.Dataset(rendered, keep=["left", "right"], transform=lambda s: (s["left"], s["right"]))
    batches = list(data.DataLoader(samples, batch_size=2, num_workers=2))
    assert [tuple(view.shape) for view in batches[0]] == [(2, 24, 64)] * 2


def test_refuses_what_is_not_there(rendered, tmp_path):
    with pytest.raises(dualpixel.InputError, match="is not a data set"):
        dualpixel.Dataset(tmp_path)
    with pytest.raises(dualpixel.InputError, match="has no picture 'depth'; it has left, right"):
        dualpixel.Dataset(rendered, keep=["depth"])[0]
    with pytest.raises(IndexError):
        dualpixel.Dataset(rendered)[4]
