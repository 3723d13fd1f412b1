"""``kb learn`` through the console script: a mesh to a recognised picture, and what it says where it cannot learn.

With few, small views.
"""

from __future__ import annotations

import json
import shutil
import subprocess

import cv2
import numpy as np
import pytest
from console import bytes_in, few_views, good, plogic
from made_meshes import obj_text, write_box
from painted_cube import CAMERA, picture, pose_towards, write_cube
from shared_folder import shared

from geometry.frames import pose_error
from kb.files.read import read_kb
from plogic.base.errors import InputError
from plogic.face.authoring.kb_learn import files_of
from sensing.simulated.body import read_mesh
from sensing.simulated.stage import MAX_TRIANGLES

MINE = "object: mine\nfeatures:\n  - {feature: f, type: apex, at: [0, 0, 0], appearances: []}\n"


@pytest.fixture(scope="module")
def surroundings(tmp_path_factory):
    """Environment variables for the console script."""
    return few_views(shared(tmp_path_factory, "few", few_views))


@pytest.fixture(scope="module")
def learned(tmp_path_factory, surroundings):
    """A knowledge base in three commands, and what the last one said."""

    def make(folder):
        good("kb", "new", folder / "kb")
        good("kb", "add", "cube", "--mesh", write_cube(folder, 100.0), "--units", "cm", "--kb", folder / "kb")
        done = plogic("kb", "learn", "--jobs", 1, "--kb", folder / "kb", **surroundings)
        assert done.returncode == 0, done.stderr
        (folder / "run.json").write_text(json.dumps([done.args, done.returncode, done.stdout, done.stderr]))

    folder = shared(tmp_path_factory, "three", make)
    return folder / "kb", subprocess.CompletedProcess(*json.loads((folder / "run.json").read_text()))


def refused(folder, *args, **env):
    """The lines on stderr of a ``kb learn`` that must fail and change nothing."""
    before = bytes_in(folder)
    done = plogic("kb", "learn", *args, "--jobs", 1, "--kb", folder, **env)
    assert (done.returncode, done.stdout) == (1, "")
    assert bytes_in(folder) == before
    return done.stderr.splitlines()


@pytest.fixture
def folder(tmp_path):
    """A new knowledge base."""
    good("kb", "new", tmp_path / "kb")
    return tmp_path / "kb"


def test_the_cloud_and_its_words_are_in_the_folder(learned):
    folder, done = learned
    assert "cube" in done.stdout
    assert "words" in done.stdout
    assert "features" in done.stderr
    assert (folder / "words.npz").is_file()
    assert (folder / "objects" / "cube" / "cloud.npz").is_file()
    kb = read_kb(folder)
    cloud = kb.type("cube").learned
    assert len(cloud.at) > 100
    assert np.abs(np.abs(cloud.at).max(axis=1) - 0.05).max() < 0.003  # the mesh came in cm
    assert "no mistakes" in good("kb", "check", folder)


def test_compounds_are_formed_told_and_kept(learned):
    folder, done = learned
    kind = read_kb(folder).type("cube")
    cloud, groups = (
        kind.learned,
        [np.flatnonzero(kind.learned.compound == c) for c in range(1, kind.learned.compounds + 1)],
    )
    assert len(groups) > 50
    for group in groups:
        assert np.ptp(cloud.sided[np.isin(cloud.feature, group)].astype(int)) == 0  # keypoints, or sides of edges
        assert np.linalg.norm(cloud.at[group] - cloud.at[group[0]], axis=1).max() < 0.01
    assert len(kind.features) == len(cloud.at) - sum(map(len, groups)) + len(groups)
    told = f"{sum(map(len, groups))} of them in {len(groups)} compounds of 2"
    assert told in done.stderr
    assert told in good("kb", "check", folder)
    assert told in good("kb", "show", folder)
    assert "compounds" in done.stdout


def test_the_picture_of_it_is_recognised(learned, tmp_path):
    truth = pose_towards((1.0, -0.8, 0.7), 0.6, 0.5, (0.02, 0.01))
    cv2.imwrite(str(tmp_path / "seen.png"), picture([truth]))
    cv2.imwrite(str(tmp_path / "empty.png"), picture([]))
    camera = {"width": CAMERA.width, "height": CAMERA.height, "K": CAMERA.K.tolist(), "dist": []}
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    answers = []
    for name in ("seen", "empty"):
        good(
            "perceive",
            tmp_path / f"{name}.png",
            "--camera",
            tmp_path / "camera.json",
            "--kb",
            learned[0],
            "-o",
            tmp_path / f"{name}.json",
        )
        answers.append(json.loads((tmp_path / f"{name}.json").read_text()))
    seen, empty = answers
    assert empty["worlds"][0]["present"] == []
    (present,) = seen["worlds"][0]["present"]
    (found,) = [h for h in seen["hypotheses"] if h["id"] == present]
    rotation, translation = pose_error(np.array(found["T_camera_object"]), truth)
    assert found["type"] == "cube"
    assert np.degrees(rotation) < 5.0
    assert translation < 0.05 * 0.6


