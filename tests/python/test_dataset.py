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


def test_splits_share_nothing(rendered):
    train, test = dualpixel.Dataset(rendered, "train"), dualpixel.Dataset(rendered, "test")
    assert sorted(train.names + test.names) == dualpixel.Dataset(rendered).names
    assert not set(train.names) & set(test.names)
    with pytest.raises(dualpixel.InputError, match="split: 'tain'"):
        dualpixel.Dataset(rendered, "tain")


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
