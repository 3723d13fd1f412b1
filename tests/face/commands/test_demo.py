"""``plogic demo``: every file, what is told on stdout, and the same bytes again."""

from __future__ import annotations

import json
import re

import cv2
import pytest
from console import bytes_in, document, plogic

READINGS = {"": "score", "posterior-": "posterior"}
FILES = ["image.png", "camera.json", "truth.json", "gamma.json"]
FILES += [
    f"{prefix}{name}"
    for prefix in READINGS
    for name in ("interpretation.json", "picture.png", "page.html", "program.pl")
]


def read(demo, name):
    return json.loads((demo / name).read_text())


def test_every_file_is_written_and_nothing_else(demo):
    assert sorted(bytes_in(demo)) == sorted(FILES)
    assert all(bytes_in(demo).values())


def test_the_image_has_the_cameras_size(demo):
    camera = read(demo, "camera.json")
    assert cv2.imread(str(demo / "image.png")).shape == (camera["height"], camera["width"], 3)
    assert read(demo, "gamma.json")["camera"] == camera


@pytest.mark.parametrize("prefix", READINGS)
def test_the_picture_is_the_image_with_something_drawn_on_it(demo, prefix):
    picture, image = cv2.imread(str(demo / f"{prefix}picture.png")), cv2.imread(str(demo / "image.png"))
    assert picture is not None
    assert picture.shape[0] >= image.shape[0]
    assert picture.tobytes() != image.tobytes()


@pytest.mark.parametrize("prefix", READINGS)
def test_both_towers_are_found_where_they_stand(demo, prefix):
    interpretation, truth = read(demo, f"{prefix}interpretation.json"), read(demo, "truth.json")
    assert interpretation["format"] == "interpretation/1"
    assert interpretation["reading"] == READINGS[prefix]
    accepted = {h["type"]: h for h in interpretation["hypotheses"] if h["status"] == "accepted"}
    real = {o["label"]: o["T_camera_object"] for o in truth["objects"]}
    assert set(accepted) == set(real) == {"t1", "t2"}
    for name, pose in real.items():
        found = accepted[name]["T_camera_object"]
        distance = sum(row[3] ** 2 for row in pose[:3]) ** 0.5
        apart = sum((row[3] - other[3]) ** 2 for row, other in zip(pose[:3], found[:3], strict=True)) ** 0.5
        assert apart < 0.02 * distance


@pytest.mark.parametrize("prefix", READINGS)
def test_the_top_world_holds_both_and_the_worlds_add_up_to_one(demo, prefix):
    interpretation = read(demo, f"{prefix}interpretation.json")
    assert interpretation["worlds"][0]["present"] == ["h1", "h2"]
    listed = sum(w["probability"] for w in interpretation["worlds"])
    low, high = interpretation["unlisted_mass"]
    assert low <= high
    assert listed + low - 1e-9 <= 1.0 <= listed + high + 1e-9
    ranked = [w["probability"] for w in interpretation["worlds"]]
    assert ranked == sorted(ranked, reverse=True)


@pytest.mark.parametrize("prefix", READINGS)
def test_every_appearance_has_one_cause_in_every_world(demo, prefix):
    interpretation = read(demo, f"{prefix}interpretation.json")
    ids = [a["id"] for a in interpretation["appearances"]]
    assert ids == [a["id"] for a in read(demo, "gamma.json")["appearances"]]
    assert [list(w["causes"]) for w in interpretation["worlds"]] == [ids] * len(interpretation["worlds"])


def test_the_occlusion_is_told_as_it_is(demo):
    """One tower partly hides the other, by the truth's visible fractions."""
    hidden = min(read(demo, "truth.json")["objects"], key=lambda o: o["visible_fraction"])
    assert hidden["visible_fraction"] < 0.999
    types = {h["id"]: h["type"] for h in read(demo, "interpretation.json")["hypotheses"]}
    first = read(demo, "interpretation.json")["relations"][0]
    assert (first["relation"], types[first["args"][1]]) == ("partially_occludes", hidden["label"])


def test_stdout_tells_the_worlds_of_the_interpretation(demo_run, demo):
    out = demo_run[0].stdout
    told = re.findall(r"^ +(\d+) +([01]\.\d{3}) +(nothing known|t[12] h\d(?:, t[12] h\d)*) ", out, re.MULTILINE)
    interpretation = read(demo, "interpretation.json")
    types = {h["id"]: h["type"] for h in interpretation["hypotheses"]}
    expected = [
        (str(i), f"{w['probability']:.3f}", ", ".join(f"{types[h]} {h}" for h in w["present"]) or "nothing known")
        for i, w in enumerate(interpretation["worlds"], 1)
    ]
    assert expected
    assert told == expected
    assert f"look at {demo}/page.html" in out


def test_progress_goes_to_stderr_without_control_characters(demo_run):
    run, _ = demo_run
    assert "rendering" in run.stderr
    assert "rendering" not in run.stdout
    assert "\x1b" not in run.stdout + run.stderr
    assert "\r" not in run.stdout + run.stderr


def test_a_second_run_gives_the_same_bytes_over_the_first(demo, tmp_path):
    (tmp_path / "image.png").write_bytes(b"of an earlier run")
    told = document("demo", "-o", tmp_path, "--json", "--reading", "posterior", PYTHONHASHSEED="38")
    first, second = bytes_in(demo), bytes_in(tmp_path)
    assert [name for name in FILES if first[name] != second[name]] == []
    assert set(second) == set(FILES)
    assert told["format"] == "demo/1"
    assert told["worlds"] == read(demo, "posterior-interpretation.json")["worlds"]
    assert {a["goal"] for a in told["answers"]} >= {"present(h1)", "present(h2)"}


def test_a_file_in_the_place_of_the_folder_is_told_before_any_work(tmp_path):
    (tmp_path / "taken").write_text("mine")
    for out in ("taken", "taken/below"):
        run = plogic("demo", "-o", out, cwd=tmp_path)
        assert (run.returncode, run.stdout) == (1, "")
        assert run.stderr == f"plogic: {out}: cannot be written: taken is no folder\n"
    assert bytes_in(tmp_path) == {"taken": b"mine"}


def test_a_camera_that_lies_beside_the_picture_is_taken_and_that_is_said(demo, tmp_path):
    run = plogic("perceive", demo / "image.png", "--kb", "towers", "-o", tmp_path / "out.json")
    assert run.stderr.splitlines()[0].endswith(f"image.png: its camera is {demo / 'camera.json'}, which lies beside it")
    assert (tmp_path / "out.json").read_bytes() == (demo / "interpretation.json").read_bytes()