def test_again_it_was_learned_before_and_nothing_changes(learned, surroundings):
    folder, _ = learned
    before = bytes_in(folder)
    done = plogic("kb", "learn", "cube", "--jobs", 1, "--json", "--kb", folder, **surroundings)
    assert done.returncode == 0
    assert "cube: was learned before" in done.stderr
    document = json.loads(done.stdout)
    assert document["format"] == "kb_learn/1"
    assert document["types"][0]["type"] == "cube"
    assert bytes_in(folder) == before
    done = plogic("kb", "learn", "--kb", folder, **surroundings)
    assert (done.returncode, done.stderr, bytes_in(folder)) == (0, "", before)
    assert done.stdout == (
        "nothing to learn: every type that can be learned has features already; name those that are to be learned again\n"
    )


def test_what_has_no_print_is_left_out_and_the_others_are_learned(folder, surroundings, tmp_path):
    """A mug without a texture, and a cube painted in one grey, beside one that has a print."""
    write_cube(tmp_path)
    box = write_box(tmp_path / "box.obj")
    good("kb", "add", "cube", "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", folder)
    cv2.imwrite(str(tmp_path / "cube.png"), np.full((8, 8, 3), 130, np.uint8))
    good("kb", "add", "grey", "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", folder)
    for name in ("mug", "cup"):
        good("kb", "add", name, "--mesh", box, "--units", "m", "--kb", folder)
    few = surroundings | {"TEST_DIRECTIONS": "2", "XDG_CACHE_HOME": str(tmp_path / "cache")}
    done = plogic("kb", "learn", "--detector", "orb", "--jobs", 1, "--json", "--kb", folder, **few)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert [row["type"] for row in document["types"]] == ["cube"]
    assert {row["type"] for row in document["left_out"]} == {"cup", "grey", "mug"}
    told = [line for line in done.stderr.splitlines() if "left out" in line]
    assert len(told) == 2
    assert told[0].startswith("cup, mug: left out: its mesh has no texture")
    assert "plogic kb learn NAME --photo FILE --points FILE" in told[0]
    assert told[1].startswith("grey: left out: no keypoint of it comes again")
    assert "by hand" in told[1]
    assert {kind.name for kind in read_kb(folder).types if kind.learned is not None} == {"cube"}


def test_learning_tells_how_far_it_came_without_a_terminal(folder, surroundings, tmp_path):
    """Every ten seconds; here every hundredth of one, of two types."""
    own = tmp_path / "own"
    own.mkdir()
    few = few_views(own) | {"TEST_DIRECTIONS": "3"}
    often = "import plogic.face.shown.progress as progress\nprogress.SELDOM = progress.TICK = 0.01\n"
    (own / "sitecustomize.py").write_text((own / "sitecustomize.py").read_text() + often)
    for name in ("one", "two"):
        write_cube(tmp_path)
        if name == "two":
            cv2.imwrite(str(tmp_path / "cube.png"), cv2.imread(str(tmp_path / "cube.png"))[::-1])
        good("kb", "add", name, "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", folder)
    done = plogic("kb", "learn", "--jobs", 1, "--kb", folder, **few)
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if " % of all" in line]
    for start in ("one: 0 of 3 views; 0 % of all", "one: features; ", "two: 0 of 3 views; ", "words of all types; "):
        assert any(line.startswith(start) for line in told), start
    shares = [int(line.partition("; ")[2].partition(" %")[0]) for line in told]
    assert shares == sorted(shares)
    assert all(line.endswith(" left") for line in told if "; 0 %" not in line)


def test_where_something_was_there_already_nothing_new_is_no_failure(learned, surroundings, tmp_path):
    copy = shutil.copytree(learned[0], tmp_path / "kb")
    good("kb", "add", "mug", "--mesh", write_box(tmp_path / "box.obj"), "--units", "m", "--kb", copy)
    before = bytes_in(copy)
    done = plogic("kb", "learn", "--kb", copy, **surroundings)
    assert (done.returncode, bytes_in(copy)) == (0, before)
    assert done.stdout.startswith("nothing to learn: ")
    (line,) = done.stderr.splitlines()
    assert line.startswith("mug: left out: its mesh has no texture")
    (line,) = refused(copy, "mug", **surroundings)
    assert line.startswith("plogic: mug: its mesh has no texture"), "of what was asked, nothing was learned"


