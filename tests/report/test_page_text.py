"""The page as text: bytes that repeat, a policy that names its own hashes, data that cannot escape."""

from __future__ import annotations

import base64
import copy
import hashlib
import json
import math
import re

import pytest

from plogic.overlay import PALETTE
from plogic.report.errors import ReportError
from plogic.report.page import SCRIPTS, embedded, page

HOSTILE = "</script><img src=x onerror=alert(1)><!--"


def _element(text, name, attributes=""):
    found = re.findall(f"<{name}{attributes}>(.*?)</{name}>", text, re.DOTALL)
    assert len(found) == 1
    return found[0]


def test_the_same_document_gives_the_same_bytes(towers):
    assert page(towers) == page(copy.deepcopy(towers))


@pytest.mark.parametrize("name", ["script", "style"])
def test_the_policy_names_the_hash_of_what_is_inside(towers, name):
    text = page(towers)
    digest = base64.b64encode(hashlib.sha256(_element(text, name).encode()).digest()).decode()
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text).group(1)
    assert f"{name}-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy


def test_the_data_comes_back_as_it_went_in(towers):
    assert json.loads(_element(page(towers), "script", ' type="application/json" id="interpretation"')) == towers


def test_no_handler_no_eval_no_markup_from_data_and_nothing_loaded(towers):
    text = page(towers | {"assets": {}})
    assert not re.search(
        r"\son\w+=|innerHTML|outerHTML|insertAdjacent|document\.write|\beval\b|new Function|javascript:", text
    )
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text)


def test_hostile_names_stay_inside_the_data(towers):
    text = page(
        towers | {"kb": {"name": HOSTILE, "digest": ""}, "hypotheses": [{"status": "accepted", "label": HOSTILE}]}
    )
    assert text.count("</script>") == 2
    assert "<img" not in text
    assert embedded({"x": HOSTILE}).isascii()
    assert json.loads(embedded({"x": HOSTILE})) == {"x": HOSTILE}


@pytest.mark.parametrize("value", [math.nan, math.inf, object()])
def test_what_json_does_not_know_is_refused(towers, value):
    with pytest.raises(ReportError, match="cannot be written as JSON"):
        page(towers | {"smoothing": value})


def test_the_code_stays_small(towers):
    text = page(towers | {"assets": {}})
    assert len(SCRIPTS) == 9
    assert len(_element(text, "script")) < 52_000


def test_page_and_picture_have_the_same_colours(towers):
    assert "const PALETTE = [" + ", ".join(f"'{c}'" for c in PALETTE) + "]" in page(towers)
