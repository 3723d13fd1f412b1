"""The page as text: bytes that repeat, a policy that names its own hashes, data that cannot escape."""

from __future__ import annotations

import copy
import json
import math

import pytest
from page_checks import check_harmless, check_policy, data_text, element

from plogic.face.pages.one_file import PageError, embedded, page
from plogic.face.shown.overlay import PALETTE

HOSTILE = "</script><img src=x onerror=alert(1)><!--"


def test_the_same_document_gives_the_same_bytes(towers):
    assert page(towers) == page(copy.deepcopy(towers))


@pytest.mark.parametrize("name", ["script", "style"])
def test_the_policy_names_the_hash_of_what_is_inside(towers, name):
    check_policy(page(towers), name)


def test_the_data_comes_back_as_it_went_in(towers):
    assert json.loads(data_text(page(towers))) == towers


def test_no_handler_no_eval_no_markup_from_data_and_nothing_loaded(towers):
    check_harmless(page(towers | {"assets": {}}))


def test_hostile_names_stay_inside_the_data(towers):
    text = page(
        towers | {"kb": {"name": HOSTILE, "digest": ""}, "hypotheses": [{"status": "accepted", "label": HOSTILE}]}
    )
    assert text.count("</script>") == 6
    assert "<img" not in text
    assert embedded({"x": HOSTILE}).isascii()
    assert json.loads(embedded({"x": HOSTILE})) == {"x": HOSTILE}


@pytest.mark.parametrize("value", [math.nan, math.inf, object()])
def test_what_json_does_not_know_is_refused(towers, value):
    with pytest.raises(PageError, match="cannot be written as JSON"):
        page(towers | {"smoothing": value})


def test_the_code_stays_small(towers):
    text = page(towers | {"assets": {}})
    assert len(element(text, "script")) < 77_000


def test_ids_in_what_is_drawn_cannot_escape(towers):
    hostile = copy.deepcopy(towers)
    for h in hostile["hypotheses"]:
        h["id"] += HOSTILE
    text = page(hostile)
    edges = json.loads(element(text, "script", ' type="application/json" id="edges"'))
    assert set(edges) == {h["id"] for h in hostile["hypotheses"]}
    assert any(f"h1{HOSTILE}" in run[2] for run in edges[f"h2{HOSTILE}"])
    assert text.count("</script>") == 6


def test_page_and_picture_have_the_same_colours(towers):
    assert "const PALETTE = [" + ", ".join(f"'{c}'" for c in PALETTE) + "]" in page(towers)
