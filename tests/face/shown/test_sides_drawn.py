"""Sides of edges in the picture and on the page.

Strokes where they were found, crosses where not, and words that say what they are.
"""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from page_checks import COUNT, complaints, shown_as
from towers_scene import HEIGHT

from plogic.face.pages.one_file import page
from plogic.face.shown.overlay import PALETTE, bgr, overlay, sides_of
from plogic.face.shown.pencil import Pencil

OTHERS = {
    "id": "(others)",
    "type": "(others)",
    "case": "B",
    "expected": False,
    "detected": False,
    "match": None,
    "in_lobe": False,
}
OTHERS |= {"in_image": True, "hidden_by": [], "stands_for": 1000}
TEXT = "return document.querySelector(arguments[0]).textContent"
INK = """const c = document.querySelector('.dots'), k = c.width / arguments[2], px = devicePixelRatio || 1;
const x = Math.round((arguments[0] + 0.5) * k), y = Math.round((arguments[1] + 0.5) * k), r = Math.round(7 * px);
const p = c.getContext('2d').getImageData(x - r, y - r, 2 * r + 1, 2 * r + 1).data;
const w = 2 * r + 1, up = [...Array(w).keys()];
return up.map((i) => up.map((j) => p[4 * (i * w + j) + 3]))"""
POINT = """const c = document.querySelector('.dots'), b = c.getBoundingClientRect(), k = b.width / arguments[2];
c.dispatchEvent(new PointerEvent('pointermove', {clientX: b.left + (arguments[0] + 0.5) * k, clientY: b.top + (arguments[1] + 0.5) * k}))"""
FOUND, MISSED = (
    {"id": "s1", "type": "sift_w0007", "uv": [60.0, 40.0]},
    {"id": "s2", "type": "sift_w0007", "uv": [100.0, 40.0]},
)
STROKES = (0.0, math.pi / 2, math.pi, -math.pi / 2)


def with_sides(towers, angle=math.pi / 2):
    """The towers as learned types; h1 has one side of an edge found, whose ``angle`` is downwards, and one missed."""
    document = copy.deepcopy(towers)
    a = {
        "id": "e1",
        "type": "sift_w0007",
        "uv": [60.0, 40.0],
        "detector": "sift",
        "angle": angle,
        "score": 0.5,
        "clutter": 1e-5,
    }
    k = {
        "id": "e2",
        "type": "sift_w0003",
        "uv": [20.0, 20.0],
        "detector": "sift",
        "angle": 1.0,
        "scale": 4.0,
        "score": 0.5,
        "clutter": 1e-5,
    }
    document["appearances"] += [a, k]
    base = {
        "in_image": True,
        "in_lobe": True,
        "self_hidden": False,
        "hidden_by": [],
        "expected": True,
        "at": [0.0, 0.0, 5.0],
        "residual": None,
    }
    first = document["hypotheses"][0]
    first["features"] += [
        FOUND | base | {"match": "e1", "residual": 0.4, "detected": True, "case": "A"},
        MISSED | base | {"match": None, "detected": False, "case": "C"},
        first["features"][0] | OTHERS,
    ]
    document["worlds"][0]["causes"]["e1"] = "h1/s1"
    return document


def inked(picture, ground=205):
    """(N, 2) columns and rows of what is drawn, from the middle."""
    row, column = np.nonzero((picture != ground).any(-1))
    return np.column_stack([column, row]) - picture.shape[0] // 2


@pytest.mark.parametrize("angle", STROKES)
def test_a_side_is_a_stroke_along_its_edge_with_a_tick_towards_it(angle):
    picture = np.full((41, 41, 3), 205, np.uint8)
    Pencil(picture, 1).side((20, 20), angle, bgr(PALETTE[0]))
    across = inked(picture) @ [math.cos(angle), math.sin(angle)]
    along = inked(picture) @ [-math.sin(angle), math.cos(angle)]
    assert across.max() > 5
    assert across.min() > -4
    assert along.max() > 4
    assert along.min() < -4


def test_found_and_missed_sides_differ_from_each_other_and_from_keypoints():
    pictures = []
    for draw in ("side", "cross", "dot", "ring"):
        picture = np.full((41, 41, 3), 205, np.uint8)
        pencil, colour = Pencil(picture, 1), bgr(PALETTE[1])
        if draw == "side":
            pencil.side((20, 20), 0.7, colour)
        elif draw == "cross":
            pencil.cross((20, 20), colour)
        else:
            pencil.dot((20, 20), colour, circle=True, filled=draw == "dot")
        pictures.append(picture)
    apart = [np.count_nonzero((a != b).any(-1)) for i, a in enumerate(pictures) for b in pictures[:i]]
    assert min(apart) > 10


