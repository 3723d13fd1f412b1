"""A camera that is not the picture's: the poses fit all the same, and what they fit better is told."""

from __future__ import annotations

import json

import pytest
from console import document, good, plogic
from in_process import told
from jsonschema import Draft202012Validator

FIT = "the accepted objects fit a focal length of "


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lens") / "scene"
    told("simulate", "--kb", "towers", "--gamma", "--seed", "2", "-o", str(folder))
    return folder


def with_focal(scene, share):
    """The scene's Γ under a camera whose focal length is off."""
    gamma = json.loads((scene / "gamma.json").read_text(encoding="utf-8"))
    gamma["camera"]["K"][0][0] *= share
    gamma["camera"]["K"][1][1] *= share
    place = scene / f"gamma-{share}.json"
    place.write_text(json.dumps(gamma), encoding="utf-8")
    return place


def lines(scene, share, tmp_path):
    return [
        line
        for line in told("perceive", str(with_focal(scene, share)), "--kb", "towers", "-o", str(tmp_path / "o.json"))
        if FIT in line
    ]


def test_the_right_camera_is_not_doubted(scene, tmp_path):
    assert lines(scene, 1.0, tmp_path) == []
    assert "camera_doubt" not in json.loads((tmp_path / "o.json").read_text(encoding="utf-8"))


def test_the_interpretation_holds_it_and_says_the_same(scene, tmp_path):
    (line,) = lines(scene, 1.8, tmp_path)
    found = json.loads((tmp_path / "o.json").read_text(encoding="utf-8"))
    doubt, K = found["camera_doubt"], found["camera"]["K"]
    assert doubt["why"] == line
    assert doubt["stated"] == pytest.approx(K[0][0])
    assert abs(doubt["focal"] - K[0][0] / 1.8) < 4.0 * doubt["standard_error"]
    assert list(Draft202012Validator(document("schema", "interpretation")).iter_errors(found)) == []
    assert document("worlds", tmp_path / "o.json", "--json")["format"] == "worlds/1"


@pytest.mark.parametrize("full", [(), ("--full",)], ids=["short", "full"])
def test_batch_tells_it_once_and_each_line_has_it(scene, full):
    names = [with_focal(scene, share).name for share in (1.0, 1.75, 1.8)]
    run = plogic("batch", *names, "--kb", "towers", "--jobs", 1, "-o", "-", *full, cwd=scene)
    assert run.returncode == 0, run.stderr
    rows = [json.loads(line) for line in run.stdout.splitlines()]
    assert [row["input"] for row in rows if "camera_doubt" in row.get("interpretation", row)] == names[1:]
    (line,) = [line for line in run.stderr.splitlines() if FIT in line]
    assert line.startswith(f"{names[1]}: {FIT}")
    assert run.stderr.splitlines()[-1] == "3 frames, 2 with a guessed or doubtful camera (notes, camera_doubt)"
    schema = document("schema", "frame")
    assert not any(list(Draft202012Validator(schema).iter_errors(row)) for row in rows)


def test_watch_tells_it_once_and_each_line_has_it(tmp_path):
    """The demo's picture, twice, under a camera of almost twice its focal length."""
    good("demo", "-o", tmp_path / "demo")
    camera = json.loads((tmp_path / "demo" / "camera.json").read_text(encoding="utf-8"))
    (tmp_path / "twice.bin").write_bytes((tmp_path / "demo" / "image.png").read_bytes() * 2)
    run = plogic("watch", "twice.bin", "--kb", "towers", "--focal", 1.7 * camera["K"][0][0], "--short", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    rows = [json.loads(line) for line in run.stdout.splitlines()]
    assert ["camera_doubt" in row for row in rows] == [True, True]
    (line,) = [line for line in run.stderr.splitlines() if FIT in line]
    assert line.startswith("twice_000000: ")


@pytest.mark.parametrize("share", [0.6, 1.8])
def test_a_wrong_one_is_and_the_right_focal_length_is_named(scene, tmp_path, share):
    (line,) = lines(scene, share, tmp_path)
    camera = json.loads((scene / "gamma.json").read_text(encoding="utf-8"))["camera"]
    said = float(line.removeprefix(FIT).split()[0])
    error = float(line.split("standard error ")[1].split(")")[0])
    right = camera["K"][0][0]
    assert abs(said - right) < 4.0 * error
    assert f"the camera's {right * share:.0f}" in line
    assert "is it this picture's camera" in line
