"""``plogic perceive FRAME... --poses FILE`` through the console script."""

from __future__ import annotations

import json
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from console import document, good, plogic
from sequences import turned, view

from plogic import Error, Panorama
from plogic.face.commands import perceive
from plogic.face.shown.options import Perceiving
from plogic.facts.interpretation import OF_SEVERAL
from plogic.sequence.views import panorama as views
from sensing.files.gamma_files import write_gamma

ANGLES = [0.0, 15.0, 80.0, 1.0]


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    """Four Γ files, f1.json to f4.json, and poses.json, which also names a place where nothing was seen yet."""
    folder = tmp_path_factory.mktemp("frames")
    poses = [turned(angle) for angle in ANGLES]
    for n, pose in enumerate(poses, 1):
        write_gamma(view(n, pose).gamma, folder / f"f{n}.json")
    rows = [{"frame": f"f{n}.json", "T_world_camera": pose.tolist()} for n, pose in enumerate(poses, 1)]
    rows.append({"frame": None, "T_world_camera": turned(10.0).tolist()})
    (folder / "poses.json").write_text(json.dumps({"format": "poses/1", "frames": rows}))
    return folder


def names(count=4):
    return [f"f{n}.json" for n in range(1, count + 1)]


OF_TWO = (*names(2), "--kb", "towers", "--poses", "poses.json")


@pytest.fixture(scope="module")
def two(frames):
    """What is told of the first two frames."""
    return good("perceive", *OF_TWO, cwd=frames)


@pytest.fixture(scope="module")
def two_by_posterior(frames):
    """What is told of the first two frames in the posterior reading."""
    return document("perceive", *OF_TWO, "--reading", "posterior", cwd=frames)


def test_how_far_it_has_come_names_the_view(frames, monkeypatch, tmp_path):
    told, looked = [], views.Panorama.look

    @contextmanager
    def beating(here):
        def look(*args):
            with args[-1].stage("search"):
                told.append(here())
            return looked(*args)

        monkeypatch.setattr(views.Panorama, "look", look)
        yield lambda say: say

    monkeypatch.chdir(frames)
    monkeypatch.setattr(perceive, "beating", beating)
    options = Perceiving("towers", poses="poses.json", out=str(tmp_path / "p.json"))
    assert perceive.perceive_command(names(2), options, say=print, write=print) == 0
    assert told == ["view 1 of 2, search", "view 2 of 2, search"]


def test_a_sequence_gives_a_panorama_and_a_line_a_frame(frames, tmp_path):
    done = plogic(
        "perceive",
        *names(),
        "--kb",
        "towers",
        "--poses",
        "poses.json",
        "--reading",
        "posterior",
        "-o",
        tmp_path / "p.json",
        cwd=frames,
    )
    assert done.returncode == 0, done.stderr
    told = json.loads((tmp_path / "p.json").read_text())
    assert told["format"] == "panorama/1"
    assert [v["frame"] for v in told["views"]] == names()
    assert {o["type"]: (o["last_seen"], o["age"], o["in_view"]) for o in told["objects"]} == {
        "t1": ("v4", 0, True),
        "t2": ("v4", 0, True),
    }
    assert told["worlds"][0]["present"] == ["p1", "p2"]
    assert [v["interpretation"]["camera"]["T_world_camera"] for v in told["views"]] == [
        turned(angle).tolist() for angle in ANGLES
    ]
    (ahead,) = told["ahead"]
    assert {row["id"] for row in ahead["predicted"]} == {"p1", "p2"}
    lines = done.stderr.splitlines()
    assert len(lines) == 4
    assert "no search" in lines[3]
    assert "2 recalled" in lines[3]


def test_python_looks_view_by_view_and_comes_to_the_same_file(frames, two, tmp_path, monkeypatch):
    monkeypatch.chdir(frames)
    place = Panorama("towers")
    looks = [place.look(f"f{n}.json", T_world_camera=turned(angle)) for n, angle in enumerate(ANGLES[:2], 1)]
    written = json.loads(place.save(tmp_path / "panorama.json").read_text())
    by_command = json.loads(two)
    by_command["ahead"] = []  # the file of poses names a place ahead
    assert written == by_command
    assert [len(look.hypotheses) for look in looks] == [
        len(v["interpretation"]["hypotheses"]) for v in written["views"]
    ]
    assert {(o.id, o.type, o.probability) for o in place.objects} == {
        (o["id"], o["type"], o["probability"]) for o in written["objects"]
    }
    assert place.worlds[0].present == tuple(written["worlds"][0]["present"])
    assert "t1 p" in str(place)
    with pytest.raises(Error, match="where the view is from is not known"):
        place.look("f3.json")
    with pytest.raises(Error, match="T_world_camera: should be 4x4 numbers"):
        place.look("f3.json", T_world_camera="x")
    assert len(place.views) == 2


def test_python_warns_of_a_place_that_serves_twice_and_of_a_camera_that_is_not_used():
    first = view(1, turned(0.0)).gamma
    gamma = replace(first, camera=replace(first.camera, world_from_camera=turned(0.0)))
    place = Panorama("towers")
    place.look(gamma)
    with pytest.warns(UserWarning, match="from the place of an earlier view"):
        place.look(gamma)
    with pytest.warns(UserWarning, match="a Γ has a camera of its own"):
        place.look(gamma, "nowhere.json", turned(0.0))