def test_sides_are_told_by_having_an_angle_and_no_scale(towers):
    sides = sides_of(with_sides(towers))
    assert sides.angle == {"e1": math.pi / 2}
    assert sides.types == {"sift_w0007"}
    case = {"type": "sift_w0007", "match": None, "case": "C"}
    assert sides.case(case) == "C"
    assert sides.case(case | {"case": "D"}) is None
    assert sides.case(case | {"type": "sift_w0003"}) is None
    assert sides.case({"type": "sift_w0003", "match": "e1", "case": "A"}) == "A"
    assert sides_of(towers).angle == {}


def test_the_overlay_turns_a_stroke_with_its_angle_and_its_legend_counts_sides(towers):
    down, up = (overlay(with_sides(towers, angle), None) for angle in (math.pi / 2, -math.pi / 2))
    changed = np.argwhere((down != up).any(-1))
    assert np.abs(changed - [2 * FOUND["uv"][1] + 0.5, 2 * FOUND["uv"][0] + 0.5]).max() < 12
    assert len(changed) > 20
    bare = with_sides(towers)
    bare["hypotheses"][0]["features"] = [f for f in bare["hypotheses"][0]["features"] if f["id"] not in ("s1", "s2")]
    assert (overlay(bare, None)[2 * HEIGHT :] > 100).sum() < (down[2 * HEIGHT :] > 100).sum()


@pytest.fixture
def seen(chromium, towers, tmp_path):
    return shown_as(chromium, tmp_path, page(with_sides(towers)))


def ink(browser, feature, width):
    return np.array(browser.run(INK, *feature["uv"], width)) > 60


def test_the_page_draws_strokes_and_crosses_that_can_be_switched(seen, towers):
    wide = towers["camera"]["width"]
    found, missed = ink(seen, FOUND, wide), ink(seen, MISSED, wide)
    half = len(found) // 2
    assert found[half + 3 :].any()
    assert not found[: half - 3].any(), "the tick goes down"
    assert found[half].sum() > found[half + 3].sum()
    assert missed.any()
    assert abs(int(missed[:half].sum()) - int(missed[half + 1 :].sum())) < 8
    seen.click("[data-layer='sides']")
    assert not ink(seen, FOUND, wide).any()
    assert not ink(seen, MISSED, wide).any()


def test_the_page_counts_sides_and_never_calls_them_keypoints(seen):
    assert seen.run(TEXT, "[data-sides=A]") == "1 side of an edge"
    assert seen.run(TEXT, "[data-sides=C]") == "1 side of an edge"
    assert seen.run(COUNT, "[data-sides]") == 2
    key = seen.run(TEXT, "#signs-key")
    assert "side of an edge 1" in key
    assert "sift keypoint 1" in key
    assert complaints(seen) == []


def test_a_side_says_what_it_is_when_pointed_at(seen, towers):
    wide = towers["camera"]["width"]
    seen.run(POINT, *FOUND["uv"], wide)
    seen.settle()
    told = seen.run(TEXT, "#about")
    assert "sift w0007, the side of an edge, case A." in told
    assert "0.4 px off across the edge" in told
    seen.run(POINT, *MISSED["uv"], wide)
    seen.settle()
    assert "sift w0007, the side of an edge, case C." in seen.run(TEXT, "#about")


def test_names_stand_above_the_marks(seen):
    assert seen.run(COUNT, ".over .name") == 2
    assert (
        seen.run(
            "const [a, b] = ['.dots', '.over'].map((s) => document.querySelector(s)); return a.compareDocumentPosition(b)"
        )
        == 4
    )


def test_a_photo_without_sides_says_nothing_of_them(chromium, towers, tmp_path):
    document = with_sides(towers)
    document["appearances"] = [a for a in document["appearances"] if a["id"] != "e1"]
    document["hypotheses"][0]["features"] = [
        f for f in document["hypotheses"][0]["features"] if f["id"] not in ("s1", "s2")
    ]
    shown_as(chromium, tmp_path, page(document))
    assert chromium.run(COUNT, "[data-layer='sides'], [data-sides]") == 0
    assert complaints(chromium) == []
