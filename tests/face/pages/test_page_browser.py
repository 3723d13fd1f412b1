"""The page in a real browser: its policy refuses nothing, and everything that can be clicked does what it says."""

from __future__ import annotations

import copy
import re

import pytest
from page_checks import COLOURS, COUNT, DATA, complaints, contrast, shown_as
from towers_document import document

from plogic.face.pages.one_file import page

HOSTILE = "</script><img src=x onerror=document.title='pwned'>"
CENTRE = """const c = document.querySelector('#stage canvas'); c.scrollIntoView({block: 'center'});
const r = c.getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]"""


@pytest.fixture
def shown(chromium, towers, tmp_path):
    return shown_as(chromium, tmp_path, page(towers))


def yaw(browser):
    return float(browser.run(DATA)["yaw"])


def cases(browser):
    return browser.run("return [...document.querySelectorAll('#cases dd')].map((d) => Number(d.textContent))")


def test_no_error_and_no_violation(shown):
    assert complaints(shown) == []
    assert shown.run("return document.querySelector('h1').textContent") == "Wedge tower and pyramid tower"
    assert shown.run("return [...document.querySelectorAll('h2')].map((h) => h.textContent)") == [
        "The picture", "Possible worlds", "Hypotheses", "In space", "Measures", "How it came to this",
    ]  # fmt: skip


def test_a_violation_would_be_seen(chromium, towers, tmp_path):
    shown_as(chromium, tmp_path, page(towers).replace("</main>", "<script>window.ran = 1</script></main>"))
    assert any("Content Security Policy" in m for m in complaints(chromium))
    assert chromium.run("return window.ran === undefined")


def test_what_is_unfinished_says_so_at_its_head(chromium, towers, tmp_path):
    said = [
        shown_as(chromium, tmp_path, page(towers | more)).run("return document.body.innerText")
        for more in ({}, {"unfinished": True})
    ]
    assert ["Unfinished: more time may change all of this." in text for text in said] == [False, True]


def test_what_the_worlds_do_not_weigh_and_a_doubtful_camera_are_told_beside_them(chromium, towers, tmp_path):
    more = {"unweighed": {"h1": 2}, "camera_doubt": {"why": "the focal length is doubtful: it may be half"}}
    told = [
        shown_as(chromium, tmp_path, page({**towers, **some})).run(
            "return [...document.querySelectorAll('#worlds #cautions p')].map((p) => p.textContent)"
        )
        for some in ({}, more)
    ]
    assert told[0] == []
    rivals, camera = told[1]
    assert rivals.startswith("Wedge tower h1 has 2 more rivals, ")
    assert camera == "The focal length is doubtful: it may be half."


def test_every_feature_in_a_world_has_the_mark_of_its_case(shown, towers):
    wanted = [sum(f["case"] == c for h in towers["hypotheses"][:2] for f in h["features"]) for c in "ABCD"]
    assert cases(shown) == wanted
    assert [shown.run(COUNT, f"#picture .mark[data-case={c}]") for c in "ABCD"] == wanted
    assert shown.run(COUNT, "#circles circle:not(.halo)") == 2 * (wanted[0] + wanted[2])
    assert shown.run(COUNT, "#squares rect") == 2 * (wanted[1] + wanted[3])
    assert shown.run(COUNT, "#signs .mark") == len(towers["appearances"])


def test_choosing_a_world_changes_picture_causes_and_space(shown, towers):
    before, drawn = cases(shown), shown.run(COLOURS)
    shown.click("[data-world='1']")
    assert shown.run("return document.querySelector('[data-world=\"1\"]').getAttribute('aria-pressed')") == "true"
    assert shown.run("return document.activeElement.dataset.world") == "1"
    assert sum(cases(shown)) == len(towers["hypotheses"][0]["features"]) < sum(before)
    assert shown.run(COUNT, "#picture .outline") == 1
    noise = list(towers["worlds"][1]["causes"].values()).count("noise")
    assert f"{len(towers['appearances']) - noise} of" in shown.run(
        "return document.querySelector('#world').textContent"
    )
    assert shown.run(COLOURS)[0] < drawn[0]
    assert complaints(shown) == []


def test_without_its_occluder_a_hidden_feature_is_expected(shown, towers):
    hidden = [
        f
        for f in towers["hypotheses"][2]["features"]
        if f["in_lobe"] and not f["self_hidden"] and "h1" in f["hidden_by"]
    ]
    assert hidden
    shown.click("[data-alone=h3]")
    texts = shown.run(
        "return [...document.querySelectorAll('#circles .mark')].map((m) => m.getAttribute('aria-label'))"
    )
    told = [t for t in texts if any(t.startswith(f["id"] + " ") for f in hidden)]
    assert len(told) == len(hidden)
    assert any("would hide it, but is not in this world" in t for t in told)


LAYERS = {
    "appearances": "#signs .mark",
    "expected": "#circles .mark",
    "hidden": "#squares .mark",
    "outlines": ".outline",
    "unseen": ".unseen",
    "labels": ".name",
}


@pytest.mark.parametrize(("layer", "selector"), LAYERS.items())
def test_a_layer_goes_and_comes_back(shown, layer, selector):
    before = shown.run(COUNT, selector)
    assert before > 0
    shown.click(f"[data-layer={layer}]")
    assert shown.run(COUNT, selector) == 0
    shown.click(f"[data-layer={layer}]")
    assert shown.run(COUNT, selector) == before