def test_each_view_of_it_is_an_interpretation(two_by_posterior, tmp_path):
    path = tmp_path / "v2.json"
    path.write_text(json.dumps(two_by_posterior["views"][1]["interpretation"]))
    worlds = document("worlds", path, "--json")
    assert worlds["worlds"][0]["present"] == ["h1", "h2"]


def test_gammas_that_know_their_places_need_no_poses(two, tmp_path):
    for n, angle in enumerate(ANGLES[:2], 1):
        gamma = view(n, turned(angle)).gamma
        write_gamma(
            replace(gamma, camera=replace(gamma.camera, world_from_camera=turned(angle))), tmp_path / f"f{n}.json"
        )
    own = document("perceive", *names(2), "--kb", "towers", cwd=tmp_path)
    assert own["objects"] == json.loads(two)["objects"]


def test_images_without_poses_are_taken_to_be_from_one_place_and_that_is_said(tmp_path):
    good("simulate", "--kb", "towers", "-o", "scene", "--robot", "ring:1", cwd=tmp_path)
    frame, camera = "scene/frame-000/image.png", "scene/frame-000/camera.json"
    both = ("perceive", frame, frame, "--kb", "towers", "--camera", camera, "-o", "p.json")
    done = plogic(*both, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (
        done.stderr.splitlines()[0]
        == "all images are taken to be from the one place that --camera tells; where the camera moved, give --poses"
    )
    placed = plogic(*both, "--poses", "scene/poses.json", "--deadline", "0.001", cwd=tmp_path)
    assert f"v2 {frame}: " in placed.stderr
    assert "one place" not in placed.stderr


def test_poses_of_other_names_go_by_their_order(frames, two, tmp_path):
    lines = []
    for n, angle in enumerate(ANGLES[:2]):
        pose = turned(angle)
        from scipy.spatial.transform import Rotation

        quat = Rotation.from_matrix(pose[:3, :3]).as_quat()
        lines.append(" ".join(map(str, [1000.5 + n, *pose[:3, 3], *quat])))
    (tmp_path / "tum.txt").write_text("\n".join(lines))
    by_order = document("perceive", *names(2), "--kb", "towers", "--poses", tmp_path / "tum.txt", cwd=frames)
    poses = [[np.array(o["T_world_object"]) for o in told["objects"]] for told in (by_order, json.loads(two))]
    assert np.allclose(poses[0], poses[1], atol=1e-6)


def test_the_same_bytes_twice(frames, two):
    assert good("perceive", *OF_TWO, cwd=frames, PYTHONHASHSEED="1") == two


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["f1.json", "f2.json"], "f1.json: where its camera stood is not known"),
        (["f1.json", "nope.json", "--poses", "poses.json"], "nope.json: poses.json has no pose of this name"),
        (["f1.json", "f2.json", "--poses", "none.json"], "none.json: is missing"),
        (["f1.json", "f2.json", "--poses", "poses.json", "--report", "page.html"], "--report: is made of one frame"),
        (["f1.json", "f2.json", "--poses", "poses.json", "-o", "f1.json/x"], "f1.json"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(frames, arguments, words):
    before = sorted(frames.iterdir())
    done = plogic("perceive", *arguments, "--kb", "towers", cwd=frames)
    assert done.returncode == 1
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert sorted(frames.iterdir()) == before


def test_a_frame_that_cannot_be_used_costs_nothing_of_those_before_it(frames, two_by_posterior, tmp_path):
    (tmp_path / "f1.json").write_bytes((frames / "f1.json").read_bytes())
    (tmp_path / "f2.json").write_bytes((frames / "f2.json").read_bytes())
    (tmp_path / "f3.json").write_text('{"format": "gamma/1"')
    (tmp_path / "f4.json").write_bytes((frames / "f4.json").read_bytes())
    more = ("--kb", "towers", "--poses", frames / "poses.json", "--reading", "posterior")
    done = plogic("perceive", *names(4), *more, "-o", "p.json", cwd=tmp_path)
    assert done.returncode == 1
    assert "f3.json: cannot be used; what is written is of the 2 before it" in done.stderr
    assert "Traceback" not in done.stderr
    told = json.loads((tmp_path / "p.json").read_text())
    assert told["views"] == two_by_posterior["views"]
    first = plogic("perceive", "f3.json", "f4.json", *more, "-o", "q.json", cwd=tmp_path)
    assert first.returncode == 1
    assert not (tmp_path / "q.json").exists()


@pytest.mark.parametrize("text", [None, '{"format": "panorama/1", "views": 5}'], ids=["one", "hostile"])
def test_a_sequence_that_is_asked_says_what_of_it_can_be(two, tmp_path, text):
    (tmp_path / "panorama.json").write_text(text or two)
    run = plogic("query", tmp_path / "panorama.json")
    assert run.returncode == 1
    (line,) = run.stderr.splitlines()
    assert line.endswith("should be 'interpretation/1'" + OF_SEVERAL)
