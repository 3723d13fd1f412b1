"""The page of an object type in a real browser.

Its policy refuses nothing, and it shows what the knowledge base says.
"""

from __future__ import annotations

import numpy as np
import pytest
from made_types import HOSTILE, bare, hostile
from page_checks import COLOURS, COUNT, DATA, complaints, contrast, shown_as

from kb.clouds.lobes import feature_in_lobe, in_lobe
from plogic.face.pages.type_content import type_page

BOX = """const c = document.querySelector('#stage canvas'); c.scrollIntoView({block: 'center'});
const r = c.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]"""
POINT = """const [clientX, clientY] = arguments;
document.querySelector('#stage canvas').dispatchEvent(new PointerEvent('pointermove', {clientX, clientY}));
return document.querySelector('#about').innerText"""
MAP = """const c = document.querySelector('#map canvas'); c.scrollIntoView({block: 'center'});
const r = c.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]"""
LAST = "return [...document.querySelectorAll('#about tbody td:last-child')].map((c) => c.textContent)"
TEXT = "return document.querySelector(arguments[0]).innerText"
LEFT, RIGHT, ESCAPE = "\ue012", "\ue014", "\ue00c"


def opened(browser, folder, kb, kind, *size):
    shown_as(browser, folder, type_page(kb, kind), *size).settle()
    return browser


@pytest.fixture
def tower(chromium, tower_kb, tmp_path):
    return opened(chromium, tmp_path, tower_kb, tower_kb.type("t2"))


@pytest.fixture
def carton(chromium, learned_kb, tmp_path):
    return opened(chromium, tmp_path, learned_kb, learned_kb.types[0])


def viewpoint(browser, kind):
    data = browser.run(DATA)
    yaw, pitch, distance = (float(data[k]) for k in ("yaw", "pitch", "distance"))
    towards = np.array([np.cos(pitch) * np.sin(yaw), -np.cos(pitch) * np.cos(yaw), np.sin(pitch)])
    return kind.surface.centre + distance * towards


def focus(browser):
    browser.run("document.querySelector('#stage canvas').focus()")


def test_no_error_and_no_violation(tower):
    assert complaints(tower) == []
    assert tower.run("return document.querySelector('h1').textContent") == "t2"
    assert tower.run("return [...document.querySelectorAll('h2')].map((h) => h.textContent)") == [
        "In space", "The feature", "Parts and features", "How it stands", "What to know about this page",
    ]  # fmt: skip
    assert tower.run(DATA)["painter"] == "webgl"


def test_it_is_drawn_standing_on_each_of_its_faces(tower):
    pictures = tower.run("return [...document.querySelectorAll('#stands img')].map((i) => [i.alt, i.naturalWidth])")
    assert [width for _, width in pictures] == [240] * 5
    assert pictures[0][0] == "0.5: 0, 0, -1 below"
    assert tower.run("return document.getElementById('standing-key').textContent").startswith("On 5 faces, as its mesh")


@pytest.mark.parametrize("name", ["tower", "carton"])
def test_seen_from_here_are_those_whose_lobes_hold_the_viewpoint(request, name, tower_kb, learned_kb):
    browser = request.getfixturevalue(name)
    kind = tower_kb.type("t2") if name == "tower" else learned_kb.types[0]
    focus(browser)
    counts = []
    for step in range(6):
        browser.keys(RIGHT * 3 + "\ue015" * (step % 2))
        if step == 3:
            browser.run("const s = document.querySelector('#far'); s.value = 700; s.dispatchEvent(new Event('input'))")
            browser.settle()
        expected = int(feature_in_lobe(kind.lobes, [viewpoint(browser, kind)], 1.0).sum())
        assert f"{expected} of {len(kind.features)}" in browser.run(TEXT, "#here")
        counts.append(expected)
    assert len(set(counts)) > 2


def test_only_what_is_seen_is_lit_and_dragging_changes_it(carton):
    before = carton.run(COLOURS)
    carton.click("[data-layer=here]")
    assert carton.run(COLOURS)[2] != before[2]
    x, y, wide, high = carton.run(BOX)
    seen, yaw = carton.run(DATA)["seen"], float(carton.run(DATA)["yaw"])
    carton.drag((x + wide / 2, y + high - 8), (x + wide / 2 + 90, y + high - 8))
    assert float(carton.run(DATA)["yaw"]) == pytest.approx(yaw - 0.72, abs=0.05)
    assert carton.run(DATA)["seen"] != seen
    assert complaints(carton) == []


def test_keys_turn_zoom_and_reset(tower):
    start = tower.run(DATA)
    focus(tower)
    tower.keys(LEFT)
    assert float(tower.run(DATA)["yaw"]) == pytest.approx(float(start["yaw"]) - 0.12, abs=1e-4)
    tower.keys("+")
    assert float(tower.run(DATA)["zoom"]) > 1
    tower.keys("\ue011")
    assert tower.run(DATA) == start


