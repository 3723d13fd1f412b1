"""A learned type on the page: its surface with its texture, in WebGL and without, and its marks on demand."""

from __future__ import annotations

import base64
import json

import cv2
import pytest
from console import good
from page_checks import DATA, complaints, shown_as
from painted_cube import CAMERA, CORNER, cloud, picture, pose_towards, seen, write_knowledge

from geometry.camera import camera_to_dict
from plogic.face.pages.one_file import page
from plogic.run.carried import MOST_TRIANGLES
from plogic.run.painted import LARGEST_PAINT

COLOURS = """const c = document.querySelector('#stage canvas'), t = document.createElement('canvas');
t.width = c.width; t.height = c.height; const g = t.getContext('2d'); g.drawImage(c, 0, 0);
const p = g.getImageData(0, 0, t.width, t.height).data, found = new Set();
for (let i = 0; i < p.length; i += 4) if (p[i + 3] === 255) found.add(p.slice(i, i + 3).map((x) => x >> 4).join());
return [...found].sort()"""
MARKS = "const c = document.querySelector('.dots'); return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((x) => x)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The interpretation of a picture of a learned cube, and its page, as the command writes them."""
    folder = tmp_path_factory.mktemp("texture")
    (folder / "kb").mkdir()
    write_knowledge(folder / "kb", {"cube": cloud(seen())})
    cv2.imwrite(str(folder / "seen.png"), picture([pose_towards(CORNER, 0.6)], seed=3))
    (folder / "camera.json").write_text(json.dumps(camera_to_dict(CAMERA)))
    given = "perceive", "seen.png", "--camera", "camera.json", "--kb", "kb", "-o", "seen.json"
    good(*given, "--report", "page.html", cwd=folder)
    return folder


def settled(browser, count):
    for _ in range(50):
        browser.settle()
        if browser.run("return document.querySelector('#stage canvas').dataset.painted") == count:
            return
    raise AssertionError(browser.run(DATA))


@pytest.mark.parametrize(("which", "painter"), [("chromium", "webgl"), ("flat_chromium", "canvas")])
def test_a_textured_surface_is_shown_with_its_texture(request, folder, tmp_path, which, painter):
    browser = shown_as(request.getfixturevalue(which), tmp_path, (folder / "page.html").read_text())
    assert browser.run(DATA)["painter"] == painter
    settled(browser, "1")
    painted = browser.run(COLOURS)
    browser.click("[data-layer='texture']")
    settled(browser, "0")
    plain = browser.run(COLOURS)
    assert len(set(painted) - set(plain)) > (100 if painter == "webgl" else 3)  # twelve triangles, a colour each
    browser.click("[data-layer='texture']")
    settled(browser, "1")
    assert complaints(browser) == []


@pytest.mark.parametrize("which", ["chromium", "flat_chromium"])
def test_colours_of_vertices_are_shown_too(request, folder, tmp_path, which):
    document = json.loads((folder / "seen.json").read_text())
    (paint,) = document["assets"]["paints"].values()
    del paint["uv"], paint["picture"]
    number = len(base64.b64decode(paint["vertices"])) // 12
    paint["colours"] = base64.b64encode(bytes([10, 200, 30] * number)).decode()
    browser = shown_as(request.getfixturevalue(which), tmp_path, page(document))
    settled(browser, "1")
    shades = [[16 * int(x) for x in row.split(",")] for row in browser.run(COLOURS)]
    assert any(g > 140 and r < 40 and b < 50 for r, g, b in shades)
    assert complaints(browser) == []


def test_marks_of_a_learned_type_are_drawn_on_demand(chromium, folder, tmp_path):
    browser = shown_as(chromium, tmp_path, (folder / "page.html").read_text())
    assert not browser.run(MARKS)
    browser.click("[data-layer='marks']")
    assert browser.run(MARKS)


def test_where_features_are_missed_is_hatched_and_can_be_switched_off(chromium, folder, tmp_path):
    document = json.loads((folder / "seen.json").read_text())
    (h,) = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    expected = [f for f in h["features"] if f["case"] in ("A", "C")]
    assert len(expected) > 20
    for f in expected:
        f["case"] = "A"
    assert count(shown_as(chromium, tmp_path, page(document))) == 0
    for f in expected:
        f["case"] = "C"
    browser = shown_as(chromium, tmp_path, page(document))
    assert count(browser) == 1
    assert "hatched" in browser.run("return document.querySelector('#signs-key').textContent")
    browser.click("[data-layer='missed']")
    assert count(browser) == 0
    assert complaints(browser) == []


def count(browser):
    return browser.run("return document.querySelectorAll('#picture .missed').length")


def test_what_is_carried_is_small_and_the_same_each_time(folder):
    text = (folder / "seen.json").read_text()
    (paint,) = json.loads(text)["assets"]["paints"].values()
    assert len(paint["picture"]["base64"]) <= 4 / 3 * LARGEST_PAINT + 4
    assert len(paint["triangles"]) <= MOST_TRIANGLES * 3 * 2 * 4 / 3 + 4
    good("report", "seen.json", "-o", "again.html", cwd=folder)
    assert (folder / "again.html").read_bytes() == (folder / "page.html").read_bytes()


def test_a_type_without_a_texture_has_no_switch(chromium, towers, tmp_path):
    browser = shown_as(chromium, tmp_path, page(towers))
    assert browser.run("return document.querySelector(\"[data-layer='texture']\")") is None
