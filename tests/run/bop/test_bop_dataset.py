"""Reading BOP folders written by hand, and what is wrong with bad ones."""

import json
import re

import numpy as np
import pytest
from bop_folders import CUBE_MM, EYE, K, dataset, models, picture, put, scene, truth

from plogic.base.errors import InputError
from plogic.run.bop.dataset import Scene, open_dataset
from plogic.run.bop.json_files import SEARCHED
from plogic.run.bop.models import model_ids, read_models
from sensing.errors import ImageError

TARGET = {"scene_id": 1, "im_id": 3, "obj_id": 1, "inst_count": 2}


def test_a_frame_in_metres(tmp_path):
    folder = scene(tmp_path / "000048", {3: [truth(5, (10, -20, 1000), [0, -1, 0, 1, 0, 0, 0, 0, 1])]}, {3: [0.25]})
    put(
        folder / "scene_camera.json",
        {"3": {"cam_K": K, "depth_scale": 0.1, "cam_R_w2c": EYE, "cam_t_w2c": [0, 0, 2000], "view_level": 1}},
    )
    opened = open_dataset(folder)
    assert opened.listed() == ([(48, 3)], [])
    frame = opened.scene(48).frame(3)
    assert (frame.image.shape, frame.camera.width, frame.camera.height, frame.camera.f) == (
        (480, 640, 3),
        640,
        480,
        500,
    )
    assert frame.camera.world_from_camera[:3, 3].tolist() == [0, 0, -2]
    (one,) = opened.scene(48).truths(3)
    assert (one.obj_id, one.visible) == (5, 0.25)
    assert one.camera_from_object.tolist() == [[0, -1, 0, 0.01], [1, 0, 0, -0.02], [0, 0, 1, 1], [0, 0, 0, 1]]


def test_rounded_rotations_are_made_good(tmp_path):
    R = [0.7071, -0.7071, 0, 0.7071, 0.7071, 0, 0, 0, 1]
    folder = scene(tmp_path / "000001", {0: [truth(R=R)]})
    put(folder / "scene_camera.json", {"0": {"cam_K": K, "cam_R_w2c": R, "cam_t_w2c": [0, 0, 0]}})
    own = Scene(folder, 1)
    assert own.frame(0).camera.world_from_camera[0, 1] == pytest.approx(np.sqrt(0.5))
    assert own.truths(0)[0].camera_from_object[0, 0] == pytest.approx(np.sqrt(0.5))


def test_a_dataset_a_split_and_a_scene_are_the_same(tmp_path):
    root = dataset(tmp_path / "lm", {0: [], 7: [truth()]})
    put(root / "test_targets_bop19.json", [TARGET | {"im_id": 7}, TARGET | {"im_id": 7, "obj_id": 2}])
    for folder in (root, root / "test", root / "test/000001"):
        opened = open_dataset(folder)
        assert opened.listed() == ([(1, 7)], []), folder
        assert opened.targets == {(1, 7): {1: 2, 2: 2}}
        assert opened.models == (root / "models").resolve()


def test_the_only_split_of_tests_and_the_models_for_evaluation(tmp_path):
    root = tmp_path / "tless"
    scene(root / "test_primesense/000002", {1: []})
    scene(root / "test_primesense/000010", {0: []})
    scene(root / "train/000001", {0: []})
    models(root / "models_cad")
    opened = open_dataset(root)
    assert opened.listed()[0] == [(2, 1), (10, 0)]
    assert (opened.targets, opened.models.name) == (None, "models_cad")
    models(root / "models")
    models(root / "models_eval")
    assert open_dataset(root / "train").models.name == "models_eval"


def test_targets_are_for_tests_alone_and_a_scene_sees_its_own(tmp_path):
    root = dataset(tmp_path / "d", {3: [truth()]})
    scene(root / "val/000001", {0: []})
    put(root / "test_targets_bop19.json", [TARGET, TARGET | {"scene_id": 9}])
    names, lines = open_dataset(root).listed()
    assert names == [(1, 3)]
    assert lines == [f"{(root).resolve()}: has no scene 000009, which the targets name"]
    assert open_dataset(root / "test/000001").listed() == ([(1, 3)], [])
    assert open_dataset(root / "val").targets is None


def test_grey_pictures_and_jpeg(tmp_path):
    folder = scene(tmp_path / "s", {0: [], 1: []}, pictures=False)
    picture(folder / "gray/000000.png", 320, 240)
    picture(folder / "rgb/000001.jpg")
    own = open_dataset(folder).scene(0)
    assert own.frame(0).camera.width == 320
    assert own.frame(1).image.shape == (480, 640, 3)


