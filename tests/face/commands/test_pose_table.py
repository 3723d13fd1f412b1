"""``plogic worlds --poses``: a row an object a world, of the camera's frame and, where it is known, of the world's."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from console import good, plogic


@pytest.fixture(scope="module")
def scene(demo):
    return json.loads((demo / "interpretation.json").read_text(encoding="utf-8"))


def table(place, document):
    place.write_text(json.dumps(document), encoding="utf-8")
    return list(csv.DictReader(good("worlds", place, "--poses").splitlines()))


def matrix(text):
    return np.array(text.split(), float).reshape(4, 4)


def test_each_object_of_each_world_has_a_row(scene, tmp_path):
    scene["camera"].pop("T_world_camera", None)
    rows = table(tmp_path / "scene.json", scene)
    (best, *_) = scene["worlds"]
    assert [row["object"] for row in rows if row["world"] == "1"] == best["present"] != []
    known = {h["id"]: h for h in scene["hypotheses"]}
    for row in rows:
        h = known[row["object"]]
        assert (row["type"], float(row["probability"])) == (h["type"], h["probability"])
        assert matrix(row["T_camera_object_m"]).tolist() == h["T_camera_object"]
    assert "T_world_object_m" not in rows[0]


def test_a_camera_with_a_pose_tells_of_the_world(scene, tmp_path):
    placed = [[0, 0, 1, 1], [-1, 0, 0, 2], [0, -1, 0, 3], [0, 0, 0, 1]]
    rows = table(tmp_path / "scene.json", {**scene, "camera": {**scene["camera"], "T_world_camera": placed}})
    x, y, z = matrix(rows[0]["T_camera_object_m"])[:3, 3]
    assert matrix(rows[0]["T_world_object_m"])[:3, 3] == pytest.approx([z + 1, 2 - x, 3 - y])


def test_what_has_no_poses_is_said(demo, tmp_path):
    (tmp_path / "rain.pl").write_text("0.3::rain. query(rain).", encoding="utf-8")
    for asked in ((tmp_path / "rain.pl", "--poses"), (demo / "interpretation.json", "--poses", "--json")):
        run = plogic("worlds", *asked)
        assert (run.returncode, run.stdout) == (1, "")
        assert run.stderr.startswith("plogic: --poses: ")