def test_a_knowledge_base_without_types_says_how_to_add_one(folder):
    (line,) = refused(folder)
    assert line.startswith("plogic: there is no object type yet: plogic kb add NAME --mesh FILE")


def test_a_cache_file_that_was_cut_off_is_learned_anew(learned, surroundings, tmp_path):
    folder, _ = learned
    clouds = tmp_path.parent / surroundings["XDG_CACHE_HOME"] / "plogic" / "clouds"
    file = max(clouds.iterdir(), key=lambda path: path.stat().st_size)  # the others are of turns
    cache = tmp_path / "plogic" / "clouds"
    cache.mkdir(parents=True)
    (cache / file.name).write_bytes(file.read_bytes()[:-200])
    copy = shutil.copytree(folder, tmp_path / "kb")
    done = plogic(
        "kb",
        "learn",
        "cube",
        "--jobs",
        1,
        "--kb",
        copy,
        **surroundings | {"XDG_CACHE_HOME": str(tmp_path), "TEST_DIRECTIONS": "3"},
    )
    assert done.returncode == 0, done.stderr
    assert "was learned before" not in done.stderr
    assert len(read_kb(copy).type("cube").learned.at) > 20


def test_a_cache_that_cannot_be_written_is_no_reason_to_fail(learned, surroundings, tmp_path):
    copy = shutil.copytree(learned[0], tmp_path / "kb")
    (tmp_path / "file").write_text("")
    elsewhere = {"XDG_CACHE_HOME": str(tmp_path / "file"), "TEST_DIRECTIONS": "2"}
    done = plogic("kb", "learn", "cube", "--jobs", 1, "--kb", copy, **surroundings | elsewhere)
    assert done.returncode == 0, done.stderr
    assert "cube: is not remembered for the next time" in done.stderr


def test_a_mesh_without_texture_is_one_clear_line(folder, tmp_path):
    good("kb", "add", "box", "--mesh", write_box(tmp_path / "box.obj"), "--units", "m", "--kb", folder)
    (line,) = refused(folder)
    assert line.startswith("plogic: box: its mesh has no texture")
    assert "junctions" in line


def test_a_texture_that_shows_nothing_is_one_clear_line(folder, tmp_path, surroundings):
    write_cube(tmp_path)
    cv2.imwrite(str(tmp_path / "cube.png"), np.full((8, 8, 3), 130, np.uint8))
    good("kb", "add", "plain", "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", folder)
    (line,) = refused(
        folder, "--detector", "orb", **surroundings | {"TEST_DIRECTIONS": "2"}
    )  # SIFT sees its outline, as a region
    assert line.startswith("plogic: plain: no keypoint of it comes again")


def test_names_that_are_not_there_and_features_written_by_hand(folder):
    (line,) = refused(folder, "cup", "jug")
    assert line == "plogic: cup, jug: no such object type; there are: none (plogic kb add)"
    (line,) = refused(folder, *(f"cup{i}" for i in range(25)))
    assert line.startswith("plogic: cup0, cup1, ")
    assert ", cup19 and 5 more: no such object type; there are: none" in line
    (folder / "objects" / "mine").mkdir()
    (folder / "objects" / "mine" / "object.yaml").write_text(MINE.replace("apex", "any"))
    (folder / "kb.yaml").write_text((folder / "kb.yaml").read_text())
    lines = refused(folder, "mine", "cup")
    assert any("cup: no such object type; there are: mine" in line for line in lines)
    assert any("mine: its features were written by hand" in line for line in lines)


def test_rates_of_words_are_not_learned_from_scenes(learned, tmp_path):
    """Their names change when another type is learned: kb.yaml must not hold them."""
    copy, truth = shutil.copytree(learned[0], tmp_path / "kb"), pose_towards((1.0, -0.8, 0.7), 0.6)
    scene = tmp_path / "scene"
    scene.mkdir()
    cv2.imwrite(str(scene / "image.png"), picture([truth]))
    (scene / "camera.json").write_text(
        json.dumps({"width": CAMERA.width, "height": CAMERA.height, "K": CAMERA.K.tolist(), "dist": []})
    )
    there = {"label": "cube", "T_camera_object": truth.tolist()}
    (scene / "truth.json").write_text(json.dumps({"format": "truth/1", "objects": [there]}))
    good("kb", "learn-rates", scene, "--kb", copy)
    assert "sift_w" not in (copy / "kb.yaml").read_text()
    assert read_kb(copy).rates.prior["cube"] == pytest.approx(2 / 3, abs=0.01)
    good("kb", "check", copy)


