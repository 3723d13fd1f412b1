"""The 3D view keeps what is shown on its canvas: turned, resized, zoomed, and when something far off is shown."""

from __future__ import annotations

import copy

import pytest
from page_checks import COUNT, DATA, complaints, shown_as

from plogic.face.pages.one_file import page

BODY = """const c = document.querySelector('#stage canvas'), d = document.createElement('canvas'); d.width = c.width; d.height = c.height;
const x = d.getContext('2d'); x.drawImage(c, 0, 0);
const p = x.getImageData(0, 0, d.width, d.height).data, box = [1e9, 1e9, -1, -1]; let n = 0;
for (let v = 0; v < d.height; v++) for (let u = 0; u < d.width; u++) {
  const i = 4 * (v * d.width + u), low = Math.min(p[i], p[i + 1], p[i + 2]), high = Math.max(p[i], p[i + 1], p[i + 2]);
  if (p[i + 3] < 255 || high - low < 20) continue;
  n += 1; box[0] = Math.min(box[0], u); box[1] = Math.min(box[1], v); box[2] = Math.max(box[2], u); box[3] = Math.max(box[3], v); }
return [n, box[0], box[1], d.width - 1 - box[2], d.height - 1 - box[3]]"""
"""How many pixels have the colour of an object, and how far they stay from each side of the canvas."""
FOCUS = "document.querySelector('#stage canvas').focus()"
LEFT, UP, HOME = "\ue012", "\ue013", "\ue011"


def far_off(towers, metres):
    """The towers, and a rejected one to the side, that far from where the others are."""
    document = copy.deepcopy(towers)
    document["hypotheses"][3]["T_camera_object"][0][3] += metres
    return document


def bare(browser):
    """Only the objects: no line of sight, no feature, no image."""
    for name in ("lines", "features", "picture"):
        browser.click(f"[data-layer={name}]")
    return browser


def whole(browser, least=200):
    """The objects are drawn, and none of them is cut by the canvas' side."""
    browser.settle()
    drawn, *margins = browser.run(BODY)
    assert drawn > least
    assert min(margins) > 0


@pytest.fixture(params=[(1280, 900), (360, 780)], ids=["desktop", "phone"])
def size(request):
    return request.param


@pytest.mark.parametrize("dark", [False, True])
def test_whatever_way_it_is_turned_all_is_in_view(chromium, towers, tmp_path, size, dark):
    chromium.dark(on=dark)
    browser = bare(shown_as(chromium, tmp_path, page(towers), *size))
    browser.run(FOCUS)
    for _ in range(5):
        whole(browser)
        browser.keys(LEFT * 4 + UP * 2)
    whole(browser)
    assert complaints(browser) == []
    chromium.dark(on=False)


def test_a_rejected_one_that_lies_outside_is_brought_into_view_and_the_others_again(chromium, towers, tmp_path, size):
    browser = bare(shown_as(chromium, tmp_path, page(far_off(towers, 9.0)), *size))
    before = browser.run(DATA)["distance"]
    browser.click("[data-alone=h4]")
    assert float(browser.run(DATA)["distance"]) > 1.5 * float(before)
    whole(browser, 60)
    browser.click("[data-world='0']")
    assert browser.run(DATA)["distance"] == before
    whole(browser)


def test_what_is_in_view_does_not_move_it(chromium, towers, tmp_path):
    browser = shown_as(chromium, tmp_path, page(towers))
    before = browser.run(DATA)["distance"]
    for world in ("1", "2", "0"):
        browser.click(f"[data-world='{world}']")
        assert browser.run(DATA)["distance"] == before
    browser.click("[data-alone=h4]")
    assert browser.run(DATA)["distance"] == before


def test_zooming_leads_to_the_objects_and_another_world_ends_it_where_it_must(chromium, towers, tmp_path):
    browser = bare(shown_as(chromium, tmp_path, page(far_off(towers, 9.0))))
    drawn = browser.run(BODY)[0]
    browser.run(FOCUS)
    browser.keys("+" * 9)
    zoomed = browser.run(BODY)[0]
    assert zoomed > 3 * drawn
    distance = float(browser.run(DATA)["distance"])
    browser.click("[data-alone=h4]")
    assert float(browser.run(DATA)["distance"]) > 3 * distance
    whole(browser, 60)
    browser.click("[data-world='0']")
    browser.run(FOCUS)
    browser.keys("-" * 30)
    assert 0 < browser.run(BODY)[0] < drawn
    browser.keys(HOME)
    whole(browser)


def test_another_shape_of_the_window_is_fitted(chromium, towers, tmp_path):
    browser = bare(shown_as(chromium, tmp_path, page(towers)))
    for width, height in ((360, 700), (900, 700), (1600, 500), (1280, 900)):
        browser.command(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False
        )
        whole(browser)


def test_close_shows_the_objects_large_and_whole(chromium, towers, tmp_path, size):
    browser = bare(shown_as(chromium, tmp_path, page(towers), *size))
    drawn = browser.run(BODY)[0]
    browser.click("[data-view=close]")
    whole(browser, 2 * drawn)


def test_a_body_without_a_mesh_is_seen_by_its_features(chromium, towers, tmp_path):
    document = towers | {
        "assets": {},
        "types": {"t1": {"features": [["a", "corner", 0, 0, 0], ["b", "corner", 1, 0, 0]]}},
    }
    document["hypotheses"] = [h | {"features": []} if h["id"] == "h4" else h for h in towers["hypotheses"]]
    browser = shown_as(chromium, tmp_path, page(document))
    assert browser.run(COUNT, "[data-layer=picture]") == 0, "it has no image"
    browser.click("[data-layer=lines]")
    browser.click("[data-alone=h4]")
    whole(browser, 10)
    assert complaints(browser) == []


def test_without_webgl_it_is_fitted_too(flat_chromium, towers, tmp_path):
    browser = bare(shown_as(flat_chromium, tmp_path, page(far_off(towers, 9.0)), 360, 780))
    whole(browser)
    browser.click("[data-alone=h4]")
    whole(browser, 60)