def test_pointing_at_a_feature_shows_it_and_a_click_keeps_it(tower):
    tower.run("[...document.querySelectorAll('#stage-bar button')].find((b) => b.textContent === 'Front').click()")
    tower.settle()
    x, y, wide, high = tower.run(BOX)
    plain = tower.run(COLOURS)
    heights = [h for h in range(0, int(high), 6) if "roof/apex" in tower.run(POINT, x + wide / 2, y + h)]
    assert 1 <= len(heights) <= 5
    assert heights[0] < high / 3
    spot = (x + wide / 2, y + heights[len(heights) // 2])
    tower.drag(spot, spot)
    assert "roof/apex" in tower.run(TEXT, "#about")
    assert tower.run(COLOURS)[2] != plain[2], "its lobes are drawn"
    tower.drag((x + 5, y + 5), (x + 5, y + 5))
    assert "roof/apex" not in tower.run(TEXT, "#about")


def test_a_feature_tells_what_it_is_and_its_lobes_stand_alone(carton, learned_kb):
    kind = learned_kb.types[0]
    focus(carton)
    carton.keys("n")
    name = carton.run(TEXT, ".about-name")
    index = [f.name for f in kind.features].index(name)
    rows = np.flatnonzero(kind.lobes.feature == index)
    text = carton.run(TEXT, "#about")
    assert f"{kind.features[index].type.replace('_', ' ')}, dv " in text
    assert "along one axis" in text
    assert carton.run(COUNT, "#about tbody tr") == len(rows)
    assert [f"{kind.learned.hit[row]:.2f}" in text for row in rows] == [True] * len(rows)
    held = in_lobe(kind.lobes, [viewpoint(carton, kind)], 1.0)[0, rows]
    assert carton.run(LAST) == ["yes" if h else "no" for h in held]
    all_lobes = carton.run(COLOURS)
    carton.click("#about tbody button")
    assert carton.run("return document.activeElement.getAttribute('aria-pressed')") == "true"
    if len(rows) > 1:
        assert carton.run(COLOURS)[2] != all_lobes[2]
    focus(carton)
    carton.keys(ESCAPE)
    assert carton.run(COUNT, "#about tbody tr") == 0


def test_buttons_walk_through_the_features(tower):
    names = []
    for _ in range(3):
        tower.click("[data-walk='1']")
        names.append(tower.run(TEXT, ".about-name"))
    tower.click("[data-walk='-1']")
    assert len(set(names)) == 3
    assert tower.run(TEXT, ".about-name") == names[1]


def test_the_tree_counts_and_lights_what_is_chosen(tower, tower_kb):
    rows = tower.run(
        "return [...document.querySelectorAll('#tree button')].map((b) => [...b.children].map((c) => c.textContent))"
    )
    assert [row[:2] for row in rows] == [
        ["t2", "54"],
        ["body", "49"],
        ["corner", "8"],
        ["patch", "41"],
        ["roof", "5"],
        ["apex", "1"],
        ["patch", "4"],
    ]
    assert [row[2] for row in rows if row[0] == "apex"] == ["dv 0.991"]
    before = tower.run(COLOURS)
    tower.run("[...document.querySelectorAll('#tree button')][4].click()")
    tower.settle()
    assert tower.run(COUNT, "#tree [aria-pressed=true]") == 1
    assert "of the chosen ones" in tower.run(TEXT, "#here")
    assert " of 5" in tower.run(TEXT, "#here")
    assert tower.run(COLOURS)[2] != before[2]
    tower.click("[data-walk='1']")
    assert tower.run(TEXT, ".about-name").startswith("roof/")


def test_the_surface_can_be_taken_away(carton):
    whole = carton.run(COLOURS)
    carton.click("[data-layer=surface]")
    assert carton.run(COLOURS)[0] < whole[0] / 2
    carton.click("[data-layer=surface]")
    assert carton.run(COLOURS) == whole


def test_the_map_turns_the_eye(tower):
    x, y, wide, high = tower.run(MAP)
    spot = (round(x + 0.75 * wide), round(y + 0.25 * high))
    tower.drag(spot, spot)
    assert float(tower.run(DATA)["yaw"]) == pytest.approx(np.pi / 2, abs=0.03)
    assert float(tower.run(DATA)["pitch"]) == pytest.approx(np.pi / 4, abs=0.03)


def test_hostile_names_are_words(chromium, tower_kb, tmp_path):
    browser = opened(chromium, tmp_path, *hostile(tower_kb))
    browser.click("[data-walk='1']")
    assert complaints(browser) == []
    assert browser.run("return document.title").startswith(HOSTILE)
    assert browser.run(COUNT, "img:not(#stands img), iframe, object, embed") == 0
    assert HOSTILE in browser.run(TEXT, "h1")
    assert HOSTILE in browser.run(TEXT, "#tree")
    assert HOSTILE.replace("_", " ") in browser.run(TEXT, "#about")


def test_a_type_of_nothing_is_a_page(chromium, tower_kb, tmp_path):
    browser = opened(chromium, tmp_path, *bare(tower_kb))
    assert complaints(browser) == []
    assert "0 of 0" in browser.run(TEXT, "#here")
    browser.click("[data-walk='1']")
    assert complaints(browser) == []


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("make", [lambda kb: (kb, kb.types[0]), hostile])
def test_nothing_sticks_out_sideways(chromium, tower_kb, tmp_path, width, make):
    browser = opened(chromium, tmp_path, *make(tower_kb), width, 844)
    browser.click("[data-walk='1']")
    assert browser.run("return document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("dark", [False, True])
def test_words_stand_out_from_their_ground(tower, dark):
    tower.click("[data-walk='1']")
    texts, least = contrast(tower, dark=dark)
    assert texts > 60
    assert least >= 4.5


def test_without_webgl_a_plain_canvas_draws_and_turns(flat_chromium, learned_kb, tmp_path):
    browser = opened(flat_chromium, tmp_path, learned_kb, learned_kb.types[0])
    assert browser.run(DATA)["painter"] == "canvas"
    drawn, colours, before = browser.run(COLOURS)
    assert drawn > 5000
    assert colours > 20
    focus(browser)
    browser.keys("n" + RIGHT)
    assert browser.run(COLOURS)[2] != before