def test_marks_tell_feature_case_and_reason_by_keyboard(shown):
    shown.run("document.querySelector('.mark[tabindex=\"0\"]').focus()")
    first = shown.run("return document.querySelector('#about').textContent")
    shown.keys("\ue014")
    second = shown.run("return document.querySelector('#about').textContent")
    assert first != second
    assert re.search(r"case [ABCD]\.", second)
    assert shown.run(COUNT, ".mark[tabindex='0']") == 1


def test_a_hidden_feature_says_what_hides_it(shown, towers):
    f = next(
        f
        for f in towers["hypotheses"][1]["features"]
        if f["case"] == "B" and f["hidden_by"] == ["h1"] and f["in_lobe"] and not f["self_hidden"]
    )
    label = shown.run(
        "return document.querySelector(`[data-key=\"${arguments[0]}\"]`).getAttribute('aria-label')", f"h2 {f['id']}"
    )
    assert "hidden behind wedge tower (h1)" in label


def test_webgl_has_drawn_and_turns_by_drag_keys_and_wheel(shown):
    drawn, colours, _ = shown.run(COLOURS)
    assert shown.run(DATA)["painter"] == "webgl"
    assert drawn > 5000
    assert colours > 30
    x, y = shown.run(CENTRE)
    start = yaw(shown)
    shown.drag((x, y), (x + 80, y + 10))
    dragged = yaw(shown)
    assert dragged == pytest.approx(start - 0.64, abs=0.05)
    shown.keys("\ue012")
    assert yaw(shown) == pytest.approx(dragged - 0.12, abs=0.01)
    before = float(shown.run(DATA)["distance"])
    shown.wheel(x, y, -200)
    assert float(shown.run(DATA)["distance"]) < before
    shown.keys("\ue011")
    assert yaw(shown) == pytest.approx(start, abs=0.01)
    assert complaints(shown) == []


def test_a_lost_context_is_drawn_anew_without_it(shown):
    shown.run(
        "document.querySelector('#stage canvas').getContext('webgl').getExtension('WEBGL_lose_context').loseContext()"
    )
    shown.settle()
    assert shown.run(DATA)["painter"] == "canvas"
    assert shown.run(COLOURS)[0] > 5000
    assert yaw(shown) == pytest.approx(0.95)


def test_hostile_names_are_words(chromium, towers, tmp_path):
    evil = copy.deepcopy(towers)
    evil["kb"]["name"] = HOSTILE
    for h in evil["hypotheses"]:
        h["label"], h["why"], h["type"], h["status"] = HOSTILE, HOSTILE, HOSTILE, h["status"]
    for a in evil["appearances"]:
        a["type"], a["detector"] = "__proto__", HOSTILE
    evil["trace"][0] |= {"event": "constructor", "why": HOSTILE}
    evil["assets"]["image"]["media_type"] = "text/html"
    shown_as(chromium, tmp_path, page(evil))
    assert complaints(chromium) == []
    assert chromium.run("return document.title").startswith(HOSTILE)
    assert chromium.run(COUNT, "img, iframe, object, embed, image") == 0
    assert HOSTILE in chromium.run("return document.body.innerText")


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_sticks_out_sideways(chromium, towers, tmp_path, width):
    shown_as(chromium, tmp_path, page(towers), width, 844)
    assert chromium.run("return document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("dark", [False, True])
def test_words_stand_out_from_their_ground(shown, dark):
    texts, least = contrast(shown, dark=dark)
    assert texts > 80
    assert least >= 4.5


@pytest.mark.parametrize("keys", [(), ("format", "camera", "worlds", "appearances", "hypotheses")])
def test_an_empty_interpretation_is_a_page(chromium, tmp_path, keys):
    whole = document() | {
        "appearances": [],
        "hypotheses": [],
        "worlds": [{"probability": 1.0, "present": [], "causes": {}}],
        "relations": [],
        "trace": [],
    }
    shown_as(chromium, tmp_path, page({k: whole[k] for k in keys}))
    assert complaints(chromium) == []
    assert chromium.run("return document.querySelector('h1').textContent") == "Nothing known is in view"


def test_without_webgl_a_plain_canvas_draws_and_turns(flat_chromium, towers, tmp_path):
    browser = shown_as(flat_chromium, tmp_path, page(towers))
    assert browser.run(DATA)["painter"] == "canvas"
    drawn, colours, _ = browser.run(COLOURS)
    assert drawn > 5000
    assert colours > 20
    x, y = browser.run(CENTRE)
    before = yaw(browser)
    browser.drag((x, y), (x + 60, y))
    assert yaw(browser) != before


def test_a_hundred_worlds_and_steps_are_folded_until_asked_for(chromium, towers, tmp_path):
    many = copy.deepcopy(towers)
    many["worlds"] = [towers["worlds"][1] | {"probability": 0.01} for _ in range(100)]
    many["trace"] = [towers["trace"][0] | {"step": i} for i in range(300)]
    many["hypotheses"] += [
        h | {"id": f"r{i}", "status": "rejected", "features": []} for i, h in enumerate(towers["hypotheses"] * 3)
    ]
    shown_as(chromium, tmp_path, page(many))
    visible = "return [...document.querySelectorAll(arguments[0])].filter((n) => n.offsetParent).length"
    assert [chromium.run(visible, s) for s in ("[data-world]", ".steps li:not(.fold)", "[data-alone]")] == [8, 40, 4]
    chromium.click("#world-list .more")
    assert chromium.run(visible, "[data-world]") == 100
    chromium.click("[data-world='40']")
    assert chromium.run(visible, "[data-world]") == 100
    assert complaints(chromium) == []
