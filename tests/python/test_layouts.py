"""The layouts of others, read by their loaders' conventions: WebDataset, DPDD, Google's dual-pixel data."""

import glob
import io
import json
import os
import re
import tarfile

import numpy as np
import pytest

import dualpixel
from conftest import SCENES, SMALL


def recipe(**fields):
    """Six samples of three splits, with blur, and nothing clipped."""
    return {
        "version": 1,
        "count": 6,
        "seed": 3,
        "scenes": [
            {"file": str(SCENES / f"{name}.json")} for name in ("slanted_planes", "occlusion_edges", "calibration_target")
        ],
        "set": {
            **SMALL,
            "burst.frames": 1,
            "render.all_in_focus_samples_per_pixel": 4,
            "render.light_spacing_px": 0,
        },
        "relations": {"exposure_mean": 0.1},
        "split": {"train": 0.34, "validation": 0.33, "test": 0.33},
        **fields,
    }


def rendered(program, folder, document, *merge_options):
    """The data set of a recipe, merged."""
    folder.mkdir()
    (folder / "recipe.json").write_text(json.dumps(document))
    root = folder / "set"
    for command in (
        ("plan", folder / "recipe.json", "-o", root),
        ("render", root),
        ("merge", root, *merge_options),
    ):
        done = program("dataset", *command)
        assert done.returncode == 0, done.stderr
    return root


# --- WebDataset: POSIX tar; a sample is the files side by side whose names are the same up to the first dot of the last
# part, the rest of the name is the key (webdataset/tariterators.py: base_plus_ext, group_by_keys); values are decoded by
# the key's last part (webdataset/autodecode.py: json, npy).


def tar_samples(path):
    """A shard's samples as dicts, read as a stream."""
    samples = []
    with tarfile.open(path, "r|") as tar:
        for member in tar:
            assert member.isreg()
            name = re.fullmatch(r"((?:.*/)?[^./]+)\.([^/]*)", member.name)
            assert name, f"{member.name}: would be left out"
            key, suffix = name[1], name[2].lower()
            if not samples or samples[-1]["__key__"] != key:
                samples.append({"__key__": key})
            assert suffix not in samples[-1], f"{member.name}: is there twice"
            samples[-1][suffix] = tar.extractfile(member).read()
    return samples


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["npy", "exr"])
def test_webdataset(program, tmp_path, layout):
    keep = ["left", "right", "view_disparity_dp_px"]
    root = rendered(program, tmp_path / layout, recipe(layout=layout, keep=keep), "--webdataset")
    for split in ("train", "validation", "test"):
        shards = sorted(path.name for path in (root / "webdataset").glob(f"{split}-*.tar"))
        assert shards == [f"{split}-{i:06}.tar" for i in range(len(shards))]  # "train-{000000..000003}.tar"
        samples = [sample for shard in shards for sample in tar_samples(root / "webdataset" / shard)]
        ours = dualpixel.Dataset(root, split)
        assert [sample["__key__"] for sample in samples] == ours.names
        for sample, expected in zip(samples, ours):
            assert set(sample) == {"__key__", "json", "preview.png", *(f"{name}.{layout}" for name in keep)}
            document = json.loads(sample["json"])
            assert document["line"]["split"] == split
            assert dualpixel.reader.camera_of(dualpixel.fields.Fields(document, "json")) == expected["camera"]
            for name in keep if layout == "npy" else []:
                array = np.lib.format.read_array(io.BytesIO(sample[name + ".npy"]))
                np.testing.assert_array_equal(array, expected[name])


# --- DPDD: what DPDNet's data.py lists, sorts and reads.


def dpdd_lists(root, split):
    """Paths of (undivided, left, right, sharp), as data_random_shuffling() pairs them: by their places in sorted lists."""
    folders = [f"{split}_c/source", f"{split}_l/source", f"{split}_r/source", f"{split}_c/target"]
    lists = [sorted(os.path.join(root, f, name) for name in os.listdir(os.path.join(root, f))) for f in folders]
    assert all(len(paths) == len(lists[0]) for paths in lists)
    return list(zip(*lists))


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