def test_nothing_known_of_visibility_and_no_truth(tmp_path):
    folder = scene(tmp_path / "000001", {0: [truth()]})
    assert Scene(folder, 1).truths(0)[0].visible is None
    (folder / "scene_gt.json").unlink()
    assert Scene(folder, 1).truths(0) is None


def test_nothing_is_read_before_it_is_asked_for(tmp_path):
    folder = scene(tmp_path / "000001", {0: [truth()]})
    for name in ("scene_gt.json", "scene_gt_info.json", "rgb/000000.png"):
        put(folder / name, "rubbish")
    opened = open_dataset(folder)
    assert opened.listed() == ([(1, 0)], [])
    with pytest.raises(ImageError, match="is not an image"):
        opened.scene(1).frame(0)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('{"0": ', "scene_camera.json: is no JSON"),
        ([], "scene_camera.json: must be an object with numbers as keys"),
        ({"a": {}}, "scene_camera.json: a: must be a whole number"),
        ({"1": {"cam_K": K}}, "scene_camera.json: 0: is missing"),
        ({"0": 3}, "scene_camera.json: 0: must be an object"),
        ({"0": {}}, "scene_camera.json: 0.cam_K: is missing"),
        ({"0": {"cam_K": K[1:]}}, "scene_camera.json: 0.cam_K: must hold 9 finite numbers"),
        ({"0": {"cam_K": [*K[:8], "1"]}}, "scene_camera.json: 0.cam_K: must hold 9 finite numbers"),
        ('{"0": {"cam_K": [NaN, 0, 1, 0, 1, 1, 0, 0, 1]}}', "scene_camera.json: 0.cam_K: must hold 9 finite numbers"),
        ({"0": {"cam_K": [-500.0, *K[1:]]}}, "scene_camera.json: 0: camera.K: focal lengths must be positive"),
        ({"0": {"cam_K": K, "cam_R_w2c": EYE}}, "scene_camera.json: 0.cam_t_w2c: is missing"),
        (
            {"0": {"cam_K": K, "cam_R_w2c": K, "cam_t_w2c": [0, 0, 0]}},
            "scene_camera.json: 0.cam_R_w2c: must be a rotation",
        ),
    ],
)
def test_mistakes_of_cameras(tmp_path, content, words):
    folder = scene(tmp_path / "000001", {0: []})
    put(folder / "scene_camera.json", content)
    with pytest.raises(InputError) as caught:
        Scene(folder, 1).frame(0)
    assert words in re.sub(r"json:\d+:\d+:", "json:", str(caught.value))
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ({}, "scene_gt.json: 0: is missing"),
        ({"0": {}}, "scene_gt.json: 0: must be a list"),
        ({"0": [3]}, "scene_gt.json: 0.0: must be an object"),
        ({"0": [{**truth(), "obj_id": -1}]}, "scene_gt.json: 0.0.obj_id: must be a whole number"),
        ({"0": [{**truth(), "obj_id": True}]}, "scene_gt.json: 0.0.obj_id: must be a whole number"),
        ({"0": [{"obj_id": 1, "cam_R_m2c": EYE}]}, "scene_gt.json: 0.0.cam_t_m2c: is missing"),
        ({"0": [truth(t_mm=[1, 2])]}, "scene_gt.json: 0.0.cam_t_m2c: must hold 3 finite numbers"),
        ({"0": [truth(R=[[1, 0], 3])]}, "scene_gt.json: 0.0.cam_R_m2c: must hold 9 finite numbers"),
        ({"0": [truth(R=[0] * 9)]}, "scene_gt.json: 0.0.cam_R_m2c: must be a rotation"),
        ({"0": [truth(), truth()]}, "scene_gt_info.json: 0: has 1 entries, but scene_gt.json has 2"),
    ],
)
def test_mistakes_of_truths(tmp_path, rows, words):
    folder = scene(tmp_path / "000001", {0: []}, {0: [0.5]})
    put(folder / "scene_gt.json", rows)
    with pytest.raises(InputError) as caught:
        Scene(folder, 1).truths(0)
    assert words in re.sub(r"json:\d+:\d+:", "json:", str(caught.value))


