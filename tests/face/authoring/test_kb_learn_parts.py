"""``kb add`` and ``kb learn`` of a mesh of two parts that a quarter turn leaves as it is.

Both are found, written, shown, and of use.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
from console import bytes_in, few_views, good, plogic
from painted_cube import CAMERA, pose_towards
from shared_folder import shared
from twin_cubes import write_twins

from geometry.frames import pose_error
from kb.files.read import read_kb
from sensing.simulated.body import Body, read_mesh
from sensing.simulated.camera import Sensor, render
from sensing.simulated.surroundings import Light, Surroundings


@pytest.fixture(scope="module")
def surroundings(tmp_path_factory):
    """Environment variables for the console script."""
    return few_views(shared(tmp_path_factory, "few_parts", few_views))


@pytest.fixture(scope="module")
def learned(tmp_path_factory, surroundings):
    """A knowledge base, its parts renamed by their author, and what ``kb add`` and ``kb learn`` said."""

    def make(folder):
        good("kb", "new", folder / "kb")
        added = good("kb", "add", "twins", "--mesh", write_twins(folder), "--units", "m", "--kb", folder / "kb")
        file = folder / "kb" / "objects" / "twins" / "object.yaml"
        text = file.read_text()
        assert "\n  - {part: part_1, at: [0, 0, 0]}\n  - {part: part_2, at: [0, 0, 0.12]}\n" in text
        file.write_text(text.replace("part_1", "lower").replace("part_2", "upper"))
        done = plogic("kb", "learn", "--jobs", 1, "--json", "--kb", folder / "kb", **surroundings)
        assert done.returncode == 0, done.stderr
        (folder / "said.json").write_text(json.dumps([added, json.loads(done.stdout)]))

    folder = shared(tmp_path_factory, "twins", make)
    return folder / "kb", *json.loads((folder / "said.json").read_text())


def test_the_pieces_are_parts_and_have_their_features(learned):
    folder, added, _ = learned
    assert "parts: 2 pieces, a part each in object.yaml" in added
    (kind,) = read_kb(folder).types
    heads = np.array([f.name.split("/")[0] for f in kind.seen_features])
    assert set(heads) == {"lower", "upper"}
    assert (np.where(kind.learned.at[:, 2] < 0.06, "lower", "upper") == heads).all()
    assert "object upper at [0, 0, 0.12], " in good("kb", "show", folder, "twins")
    assert "no mistakes" in good("kb", "check", folder)


def test_the_quarter_turn_holds_and_is_written_below_the_comments(learned):
    folder, _, document = learned
    rows = {row["turn"].split("]")[0]: row for row in document["types"][0]["symmetries"]}
    assert {turn: row["verdict"] for turn, row in rows.items()} == {
        "{axis: [1, 0, 0": "broken",
        "{axis: [0, 1, 0": "broken",
        "{axis: [0, 0, 1": "holds",
    }
    assert rows["{axis: [0, 0, 1"]["share"] > 10 * rows["{axis: [1, 0, 0"]["share"]
    text = (folder / "objects" / "twins" / "object.yaml").read_text()
    assert "# The shape alone has these symmetries." in text
    assert "\nsymmetries: [{axis: " in text
    (kind,) = read_kb(folder).types
    assert len(kind.symmetries) == 4


def test_what_object_yaml_states_stays(learned, surroundings, tmp_path):
    copy = shutil.copytree(learned[0], tmp_path / "kb")
    file = copy / "objects" / "twins" / "object.yaml"
    lines = [line for line in file.read_text().splitlines() if not line.startswith("symmetries:")]
    file.write_text("\n".join([*lines, "symmetries: []  # they differ below"]) + "\n")
    before = bytes_in(copy)
    done = plogic("kb", "learn", "twins", "--jobs", 1, "--kb", copy, **surroundings)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "twins: symmetries: as object.yaml states them"
    assert bytes_in(copy) == before


def test_in_a_picture_parts_are_facts_and_poses_are_known_up_to_the_turn(learned, tmp_path):
    folder = learned[0]
    (kind,) = read_kb(folder).types
    eye = np.diag([1.0, -1.0, -1.0, 1.0])
    eye[2, 3] = 50.0
    truth = pose_towards((1.0, -0.8, 0.5), 0.8)
    body, camera = Body("twins", read_mesh(kind.mesh_file), eye @ truth), replace(CAMERA, world_from_camera=eye)
    image = render([body], camera, Light(), Surroundings(contrast=0, shadow=0), Sensor(noise=3.5, seed=0)).image
    cv2.imwrite(str(tmp_path / "seen.png"), image)
    (tmp_path / "camera.json").write_text(
        json.dumps({"width": CAMERA.width, "height": CAMERA.height, "K": CAMERA.K.tolist(), "dist": []})
    )
    good(
        "perceive",
        tmp_path / "seen.png",
        "--camera",
        tmp_path / "camera.json",
        "--kb",
        folder,
        "-o",
        tmp_path / "i.json",
    )
    document = json.loads((tmp_path / "i.json").read_text())
    (present,) = document["worlds"][0]["present"]
    (found,) = [h for h in document["hypotheses"] if h["id"] == present]
    assert np.degrees(pose_error(np.array(found["T_camera_object"]), truth, kind.symmetries)[0]) < 5.0
    program = good("program", tmp_path / "i.json")
    assert f"hypothesis({present}, {found['type']})." in program
    assert f"type_part({found['type']}/lower, {found['type']}). object_part({found['type']}/lower)." in program
    assert f", {found['type']}/upper)." in program
    answers = json.loads(good("query", tmp_path / "i.json", f"pp({present}/upper, {present})", "--json"))["answers"]
    assert answers[0]["probability"] == pytest.approx(found["probability"], abs=1e-9)
