"""Results as text and as HTML: names come from strangers, and neither a terminal nor a browser obeys them."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from html.parser import HTMLParser

import pytest

from geometry.printable import visible
from plogic.face.session import results
from plogic.logic.served.engine import Answer
from plogic.scene.asking.explanations import Account

EVIL = "<script>alert('&\"')</script>\x1b[2J\n\u202etxt"
ANSWER = Answer(EVIL, 0.25, (0.25, 0.25))
ALL = [
    results.Answers(EVIL, (ANSWER,)),
    results.Predictions(EVIL, (results.Prediction(EVIL, ANSWER, ANSWER),), (EVIL,)),
    results.Observed(EVIL, 0.5, ()),
    results.Released((EVIL,), (EVIL,)),
    results.Worlds((results.World(0.5, (EVIL,), {EVIL: "noise"}, (0.5, 0.5)),), (0.1, 0.5), (EVIL,), {EVIL: EVIL}),
    results.Worlds((results.World(0.5, (EVIL,), None, (0.5, 0.5)),), (0.5, 0.5), (), None),
    results.Explained(Account(EVIL, 0.0, (), (), None), against=False, observed=(EVIL,)),
    results.Listing(EVIL, (EVIL,), ()),
    results.Listing(EVIL, (), (EVIL,), ((EVIL, EVIL),)),
    results.Help(EVIL, ((EVIL, EVIL),)),
    results.Saved(EVIL, (EVIL,)),
]
ALL.append(results.Replayed(tuple(ALL)))


class Page(HTMLParser):
    """The elements of a fragment; fails where one is closed that is not open."""

    def __init__(self, text):
        super().__init__()
        self.open, self.seen, self.texts = [], set(), []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        """As HTMLParser."""
        self.open.append(tag)
        self.seen.add(tag)
        assert {name for name, _ in attrs} <= {"class", "style", "open"}

    def handle_endtag(self, tag):
        """As HTMLParser."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """As HTMLParser."""
        self.texts.append(data)


@pytest.mark.parametrize("result", ALL, ids=lambda r: type(r).__name__)
def test_html_is_escaped_and_whole(result):
    page = Page(result._repr_html_())
    assert page.open == []
    assert page.seen <= {
        "div",
        "p",
        "table",
        "caption",
        "thead",
        "tbody",
        "tr",
        "th",
        "td",
        "details",
        "summary",
        "pre",
    }
    assert "<script>alert('&\"')</script>\\x1b[2J" in "".join(page.texts), "it is there, as text"


@pytest.mark.parametrize("result", ALL, ids=lambda r: type(r).__name__)
def test_a_terminal_is_sent_nothing_that_it_obeys(result):
    text = str(result)
    assert "<script>" in text
    assert all(c.isprintable() or c == "\n" for c in text)
    assert text == str(result)


def test_what_cannot_be_printed_is_shown_as_its_escape():
    assert visible("a\x1b[0m\n\u202e é–\u00a0") == "a\\x1b[0m\\n\\u202e é–\\u00a0"


def test_styles_only_where_asked_for(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    result = results.Answers("a", (Answer("a", 0.5, (0.5, 0.5)),))
    assert "\x1b[" not in str(result)
    assert "\x1b[1m" in result.text(styled=True)


def test_results_are_frozen_and_equal_by_value():
    one, two = (results.Answers("a", (Answer("a", 0.5, (0.5, 0.5)),)) for _ in range(2))
    assert one == two
    with pytest.raises(FrozenInstanceError):
        one.goal = "b"


def test_an_interval_prints_both_ends():
    assert "0.250..0.500" in str(results.Answers("a", (Answer("a", 0.3, (0.25, 0.5)),)))


EARLY = "\\+ dry(X), day(X)"
SAID = "goal:1:1: \\+ dry(X) is asked before X has a value, of all values at once: write it after day(X)"


@pytest.mark.parametrize(
    "result",
    [
        results.Answers(EARLY, (ANSWER,)),
        results.Predictions(EARLY, (results.Prediction(EARLY, ANSWER, ANSWER),), ()),
        results.Observed(EARLY, 0.5, ()),
    ],
    ids=lambda r: type(r).__name__,
)
def test_what_is_surely_not_meant_so_is_told_below(result):
    place = "literal" if isinstance(result, results.Observed) else "goal"
    assert str(result).splitlines()[-1] == SAID.replace("goal", place, 1)
    assert str(results.Answers("day(X), \\+ dry(X)", ())).count("is asked before") == 0
