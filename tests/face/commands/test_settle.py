"""``plogic settle`` as a user runs it: on the demo's interpretation and on boxes, as a table, as JSON, as a picture."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from boxes_document import at, boxes_document
from console import document, good, plogic

from plogic import Interpretation
from sensing.simulated.physics import has_physics

pytestmark = pytest.mark.skipif(not has_physics(), reason="pybullet is not installed")


def written(folder, *boxes, **options):
    path = folder / "boxes.json"
    path.write_text(json.dumps(boxes_document(*boxes, **options)))
    return path


@pytest.fixture
def lifted(tmp_path):
    """A crate on the floor, and a carton 5 cm above it."""
    return written(tmp_path, ("a", "crate", at(0, 0, 0)), ("b", "carton", at(0, 0, 0.15)))


def test_the_demo_s_towers_stand(demo):
    found = document("settle", demo / "interpretation.json", "--worlds", 3, "--json")
    assert (found["format"], found["seconds"], len(found["worlds"])) == ("settled/1", 2.0, 3)
    rows = [row for world in found["worlds"] for row in world["objects"]]
    assert len(rows) >= 4
    assert {row["verdict"] for row in rows} == {"stands"}
    assert all(row["moved"] < 0.02 for row in rows)


def test_the_table_says_who_falls_and_how_far(lifted):
    text = good("settle", lifted)
    assert "world 1, probability 0.900; floor: ground" in text
    cells = {
        line.split()[1]: line.split()[2:] for line in text.splitlines() if line.startswith((" crate a", " carton b"))
    }
    assert cells["a"][0] == "stands"
    assert cells["b"][0] == "falls"
    assert float(cells["b"][3]) == pytest.approx(0.05, abs=0.002)
    assert "allowed  5 mm + 2 % of its distance from the camera" in text
    assert good("settle", "-", stdin=lifted.read_text()) == text


def test_held_and_dropped(tmp_path):
    path = written(tmp_path, ("a", "crate", at(0, 0, 0.3)))
    told = json.loads(path.read_text())
    told["facts"] = [{"fact": "foot", "args": ["a"], "low": 0.29, "high": 0.31}]
    path.write_text(json.dumps(told))
    for options, verdict in (((), "held"), (("--drop",), "falls")):
        (world,) = document("settle", path, "--json", *options)["worlds"]
        assert [row["verdict"] for row in world["objects"]] == [verdict]


def test_the_picture_shows_outlines_before_and_after(lifted, tmp_path):
    good("settle", lifted, "--picture", tmp_path / "p.png")
    picture = cv2.imread(str(tmp_path / "p.png"))
    assert picture.shape[1] == 1280
    drawn = (np.abs(picture[:960].astype(int) - 205).max(axis=2) > 40).nonzero()
    assert len(drawn[0]) > 1000


def test_from_python_it_is_the_same(lifted):
    found = Interpretation.load(lifted).settle()
    assert str(found) + "\n" == good("settle", lifted)
    assert [(row.id, row.verdict, row.world) for row in found] == [("a", "stands", 1), ("b", "falls", 1)]
    assert found.document == document("settle", lifted, "--json")
    assert list(found.to_pandas()["verdict"]) == ["stands", "falls"]


def test_where_nobody_knows_up_it_says_so(tmp_path):
    path = written(tmp_path, ("a", "crate", at(0, 0, 0)), ground=None)
    told = json.loads(path.read_text())
    del told["camera"]["T_world_camera"]
    path.write_text(json.dumps(told))
    done = plogic("settle", path)
    assert done.returncode == 1
    assert done.stderr.startswith("plogic: nobody knows which way is up: the interpretation has no support plane")


def test_without_worlds_there_is_nothing_to_let_go(tmp_path):
    path = written(tmp_path)
    told = json.loads(path.read_text()) | {"worlds": []}
    path.write_text(json.dumps(told))
    assert good("settle", path) == "the interpretation lists no world\n"
    done = plogic("settle", path, "--picture", tmp_path / "p.png")
    assert done.returncode == 1
    assert "--picture: the interpretation lists no world" in done.stderr
