"""What a reader meets on the page: edges that are hidden, a key, one hypothesis alone, marks on demand, a phone.

And what is printed.
"""

from __future__ import annotations

import base64
import copy
import re

import pytest
from page_checks import COUNT, complaints, contrast, shown_as

from plogic.face.pages.one_file import page

KEY = "return [...document.querySelectorAll('#signs-key li')].map((e) => e.textContent.trim())"
CASES = "return [...document.querySelectorAll('#cases dd')].map((d) => Number(d.textContent))"
TEXT = "return document.querySelector(arguments[0]).textContent"
DASHES = """return [...document.querySelectorAll('#picture .unseen, #picture .outline')].map((g) =>
  [g.getAttribute('class'), [...g.querySelectorAll('path')].every((p) => p.hasAttribute('stroke-dasharray'))])"""
LONG = "a_type_whose_name_is_a_good_deal_longer_than_a_phone_is_wide_and_has_no_space"
SIDEWAYS = "return document.documentElement.scrollWidth"
SIZES = [(1280, 900), (360, 780)]


def without_features(towers):
    """As the cycle writes it: of a rejected hypothesis of a type by hand no feature is kept."""
    document = copy.deepcopy(towers)
    document["hypotheses"][3]["features"] = []
    return document


def busy(towers, more=200):
    document = copy.deepcopy(towers)
    first = document["appearances"][0]
    document["appearances"] += [first | {"id": f"x{i}", "uv": [3.0 * (i % 200), 7.0 + i // 200]} for i in range(more)]
    return document


@pytest.fixture
def shown(chromium, towers, tmp_path):
    return shown_as(chromium, tmp_path, page(towers))


def test_hidden_edges_are_dashed_and_seen_ones_are_not(shown):
    assert shown.run(DASHES) == [["unseen", True], ["unseen", True], ["outline", False], ["outline", False]]
    shown.click("[data-alone=h3]")
    assert shown.run(DASHES) == [["unseen", True], ["outline", False]]


def test_what_hides_an_edge_is_of_the_shown_world(shown):
    lengths = """const paths = document.querySelectorAll('#picture :is(.unseen, .outline) path:nth-child(even)');
      return [...paths].reduce((sums, p) => {
      const k = p.parentNode.getAttribute('class'); sums[k] = (sums[k] || 0) + p.getTotalLength(); return sums; }, {})"""
    shown.click("[data-world='2']")  # h1 and h3
    beside = shown.run(lengths)
    shown.click("[data-world='1']")  # h1
    front = shown.run(lengths)
    shown.click("[data-alone=h3]")
    alone = shown.run(lengths)
    assert beside["unseen"] > front["unseen"] + alone["unseen"] + 50
    assert sum(beside.values()) == pytest.approx(sum(front.values()) + sum(alone.values()), rel=0.02)


def test_every_appearance_type_has_a_sign_of_its_own_in_the_key(chromium, towers, tmp_path):
    """By its strokes or its colour, of unknown types too."""
    document = copy.deepcopy(towers)
    first = document["appearances"][0]
    document["appearances"] += [first | {"id": f"x{i}", "type": f"odd_{i}"} for i in range(12)]
    seen = shown_as(chromium, tmp_path, page(document))
    path = "[...e.querySelectorAll('path')].map((p) => p.getAttribute('d') + p.getAttribute('stroke')).join()"
    signs = seen.run(f"return [...document.querySelectorAll('#signs-key li')].map((e) => {path})")[-12 - 3 :]
    assert len(signs) == 15
    assert all(signs)
    assert len(set(signs)) == 15


def test_the_key_names_what_the_picture_has_and_nothing_else(shown, towers):
    signs = sorted({a["type"].replace("_", " ") for a in towers["appearances"]})
    lines = ["edge", "edge hidden behind another object, or by its own", "not accepted, pointed at in the list"]
    assert shown.run(KEY) == ["wedge tower h1", "pyramid tower h2", *lines, "chosen mark", *signs]
    for layer in ("unseen", "appearances"):
        shown.click(f"[data-layer={layer}]")
    assert shown.run(KEY) == ["wedge tower h1", "pyramid tower h2", lines[0], lines[2], "chosen mark"]
    shown.click("[data-world='1']")
    assert shown.run(KEY)[0] == "wedge tower h1"
    assert "pyramid tower h2" not in shown.run(KEY)


def test_the_key_in_space_says_how_long_a_square_of_the_floor_is(shown):
    told = shown.run(TEXT, "#stage-key")
    assert re.search(r"floor, a square is (\d+ m|\d+ cm)$", told)
    assert "line of sight to what is found" in told
    shown.click("[data-layer=lines]")
    assert "line of sight" not in shown.run(TEXT, "#stage-key")


@pytest.mark.parametrize("size", SIZES)
def test_a_rejected_one_alone_shows_its_counts_and_itself(chromium, towers, tmp_path, size):
    browser = shown_as(chromium, tmp_path, page(without_features(towers)), *size)
    support = towers["hypotheses"][3]["support"].values()
    wanted = [
        sum(row[k] for row in support)
        for k in ("expected_detected", "hidden_missed", "expected_missed", "hidden_detected")
    ]
    assert wanted[2] > 0
    browser.click("[data-alone=h4]")
    assert browser.run(CASES) == wanted
    assert browser.run(COUNT, "#picture .outline") == 1
    assert browser.run(COUNT, "#picture .unseen") == 1
    assert browser.run(TEXT, "#names") == "wedge tower h4"
    assert "Only wedge tower (h4) is shown, as it was tried. It is in no world." in browser.run(TEXT, "#about")
    assert browser.run("return document.querySelector('[data-alone=h4]').getAttribute('aria-pressed')") == "true"
    browser.click("[data-back]")
    assert browser.run(COUNT, "#picture .outline") == 2
    assert browser.run("return document.activeElement.dataset.world") == "0"
    assert browser.run(COUNT, "[data-alone][aria-pressed=true]") == 0
    assert complaints(browser) == []


def test_alone_is_a_switch(shown):
    shown.click("[data-world='1']")
    shown.click("[data-alone=h4]")
    shown.click("[data-alone=h3]")
    assert shown.run(TEXT, "#names") == "pyramid tower h3"
    shown.click("[data-alone=h3]")
    assert shown.run("return document.querySelector('[data-world=\"1\"]').getAttribute('aria-pressed')") == "true"


def test_pointing_at_what_is_shown_does_not_draw_it_twice(shown):
    enter = "document.querySelector('[data-alone=h4]').parentElement.dispatchEvent(new PointerEvent('pointerenter'))"
    shown.run(enter)
    assert shown.run(COUNT, "#hint .outline") == 1
    shown.click("[data-alone=h4]")
    shown.run(enter)
    assert shown.run(COUNT, "#hint *") == 0
    assert shown.run(COUNT, "#names text") == 1


@pytest.mark.parametrize("size", SIZES)
def test_of_hundreds_of_marks_the_object_is_seen_first(chromium, towers, tmp_path, size):
    document = busy(towers)
    browser = shown_as(chromium, tmp_path, page(document), *size)
    marks = len(document["appearances"]) + sum(len(h["features"]) for h in document["hypotheses"][:2])
    assert browser.run(COUNT, ".mark") == 0
    assert browser.run(COUNT, "#picture .outline") == 2
    assert browser.run(TEXT, "#about") == (
        f"{marks} marks are left out, so that the objects are seen. \u201cMarks\u201d draws them."
    )
    assert browser.run("return document.querySelector('[data-layer=appearances]').offsetParent") is None
    browser.click("[data-layer=marks]")
    assert browser.run(COUNT, ".mark") == marks
    assert "Point at a mark" in browser.run(TEXT, "#about")
    assert browser.run("return document.querySelector('[data-layer=appearances]').offsetParent") is not None
    browser.click("[data-layer=marks]")
    assert browser.run(COUNT, ".mark") == 0
    assert complaints(browser) == []


def test_few_marks_are_drawn_at_once(shown):
    assert shown.run(COUNT, "[data-layer=marks]") == 0
    assert shown.run(COUNT, ".mark") > 50


def test_many_names_at_one_place_do_not_hang_the_page(chromium, towers, tmp_path):
    document = copy.deepcopy(towers)
    first = document["hypotheses"][0] | {"features": [], "outline": [[[10.0, 2.0], [60.0, 2.0], [60.0, 9.0]]]}
    document["hypotheses"] += [first | {"id": f"n{i}"} for i in range(30)]
    document["worlds"][0] = document["worlds"][0] | {"present": [f"n{i}" for i in range(30)]}
    browser = shown_as(chromium, tmp_path, page(document))
    assert browser.run(COUNT, "#names text") == 30
    places = browser.run("return [...document.querySelectorAll('#names text')].map((t) => t.getAttribute('transform'))")
    assert len(set(places)) == 30


@pytest.mark.parametrize("dark", [False, True])
def test_on_a_phone_the_table_scrolls_and_the_page_does_not(chromium, towers, tmp_path, dark):
    document = copy.deepcopy(towers)
    for h in document["hypotheses"]:
        h["label"] = LONG
        h["support"][LONG] = h["support"].pop("patch")
    for step in document["trace"]:
        step["why"] = step["type"] = LONG
    chromium.dark(on=dark)
    browser = shown_as(chromium, tmp_path, page(document), 360, 780)
    assert browser.run(SIDEWAYS) == 360
    inner, outer = browser.run(
        "const s = document.querySelector('#support .scroll'); return [s.scrollWidth, s.clientWidth]"
    )
    assert inner > outer + 100
    assert outer <= 360
    x, y = browser.run(
        "const s = document.querySelector('#support .scroll'); s.scrollIntoView({block: 'center'}); "
        "const r = s.getBoundingClientRect(); return [r.left + 280, r.top + r.height / 2]"
    )
    for _ in range(4):
        browser.swipe((x, y), -250)
    last, first = browser.run(
        """const box = (e) => e.getBoundingClientRect(), s = box(document.querySelector('#support .scroll'));
        const h = [...document.querySelectorAll('#support thead th')].map(box);
        return [s.right - h[h.length - 1].right, h[0].left - s.left]"""
    )
    assert last == pytest.approx(0, abs=1)
    assert first == pytest.approx(0, abs=1)  # whose row it is stays in view
    assert browser.run(SIDEWAYS) == 360
    assert browser.run("return scrollX") == 0
    chromium.dark(on=False)


@pytest.mark.parametrize("dark", [False, True])
def test_words_stand_out_also_alone_and_busy(chromium, towers, tmp_path, dark):
    browser = shown_as(chromium, tmp_path, page(busy(towers)), 360, 780)
    browser.click("[data-alone=h4]")
    texts, least = contrast(browser, dark=dark)
    assert texts > 80
    assert least >= 4.5


def test_everything_that_takes_keys_has_a_name_and_is_reached_by_tab(shown):
    nameless = """return [...document.querySelectorAll('button, input, [tabindex="0"], canvas, [role=application]')].filter((e) =>
      e.offsetParent !== null && !(e.getAttribute('aria-label') || e.textContent.trim() || (e.closest('label') || {}).textContent)).length"""
    assert shown.run(nameless) == 0
    reached = set()
    for _ in range(60):
        shown.keys("\ue004")
        reached.add(
            shown.run(
                "const e = document.activeElement; return e.dataset.layer || e.dataset.alone || e.dataset.view || e.dataset.world || e.tagName"
            )
        )
    assert {"unseen", "h4", "close", "1", "CANVAS", "g"} <= reached


def test_it_prints_on_white_without_switches(chromium, towers, tmp_path):
    chromium.dark(on=True)
    browser = shown_as(chromium, tmp_path, page(towers))
    pdf = base64.b64decode(browser.command("Page.printToPDF", printBackground=False)["data"])
    assert pdf.startswith(b"%PDF")
    browser.command("Emulation.setEmulatedMedia", media="print", features=[])
    browser.command("Emulation.setDeviceMetricsOverride", width=718, height=1000, deviceScaleFactor=1, mobile=False)
    colour, shown, wide = browser.run(
        "const switches = [...document.querySelectorAll('.bar, .why button, #stage-hint')]; "
        "return [getComputedStyle(document.body).color, switches.filter((e) => e.offsetParent).length, "
        "document.documentElement.scrollWidth]"
    )
    browser.command("Emulation.setEmulatedMedia", media="", features=[])
    assert shown == 0
    assert wide == 718  # as wide as A4 between its margins
    assert max(int(c) for c in re.findall(r"\d+", colour)) < 60
