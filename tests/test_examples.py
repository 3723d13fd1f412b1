"""The shipped KB `first` and its Γ.

What the README tells a newcomer to do works, and comes to the truth that the Γ was made from.
"""

import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from geometry.frames import pose_error
from kb.files.folder import shipped
from kb.files.read import read_kb
from kb.shown.show import check_report
from plogic.cycle.delta import Options
from plogic.face.authoring.kb_show import measures_command
from plogic.run.perceive import Perceiver
from sensing.files.gamma_files import read_gamma

EXAMPLES = Path(__file__).parent.parent / "examples"
KB = shipped("first")
GAMMA = EXAMPLES / "first_gamma.json"


@pytest.fixture(scope="module")
def maker():
    return runpy.run_path(str(EXAMPLES / "first_gamma.py"))


@pytest.fixture(scope="module")
def interpreted():
    kb = read_kb(KB)
    return Perceiver(kb)(read_gamma(GAMMA, kb.appearance_types), Options())


def test_the_knowledge_base_has_no_mistake_and_no_warning():
    lines = check_report(read_kb(KB))
    assert len(lines) == 2, lines
    assert "no mistakes" in lines[0]


def test_the_rarer_type_is_the_more_distinctive():
    rows = json.loads(measures_command(str(KB), None, as_json=True))["features"]
    dv = {row["type"]: row["dv"] for row in rows}
    assert dv["sticker"] == pytest.approx(8 / 13)
    assert dv["corner"] == pytest.approx(5 / 13)


def test_the_gamma_is_what_the_script_prints(maker):
    assert GAMMA.read_text(encoding="utf-8") == maker["text"]()


def test_the_box_is_found_where_it_stands(interpreted, maker):
    (box,) = (h for h in interpreted["hypotheses"] if h["status"] == "accepted")
    rotation, translation = pose_error(np.array(box["T_camera_object"]), maker["CAMERA_FROM_BOX"])
    assert box["type"] == "box"
    assert rotation < np.radians(1.0)
    assert translation < 0.005
    assert interpreted["worlds"][0]["present"] == [box["id"]]


def test_each_appearance_has_its_cause(interpreted, maker):
    causes = interpreted["worlds"][0]["causes"]
    rows = maker["gamma"]()["appearances"]
    clutter = {row["id"] for row in rows if (row["type"], tuple(row["uv"])) in maker["CLUTTER"]}
    assert len(clutter) == 3
    assert {name for name, cause in causes.items() if cause == "noise"} == clutter
    taken = [cause for cause in causes.values() if cause != "noise"]
    assert len(set(taken)) == len(taken) == len(rows) - len(clutter)
    assert not [cause for cause in taken if cause.endswith(f"/{maker['MISSED']}")]


def test_the_missed_corner_is_the_one_miss(interpreted):
    (box,) = (h for h in interpreted["hypotheses"] if h["status"] == "accepted")
    missed = {name: cells["expected_missed"] for name, cells in box["support"].items()}
    assert missed == {"corner": 1, "sticker": 0}


def test_the_trace_says_what_was_tried(interpreted):
    events = [step["event"] for step in interpreted["trace"]]
    assert events[0] == "rank"
    assert "accept" in events
    assert events[-1] == "stable"
    assert all(step["why"] for step in interpreted["trace"])