@pytest.mark.slow
@pytest.mark.parametrize("downsample", [1, 2])
def test_dpdd(program, tmp_path, downsample):
    cv2 = pytest.importorskip("cv2")
    document = recipe(layout="dpdd")
    document["set"].update({"sensor.dp_downsample_x": downsample, "sensor.dp_downsample_y": downsample})
    root = rendered(program, tmp_path / "dpdd", document)
    document.update(layout="npy", keep=["all_in_focus"])
    sharp = {s["name"]: s["all_in_focus"] for s in dualpixel.Dataset(rendered(program, tmp_path / "npy", document))}
    seen = []
    for split in ("train", "val", "test"):
        for paths in dpdd_lists(root / "dpdd", split):
            assert len({os.path.basename(path) for path in paths}) == 1
            pictures = [cv2.imread(path, -1) for path in paths]
            for picture in pictures:
                assert picture.dtype == np.uint16
                assert picture.shape == (96 // downsample, 128 // downsample, 3)
            undivided, left, right, target = (linear(picture[..., ::-1] / 65535) for picture in pictures)
            # both views are twice as bright as theirs of the light; what is below black is clipped in each
            dark = np.minimum(left, right) < 0.01
            np.testing.assert_allclose(((left + right) / 2)[~dark], undivided[~dark], atol=2e-4)
            name = os.path.splitext(os.path.basename(paths[0]))[0]
            if downsample == 1:
                # half a step of the sRGB curve, whose slope is 2.4 / 1.055 at most
                np.testing.assert_allclose(target, np.clip(sharp[name], 0, 1), atol=2.4 / 65535)
            else:
                np.testing.assert_array_equal(target[..., 0], target[..., 2])  # gray, in three channels
            seen.append(name)
    assert sorted(seen) == sorted(sharp)


# --- Google's: dual_pixels/eval/script.py reads depth and confidence; loaders of others find the views by
# TRAIN/**/result_pd_left_*.png and name the right one by replacing "left", divide by 16 * 1023.


@pytest.mark.slow
def test_google(program, tmp_path):
    cv2 = pytest.importorskip("cv2")
    root = rendered(program, tmp_path / "google", recipe(layout="google"))
    document = recipe(layout="npy", keep=["depth_m", "valid", "left", "right"])
    ours = {s["name"]: s for s in dualpixel.Dataset(rendered(program, tmp_path / "npy", document))}
    seen = []
    for split in ("train", "validation", "test"):
        base = root / "google" / split
        for capture in sorted(os.listdir(base / "merged_depth")):
            sample = ours[capture]
            depth_path = glob.glob(str(base / "merged_depth" / capture / "*_center.png"))[0]
            depth = cv2.imread(depth_path, -1)
            assert depth.dtype == np.uint8 and depth.ndim == 2
            confidence = np.load(glob.glob(str(base / "merged_conf" / capture / "*_center.npy"))[0])
            assert confidence.shape == depth.shape == (128, 96)  # upright: turned by a quarter
            valid = np.rot90(sample["valid"], -1)
            np.testing.assert_array_equal(confidence, valid)
            # 8 bits of inverse depth from 1 / 100 to 1 / 0.2
            inverse = 1 / np.rot90(sample["depth_m"], -1)[valid == 1]
            np.testing.assert_allclose((100 - 99.8 * depth[valid == 1] / 255) / 20, inverse, atol=0.51 / 255 * 4.99)
            seen.append(capture)
        for left_path in glob.glob(str(base / "**" / "result_pd_left_*.png"), recursive=True):
            right_path = left_path.replace("/raw_left_pd/", "/raw_right_pd/").replace("_pd_left_", "_pd_right_")
            capture = os.path.basename(os.path.dirname(left_path))
            exposure = ours[capture]["exposure"]
            full = 2 ** exposure["bits"] - 1
            for path, name in ((left_path, "left"), (right_path, "right")):
                view = cv2.imread(path, -1)
                assert view.dtype == np.uint16 and view.ndim == 2
                signal = view / 16368 * full
                signal = (signal - exposure["black_level_dn"]) / (exposure["white_level_dn"] - exposure["black_level_dn"])
                half_step = 0.51 * full / 1023 / (exposure["white_level_dn"] - exposure["black_level_dn"])
                np.testing.assert_allclose(signal, np.rot90(ours[capture][name], -1), atol=half_step)
    assert sorted(seen) == sorted(ours)