def test_a_mistake_has_its_line_and_column(tmp_path):
    """Also where the file has zeros before a number; in a file of megabytes the keys alone are told."""
    folder = scene(tmp_path / "000001", {7: []}, {7: [0.5]})
    text = json.dumps({"000007": [{**truth(), "obj_id": -1}]}, indent=1)
    for filled, place in (("", ":4:14"), (" " * SEARCHED, "")):
        put(folder / "scene_gt.json", text + filled)
        with pytest.raises(InputError) as caught:
            Scene(folder, 1).truths(7)
        assert str(caught.value).startswith(f"{folder}/scene_gt.json{place}: 7.0.obj_id: must be a whole number")


def test_a_fraction_beyond_one(tmp_path):
    with pytest.raises(InputError, match=r"0\.0\.visib_fract: must be from 0 to 1"):
        Scene(scene(tmp_path / "s", {0: [truth()]}, {0: [1.5]}), 1).truths(0)


def test_no_picture(tmp_path):
    with pytest.raises(InputError, match="has no picture 000004"):
        Scene(scene(tmp_path / "s", {4: []}, pictures=False), 1).frame(4)


def test_no_dataset(tmp_path):
    with pytest.raises(InputError, match="is no folder"):
        open_dataset(tmp_path / "none")
    with pytest.raises(InputError, match="is no BOP dataset"):
        open_dataset(tmp_path)
    for name in ("test_a", "test_b"):
        scene(tmp_path / name / "000001", {0: []})
    with pytest.raises(InputError, match="give one of its splits: test_a, test_b"):
        open_dataset(tmp_path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({}, "must be a list of targets"),
        ([[]], "0: must be an object"),
        ([{**TARGET, "im_id": "3"}], "0.im_id: must be a whole"),
        ([{"im_id": 3}], "0.scene_id: is missing"),
    ],
)
def test_mistakes_of_targets(tmp_path, content, words):
    root = dataset(tmp_path / "d", {3: []})
    put(root / "test_targets_bop19.json", content)
    with pytest.raises(InputError, match=r"test_targets_bop19.json:\d+:\d+: .*" + words):
        open_dataset(root)


def test_models_in_metres(tmp_path):
    models(tmp_path, (3, 1), symmetries_discrete=[[-1, 0, 0, 30, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]])
    assert model_ids(tmp_path) == [1, 3]
    one = read_models(tmp_path, [3])[3]
    assert one.diameter == pytest.approx(0.1 * np.sqrt(3))
    assert (len(one.points), np.abs(one.points).max(), one.symmetric) == (8, 0.05, True)
    assert one.symmetries[1, 0].tolist() == [-1, 0, 0, 0.03]


@pytest.mark.parametrize(
    ("info", "words"),
    [
        ({}, "models_info.json: 1.diameter: is missing"),
        ({"diameter": 0}, "models_info.json: 1.diameter: must be greater than 0"),
        ({"diameter": CUBE_MM, "symmetries_discrete": {}}, "1.symmetries_discrete: must be a list"),
        ({"diameter": CUBE_MM, "symmetries_discrete": [[1, 2]]}, "1.symmetries_discrete.0: must hold 16"),
        ({"diameter": CUBE_MM, "symmetries_discrete": [[0] * 16]}, "1.symmetries_discrete.0: must be a rotation"),
        (
            {"diameter": CUBE_MM, "symmetries_continuous": [{"axis": [0, 0, 1]}]},
            "1.symmetries_continuous.0.offset: is missing",
        ),
        (
            {"diameter": CUBE_MM, "symmetries_continuous": [{"axis": [0, 0, 0], "offset": [0, 0, 0]}]},
            "0.axis: must not be zero",
        ),
    ],
)
def test_mistakes_of_models(tmp_path, info, words):
    models(tmp_path)
    put(tmp_path / "models_info.json", {"1": info})
    with pytest.raises(InputError) as caught:
        read_models(tmp_path, [1])
    assert words in re.sub(r"json:\d+:\d+:", "json:", str(caught.value))


def test_no_such_model(tmp_path):
    models(tmp_path)
    with pytest.raises(InputError, match=r"models_info\.json:1:1: 2: is missing"):
        read_models(tmp_path, [2])
    put(tmp_path / "obj_000001.ply", "no mesh")
    with pytest.raises(InputError, match=r"obj_000001\.ply: trimesh cannot read it"):
        read_models(tmp_path, [1])
    (tmp_path / "obj_000001.ply").unlink()
    with pytest.raises(InputError, match="there is no such model"):
        read_models(tmp_path, [1])
    assert json.loads((tmp_path / "models_info.json").read_text())
