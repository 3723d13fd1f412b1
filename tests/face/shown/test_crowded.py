"""A photo's interpretation, thousands of keypoints and features that stand for a thousand others.

Dots instead of marks, nothing covered.
"""

from __future__ import annotations

import copy

import numpy as np
import pytest
from page_checks import COUNT, complaints, shown_as
from towers_scene import HEIGHT, WIDTH

from plogic.face.pages.one_file import page
from plogic.face.shown.overlay import PALETTE, bgr, crowded, overlay

INK = """const c = document.querySelector('.dots'); const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
let n = 0; for (let i = 3; i < p.length; i += 4) if (p[i]) n += 1; return n"""
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
PRESS = "const c = document.querySelector('.dots'); c.dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0]}))"


@pytest.fixture(scope="module")
def photo(towers):
    """The towers among 3,000 keypoints of noise, each type with a thousand features more, one hypothesis rejected."""
    rng = np.random.default_rng(4)
    document = copy.deepcopy(towers)
    uv = rng.uniform(0, 1, (3000, 2)) * [WIDTH, HEIGHT]
    document["appearances"] += [
        {
            "id": f"k{i}",
            "type": f"sift_w{i % 900:04d}",
            "uv": uv[i].round(2).tolist(),
            "detector": "sift",
            "clutter": 1e-6,
        }
        for i in range(3000)
    ]
    document["causes_else"] = "noise"
    first = document["hypotheses"][0]
    for h in document["hypotheses"]:
        if h["status"] == "accepted":
            h["features"].append(h["features"][0] | OTHERS)
    document["hypotheses"].append(
        first | {"id": "r9", "status": "rejected", "features": [], "why": "log-likelihood ratio 3.1: luck"}
    )
    return document


@pytest.fixture
def seen(chromium, photo, tmp_path):
    return shown_as(chromium, tmp_path, page(photo))


def test_noise_does_not_cover_the_picture(photo, towers):
    assert crowded(photo)
    assert not crowded(towers)
    few = photo | {"appearances": photo["appearances"][:501]}
    assert np.array_equal(overlay(photo, None), overlay(few, None))


def test_outlines_and_dots_have_their_colours(photo):
    picture = overlay(photo, None)[: 2 * HEIGHT]
    accepted = [h for h in photo["hypotheses"] if h["status"] == "accepted"]
    assert len(accepted) == 2
    for i, h in enumerate(accepted):
        own = (picture == bgr(PALETTE[i])).all(-1)
        found = [f["uv"] for f in h["features"] if f.get("case") == "A"]
        assert len(found) > 3
        assert np.mean([own[round(2 * v + 0.5), round(2 * u + 0.5)] for u, v in found]) > 0.6


def test_a_thousand_types_take_no_room_in_the_legend(photo):
    assert overlay(photo, None).shape[0] < 2 * HEIGHT + 120


def test_dots_are_on_one_canvas_and_the_page_stays_small(seen):
    assert seen.run(COUNT, ".mark") == 0
    assert seen.run(COUNT, "*") < 2000
    assert seen.run(INK) > 300
    assert complaints(seen) == []


def test_cases_count_what_a_feature_stands_for(seen, photo):
    counted = seen.run("return [...document.querySelectorAll('#cases dd')].map((d) => Number(d.textContent))")
    alone = [f for h in photo["hypotheses"] if h["status"] == "accepted" for f in h["features"] if f["in_image"]]
    assert sum(counted) == sum(f.get("stands_for", 1) for f in alone)


@pytest.mark.parametrize(("layer", "grows"), [("A", False), ("C", False), ("D", False), ("appearances", True)])
def test_a_case_can_be_switched(seen, layer, grows):
    before = seen.run(INK)
    seen.click(f"[data-layer='{layer}']")
    after = seen.run(INK)
    assert after > before * 2 if grows else after <= before
    seen.click(f"[data-layer='{layer}']")
    assert seen.run(INK) == before


def test_dots_tell_by_keyboard(seen):
    seen.run(PRESS, "ArrowLeft")
    seen.settle()
    assert "case A" in seen.run("return document.querySelector('#about').textContent")


def test_a_rejected_hypothesis_says_why_and_shows_its_outline(seen):
    point = "const b = document.querySelector('[data-alone=r9]').parentElement; b.dispatchEvent(new PointerEvent(arguments[0])); return b.textContent"
    told = seen.run(point, "pointerenter")
    assert "Log-likelihood ratio 3.1: luck." in told
    assert "found" in told
    assert seen.run(COUNT, "#hint .outline") == 1
    seen.run(point, "pointerleave")
    assert seen.run(COUNT, "#hint .outline") == 0
