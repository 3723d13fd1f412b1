"""The plane that things stand on, on the page: its grid, feet and numbers, in the worlds that have it."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from page_checks import COLOURS, COUNT, DATA, complaints, element, shown_as

from plogic.face.pages.one_file import page
from plogic.face.shown.ground import ground_of

HOSTILE = "</script><img src=x onerror=document.title='pwned'>"
WORDS = "return document.querySelector(arguments[0]).innerText.replace(/\\s+/g, ' ')"


@pytest.fixture(scope="module")
def stood(towers):
    """The towers on the floor of their world.

    In the second world nothing says where things stand, in the third h3 is free, in the fourth h2 is on h1.
    """
    document = copy.deepcopy(towers)
    *up, height = document["camera"]["T_world_camera"][2]
    document["support_planes"] = [
        _plane("s1", [0.0, -1.0, 0.0], -2.0, 0.02, {"h1": 0.02}),
        _plane("s2", up, -height, 0.93, {"h1": 0.92, "h2": 0.9}),
    ]
    places = {h["id"]: np.array(h["T_camera_object"])[:3, 3] for h in document["hypotheses"]}
    document["space"] = {"bodies": [{"id": h, "middle": (at + up).tolist()} for h, at in places.items()]}
    ways = {"h1": {"s1": [0.02], "s2": [0.9, 0.02]}, "h2": {"s2": [0.9], "h1": [0.06]}, "h3": {}}
    for h in document["hypotheses"][:3]:
        h["stances"] = [{"on": on, "face": 0, "probability": p} for on, ps in ways[h["id"]].items() for p in ps]
        h["free"] = {"h1": 0.05, "h2": 0.0001, "h3": 0.008}[h["id"]]
    first, second, third = document["worlds"]
    first |= {"support": "s2", "stances": {"h1": "s2/0", "h2": "s2/0"}}
    second |= {"support": "none", "stances": {"h1": "free"}}
    third |= {"support": "s2", "stances": {"h1": "s2/1", "h3": "free"}}
    document["worlds"].append(first | {"probability": 0.0006, "stances": {"h1": "s2/0", "h2": "h1/0"}})
    return document


def _plane(name, normal, offset, probability, standing):
    plane = {"normal": normal, "offset": offset}
    return {"name": name, "plane": plane, "probability": probability, "standing": standing}


@pytest.fixture
def shown(chromium, stood, tmp_path):
    return shown_as(chromium, tmp_path, page(stood))


def told(text):
    return json.loads(element(text, "script", ' type="application/json" id="ground"'))


def pixels(browser):
    browser.settle()
    return browser.run(COLOURS)


def test_the_page_has_the_grid_and_the_feet_of_the_picture(stood):
    ground, block = ground_of(stood), told(page(stood))
    assert (block["name"], block["step"]) == ("s2", ground.step)
    np.testing.assert_allclose(block["lines"], ground.lines[:, [0, -1]], atol=5e-5)
    assert set(block["feet"]) == {"h1", "h2"}
    assert len(block["drawn"]) == len(block["lines"])
    assert {len(line) for line in block["drawn"]} == {4}, "no lens bends them"


def test_where_no_plane_is_likely_there_is_none(chromium, towers, stood, tmp_path):
    assert told(page(towers)) is None
    unlikely = copy.deepcopy(stood)
    unlikely["support_planes"][1]["probability"] = 0.4
    assert told(page(unlikely)) is None
    browser = shown_as(chromium, tmp_path, page(unlikely))
    assert browser.run(COUNT, ".ground, .feet, [data-layer=ground], [data-layer=plane]") == 0
    assert "Plane s2" in browser.run(WORDS, "#standing"), "its numbers are told"
    assert complaints(browser) == []


def test_the_layer_goes_and_comes_back(shown):
    assert [shown.run(COUNT, s) for s in (".ground", ".feet > g", "#bare path")] == [1, 2, 2]
    assert "plane s2 that things stand on" in shown.run(WORDS, "#signs-key")
    shown.click("[data-layer=ground]")
    assert shown.run(COUNT, ".ground, .feet") == 0
    assert "plane s2" not in shown.run(WORDS, "#signs-key")
    shown.click("[data-layer=ground]")
    assert shown.run(COUNT, ".ground, .feet") == 2
    assert complaints(shown) == []


def test_grid_and_feet_are_those_of_the_shown_world(shown):
    shown.click("[data-world='1']")
    assert shown.run(COUNT, ".ground, .feet") == 0, "nothing says where things stand"
    shown.settle()
    assert "floor, a square is" in shown.run(WORDS, "#stage-key")
    shown.click("[data-world='2']")
    assert [shown.run(COUNT, s) for s in (".ground", ".feet > g")] == [1, 1], "h3 is free"
    shown.click("[data-world='3']")
    assert [shown.run(COUNT, s) for s in (".ground", ".feet > g")] == [1, 1], "h2 is on h1"
    shown.settle()
    assert "plane s2 that things stand on" in shown.run(WORDS, "#stage-key")
    shown.click("[data-alone=h4]")
    shown.settle()
    assert "plane s2 that things stand on" in shown.run(WORDS, "#stage-key")
    assert "foot" not in shown.run(WORDS, "#stage-key"), "a rejected one stands nowhere"


def test_in_space_each_foot_is_drawn_on_the_plane(chromium, stood, tmp_path):
    afloat, free = copy.deepcopy(stood), copy.deepcopy(stood)
    for document in (afloat, free):
        document["support_planes"][1]["plane"]["offset"] -= 0.5
    free["worlds"][0]["stances"] = {"h1": "free", "h2": "free"}
    (_, _, feet), (_, _, none) = (pixels(browser) for browser in _each(chromium, tmp_path, afloat, free))
    assert feet != none


@pytest.mark.parametrize("kind", ["chromium", "flat_chromium"])
def test_the_view_in_space_has_it_with_a_switch(request, stood, tmp_path, kind):
    browser = shown_as(request.getfixturevalue(kind), tmp_path, page(stood))
    with_it = pixels(browser)
    assert "plane s2" in browser.run(WORDS, "#stage-key")
    assert "foot of what stands there" in browser.run(WORDS, "#stage-key")
    browser.click("[data-layer=plane]")
    without = pixels(browser)
    assert without[2] != with_it[2]
    assert "plane s2" not in browser.run(WORDS, "#stage-key")
    browser.click("[data-layer=plane]")
    assert pixels(browser) == with_it
    assert complaints(browser) == []


def test_the_plane_tells_which_way_is_up(chromium, stood, tmp_path):
    unknown = copy.deepcopy(stood)
    del unknown["camera"]["T_world_camera"]
    seen = [
        (browser.run(DATA)["distance"], pixels(browser)[0]) for browser in _each(chromium, tmp_path, stood, unknown)
    ]
    assert float(seen[0][0]) == pytest.approx(float(seen[1][0]), rel=1e-4)
    assert seen[0][1] == pytest.approx(seen[1][1], rel=1e-3)


def _each(browser, folder, *documents):
    for document in documents:
        yield shown_as(browser, folder, page(document))


def test_the_numbers_say_who_stands_on_what(shown):
    up = np.array(
        json.loads(shown.run("return document.getElementById('data').textContent"))["support_planes"][1]["plane"][
            "normal"
        ]
    )
    said = shown.run(WORDS, "#standing")
    angle = round(float(np.degrees(np.arcsin(abs(up[2])))))
    assert said.startswith("What they stand on Plane s2 ")
    assert (
        f"m below the camera, at {angle}° to its line of sight 0.930 wedge tower h1 0.920 pyramid tower h2 0.900"
        in said
    )
    assert "Plane s1 2.00 m below the camera, at 0° to its line of sight 0.020 wedge tower h1 0.020" in said
    assert "Another plane, or none 0.050 On wedge tower h1 pyramid tower h2 0.060" in said
    assert said.endswith("Free: on nothing known wedge tower h1 0.050 pyramid tower h3 0.008")


def test_hostile_names_are_words(chromium, stood, tmp_path):
    evil = copy.deepcopy(stood)
    for row in evil["support_planes"]:
        row["name"] += HOSTILE
    browser = shown_as(chromium, tmp_path, page(evil))
    assert complaints(browser) == []
    assert browser.run(COUNT, "img") == 0
    assert HOSTILE in browser.run(WORDS, "#standing")
