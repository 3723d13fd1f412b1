"""Numbers that no float can hold, nesting without end, links to themselves and pipes in a BOP dataset.

One line each, and none taken for absent.
"""

import os
import re
from pathlib import Path

import pytest
from bop_folders import EYE, K, dataset, put, truth

from plogic.base.errors import InputError
from plogic.run.bop.dataset import open_dataset
from plogic.run.bop.models import model_ids

HUGE = 10**400
DEEP = "[" * 100_000 + "]" * 100_000
SCENE = "test/000001/"


def loop(path):
    path.symlink_to(path)


CAMERAS = {
    "400 digits": ({"0": {"cam_K": [HUGE, *K[1:]]}}, "0.cam_K: must hold 9 finite numbers below 1e+09, not [1000"),
    "a huge exponent": (
        {"0": {"cam_K": [1e308, *K[1:]]}},
        "0.cam_K: must hold 9 finite numbers below 1e+09, not [1e+308",
    ),
    "400 digits of a shift": (
        {"0": {"cam_K": K, "cam_R_w2c": EYE, "cam_t_w2c": [HUGE, 0, 0]}},
        "0.cam_t_w2c: must hold 3 finite numbers",
    ),
    "400 digits of an image": ({"9" * 400: {"cam_K": K}}, "must be a whole number below 1000000000"),
    "5000 digits": (f'{{"0": {"9" * 5000}}}', "holds a whole number of more digits than can be read"),
    "an image twice": ({"0": {"cam_K": K}, "00": {"cam_K": K}}, "00: is there twice"),
    "deep": (f'{{"0": {DEEP}}}', "is nested too deeply"),
    "no UTF-8": (b"{\xff}", "is no JSON: byte 1 is no UTF-8"),
}


def spoil(path, content):
    """Write what a file holds, or make what a function makes in its place."""
    path.unlink(missing_ok=True)
    if callable(content):
        content(path)
    elif isinstance(content, bytes):
        path.write_bytes(content)
    else:
        put(path, content)


@pytest.mark.parametrize("case", CAMERAS)
def test_a_hostile_camera(case, tmp_path):
    root = dataset(tmp_path / "d", {0: [truth()]})
    spoil(root / SCENE / "scene_camera.json", CAMERAS[case][0])
    with pytest.raises(InputError) as caught:
        open_dataset(root).scene(1).frame(0)
    (line,) = str(caught.value).splitlines()
    assert re.match(rf"{root / SCENE / 'scene_camera.json'}(:\d+:\d+)?: ", line)
    assert CAMERAS[case][1] in line


TRUTHS = {
    "400 digits": ({"0": [truth(1, (HUGE, 0, 0))]}, "0.0.cam_t_m2c: must hold 3 finite numbers below 1e+09"),
    "an object of 400 digits": ({"0": [truth(HUGE)]}, "0.0.obj_id: must be a whole number from 0 and below 1000000000"),
    "a loop": (loop, "is a link that leads back to itself"),
    "a pipe": (os.mkfifo, "is no plain file, but a pipe or a device"),
    "a folder": (Path.mkdir, "is a folder, not a file"),
}


@pytest.mark.parametrize("case", TRUTHS)
def test_hostile_truth_is_not_taken_for_absent(case, tmp_path):
    root = dataset(tmp_path / "d", {0: [truth()]})
    spoil(root / SCENE / "scene_gt.json", TRUTHS[case][0])
    with pytest.raises(InputError, match=r"scene_gt\.json(:\d+:\d+)?: ") as caught:
        open_dataset(root).scene(1).truths(0)
    assert TRUTHS[case][1] in str(caught.value)


@pytest.mark.parametrize("case", ["a loop", "a pipe", "a folder"])
def test_hostile_models_and_targets_are_not_taken_for_absent(case, tmp_path):
    root = dataset(tmp_path / "d", {0: [truth()]})
    spoil(root / "models/models_info.json", TRUTHS[case][0])
    with pytest.raises(InputError, match=rf"models_info.json(:\d+:\d+)?: {TRUTHS[case][1]}"):
        model_ids(open_dataset(root).models)
    spoil(root / "test_targets_bop19.json", TRUTHS[case][0])
    with pytest.raises(InputError, match=f"test_targets_bop19.json: {TRUTHS[case][1]}"):
        open_dataset(root)


@pytest.mark.parametrize("name", ["\N{SUPERSCRIPT TWO}", "1" * 200], ids=["superscript", "long"])
def test_a_folder_of_a_strange_number_is_no_scene(name, tmp_path):
    root = dataset(tmp_path / "d", {0: [truth()]})
    (root / SCENE).rename(root / "test" / name)
    with pytest.raises(InputError, match="is no BOP dataset"):
        open_dataset(root)


def test_a_dataset_that_cannot_be(tmp_path):
    loop(tmp_path / "a")
    with pytest.raises(InputError, match="a: is a link that leads back to itself"):
        open_dataset(tmp_path / "a")
    with pytest.raises(InputError, match="has a name that is too long for a file"):
        open_dataset(tmp_path / ("n" * 300))