def test_two_detectors_cannot_share_one_vocabulary(learned, surroundings, tmp_path):
    folder, _ = learned
    copy = shutil.copytree(folder, tmp_path / "kb")
    write_cube(tmp_path)
    good("kb", "add", "other", "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", copy)
    (line,) = refused(copy, "other", "--detector", "orb", **surroundings)
    assert "clouds of orb and sift cannot share one vocabulary" in line


def test_what_is_added_can_be_rendered(learned):
    kind = read_kb(learned[0]).type("cube")
    assert read_mesh(kind.mesh_file, kind.mesh_scale).texture is not None


def test_a_cloud_and_words_go_where_the_folder_says(learned, surroundings, tmp_path):
    copy = shutil.copytree(learned[0], tmp_path / "kb")
    place = copy / "objects" / "cube"
    for folder, file, old, new in [
        (copy, "kb.yaml", "words.npz", "vocabulary.npz"),
        (place, "object.yaml", "cloud.npz", "points.npz"),
    ]:
        (folder / old).rename(folder / new)
        (folder / file).write_text((folder / file).read_text().replace(old, new))
    (copy / "vocabulary.npz").write_bytes((learned[0] / "words.npz").read_bytes())
    before = bytes_in(copy)
    few = surroundings | {"TEST_DIRECTIONS": "3", "XDG_CACHE_HOME": str(tmp_path / "cache")}
    done = plogic("kb", "learn", "cube", "--jobs", 1, "--seed", 3, "--kb", copy, **few)
    assert done.returncode == 0, done.stderr
    after = bytes_in(copy)
    assert after.keys() == before.keys()
    assert {name for name in after if after[name] != before[name]} == {"vocabulary.npz", "objects/cube/points.npz"}
    assert "no mistakes" in good("kb", "check", copy)


def test_two_types_cannot_share_a_file(tmp_path):
    from random_cloud import random_cloud, random_words

    for name in ("a", "b"):
        (tmp_path / "objects" / name).mkdir(parents=True)
        (tmp_path / "objects" / name / "object.yaml").write_text(f"object: {name}\ncloud: {{file: ../both.npz}}\n")
    (tmp_path / "kb.yaml").write_text("name: some\nappearance_types: []\n")
    with pytest.raises(
        InputError, match=r"b/object.yaml: names .*both.npz for its cloud, which another file names too"
    ):
        files_of(tmp_path, random_words(), {"a": random_cloud(1), "b": random_cloud(2)})


def test_meshes_that_cannot_be_rendered_are_all_told_at_once(folder, tmp_path):
    count = MAX_TRIANGLES + 1
    corners = np.random.default_rng(0).uniform(0, 1, (count + 2, 3))
    fan = np.column_stack([np.zeros(count, int), np.arange(1, count + 1), np.arange(2, count + 2)])
    text = obj_text(corners, fan, corners[:, :2], "textured.mtl").replace("usemtl paint", "usemtl painted")
    write_cube(tmp_path)
    for name in ("fine", "finer"):
        good("kb", "add", name, "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", folder)
        (folder / "objects" / name / "textured.obj").write_text(text)
    good("kb", "add", "box", "--mesh", write_box(tmp_path / "box.obj"), "--units", "m", "--kb", folder)
    good("kb", "add", "torn", "--mesh", tmp_path / "cube.obj", "--units", "m", "--kb", folder)
    (folder / "objects" / "torn" / "texture.png").write_bytes(b"\x89PNG nothing")
    lines = refused(folder, "cup")
    assert [line.split(":")[1].strip() for line in lines] == ["cup"], "what was not named is not looked at"
    lines = refused(folder)
    assert sorted(line.split(":")[1].strip() for line in lines) == ["box", "fine, finer", "torn"]
    for line in lines:
        assert ("textured.obj has 40001 triangles, more than the 40000 that can be rendered: simplify" in line) == (
            "fine" in line
        )


def test_a_shipped_knowledge_base_is_not_changed(tmp_path, folder):
    write_cube(tmp_path)
    (tmp_path / "points.csv").write_text("1,2,3,4,5\n")
    photo = (
        "--photo",
        tmp_path / "cube.png",
        "--points",
        tmp_path / "points.csv",
        "--mesh",
        tmp_path / "cube.obj",
        "--units",
        "m",
    )
    for words in (("t1",), ("new", *photo)):
        done = plogic("kb", "learn", *words, "--kb", "towers", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (
            1,
            "plogic: towers: is shipped with plogic: copy its folder, and change the copy\n",
        )
    assert not (tmp_path / "towers").exists()
    (line,) = plogic("kb", "learn", "../..", *photo, "--kb", folder).stderr.splitlines()
    assert line.startswith("plogic: '../..' is no name for a type")
