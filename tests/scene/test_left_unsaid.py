"""What a goal means, though looks and data that it does not speak of are not written.

Names that stand after a look's in the table of a situation are meant as they were.
"""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from situations import feature, hypothesis, situation

from plogic.facts.situation import LookFact, TypeFact
from plogic.scene.factors.goal_meaning import DATA, free_program, meaning

GOALS = "explained('A_a')", "explained('A_b')", "explained(A)", "match(h1, F, 'A_b')"


def seen(look):
    """Two features matched to ``A_a`` and ``A_b``, of a type that may look as ``look``."""
    looks = (LookFact("a", look, (0.0, 0.0, 1.0), 1.0, 0.0, 9.0),)
    kind = TypeFact((("a", "corner"), ("b", "corner")), looks=looks)
    features = [feature(name, match=f"A_{name}") for name in "ab"]
    return situation([hypothesis("h1", features)], reading="posterior", types={"box": kind})


@pytest.mark.parametrize("look", ["patch", "Patch 1", "A"])
def test_a_goal_means_the_same_whatever_the_looks_are_called(served_here, look):
    found = meaning(seen(look), GOALS)
    assert [[shown for shown, key in answers if key is not None] for answers in found.answers] == [
        ["explained('A_a')"],
        ["explained('A_b')"],
        ["explained('A_a')", "explained('A_b')"],
        ["match(h1, b, 'A_b')"],
    ]
    assert found == meaning(seen("patch"), GOALS)


def test_who_asks_of_looks_is_told_them(served_here):
    (answers,) = meaning(seen("Patch 1"), ["type_look(box, F, L, C)"]).answers
    assert [shown for shown, _ in answers] == ["type_look(box, a, 'Patch 1', lobe(0.0, 0.0, 1.0, 1.0, 0.0, 9.0))"]


def test_who_asks_of_data_is_told_them(served_here):
    data, noise, both = meaning(seen("patch"), ["datum(A, T)", "noise(A)", "noise(A), datum(A, l_junction)"]).answers
    assert [shown for shown, _ in data] == ["datum('A_a', l_junction)", "datum('A_b', l_junction)"]
    assert [shown for shown, _ in noise] == ["noise('A_a')", "noise('A_b')"]
    assert len(both) == 2


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_whatever_the_rules_say_of_data_has_a_word_that_keeps_them(reading):
    text = free_program(replace(seen("patch"), reading=reading), data=False)
    rules = [line.partition(" :- ") for line in text.splitlines() if line[:1].islower() and ":- fail." not in line]
    leading, before = {"datum"}, set[str]()
    while leading != before:
        before = set(leading)
        told = re.compile(rf"\b({'|'.join(before)})\(")
        leading |= {head.partition("(")[0] for head, _, body in rules if told.search(body)}
    assert leading == set(DATA) == {"datum", "noise", "why"}
    assert text.splitlines() == [
        line
        for line in free_program(replace(seen("patch"), reading=reading)).splitlines()
        if not line.startswith("datum(")
    ]
