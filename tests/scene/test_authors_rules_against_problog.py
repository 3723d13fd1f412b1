"""Sixty texts of authors' rules (§9.7): stock ProbLog on the written program agrees with ours."""

from __future__ import annotations

from dataclasses import replace
from itertools import count
from random import Random

import pytest
from authors_rules import TEXTS
from problog.errors import InconsistentEvidenceError
from situations import _random_situation, with_gravity
from stock_worlds import evaluated, subsets, worlds_program
from test_space_against_problog import with_space

from plogic.base.errors import InconsistentError
from plogic.facts.situation import names_of
from plogic.logic.safety.mapping import shown
from plogic.scene.asking.query import answers
from plogic.scene.worlds.ranked_worlds import ranked_worlds

MOST_SCENES = 4
READINGS = ("score", "posterior")
MODES = ("to_B", "drop", "reassign")


pytestmark = pytest.mark.usefixtures("served_here")


def scene(seed, reading, rules):
    """Two or three hypotheses somewhere, under gravity, in the seed's mode."""
    mode = MODES[seed % 3]
    drawn = next(
        found
        for i in count()
        if len((found := _random_situation(Random(100 * seed + i), 3, (reading,), (mode,))).hypotheses) > 1  # noqa: S311
    )
    return replace(with_gravity(with_space(drawn, seed), seed), rules=rules, rank={"box": 0.9}, dv={"corner": 0.95})


def stock(subject, goals):
    """The answers to the goals as users write them, and the probability of each subset of the hypotheses."""
    names = names_of(subject)
    asked = "".join(f"query({goal}).\n" for goal in goals)
    found = evaluated(f"{worlds_program(subject)}\n{asked}")
    return {shown(term, names): p for term, p in found.items() if p > 0}


def assert_agrees(subject, goal):
    """Whether there is a world; worlds, who is present and the goal's answers are those of stock ProbLog."""
    try:
        theirs = stock(subject, {"present(X)", goal})
    except InconsistentEvidenceError:
        with pytest.raises(InconsistentError, match="no world satisfies"):
            ranked_worlds(subject)
        return False
    ranking = ranked_worlds(subject, 10**6)
    found = {f"present({name})": p for name, p in ranking.marginals.items()}
    found |= {a.goal: a.probability for asked in ("present(X)", goal) for a in answers(subject, asked)}
    numbers = {present: i for i, present in enumerate(subsets(subject))}
    found |= {f"world({numbers[w.present]})": w.probability for w in ranking.worlds}
    assert {key: p for key, p in found.items() if p > 0} == pytest.approx(theirs, abs=1e-9)
    return True


@pytest.mark.parametrize("number", range(len(TEXTS)), ids=[name for name, _ in TEXTS])
def test_the_program_says_the_same(number):
    """In both readings; in further scenes too, where no world is possible in the first."""
    text, goal = TEXTS[number][1]
    for reading in READINGS:
        scenes = (scene(number + 100 * i, reading, text) for i in range(MOST_SCENES))
        assert any(assert_agrees(one, goal) for one in scenes), "no scene has a world"


def test_there_are_sixty_different_texts():
    assert len(TEXTS) == len({text for _, (text, _) in TEXTS}) == 60
