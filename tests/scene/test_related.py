"""A relation told in words: its numbers are those of the answers, and what it needs is what geometry leaves open."""

from __future__ import annotations

import itertools
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import random_situations, towers

from plogic.base.errors import InconsistentError
from plogic.scene.asking.explanations import explain, present
from plogic.scene.asking.query import answers
from plogic.scene.asking.related import related

LAW = settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
GIVEN = ((), ("present(h1)",), ("\\+ present(h0)",), ("noise(a0)",))


pytestmark = pytest.mark.usefixtures("served_here")


def number_after(word, line):
    return float(re.search(rf"{word} ([0-9.e-]+)", line)[1])


@LAW
@given(
    random_situations(most=4),
    st.sampled_from(["occludes", "dr", "partially_occludes", "left_of"]),
    st.sampled_from(GIVEN),
)
def test_the_probability_is_that_of_the_answer_and_what_is_composed_comes_to_it(subject, relation, evidence):
    for x, y in itertools.permutations([h.id for h in subject.hypotheses], 2):
        goal = f"{relation}({x}, {y})"
        try:
            ((answer,),) = [answers(subject, goal, given=evidence)]
            probability, lines = related(subject, goal, evidence)
        except InconsistentError:
            continue
        assert probability == pytest.approx(answer.probability, abs=1e-12)
        whole = [line for line in lines if line.startswith("  together")]
        if whole:
            assert number_after("=", whole[0]) == pytest.approx(probability, rel=1e-3, abs=1e-12)
        failing = [
            float(p) for line in lines if line.startswith("it fails") for p in re.findall(r"\(([0-9.e-]+)\)", line)
        ]
        if failing:
            assert 1.0 - sum(failing) == pytest.approx(probability, abs=2e-3)


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_a_relation_that_holds_is_told_by_who_must_be_present(reading):
    account = present(towers(reading), "partially_occludes(t1, t2)")
    text = "\n".join(account.summary)
    assert "it says: t1 is in front of a part of t2" in text
    assert "geometry says so of them" in text
    assert re.search(r"t1, a \w+, is present: [01][.\d]*\n  t2, a \w+, is present where t1 is present: ", text)
    assert ("it fails where t2 is absent though t1 is present (0.03897)" in text) == (reading == "score")


def test_a_relation_that_does_not_hold_says_which_does():
    probability, lines = related(towers("score"), "partially_occludes(t2, t1)")
    assert probability == 0.0
    assert "geometry does not say so of them, as they are posed" in lines
    assert "  outlines and depth: partially_occludes(t1, t2)" in "\n".join(lines)
    assert lines[-1] == "so it holds in no world, whoever is present"


def test_of_a_goal_with_variables_the_most_probable_answer_is_told():
    account = present(towers("score"), "partially_occludes(X, t2)")
    assert account.summary[0] == "the most probable answer, partially_occludes(t1, t2):"
    assert account.summary[1:] == related(towers("score"), "partially_occludes(t1, t2)")[1]
    assert account.answers == len(answers(towers("score"), "partially_occludes(X, t2)"))
    assert present(towers("score"), "cause(A, t1, F)") is None


def test_the_misses_are_there_beside_it():
    account = explain(towers("score"), "partially_occludes(t2, t1)")
    assert account.summary
    assert account.misses


@pytest.mark.parametrize(
    "goal", ["present(t1), present(t2)", "occludes(t1, X)", "cause(a1, t1, 'x')", "case(t1, x, a)", "occludes(t1"]
)
def test_nothing_else_is_told_so(goal):
    assert related(towers("score"), goal) is None
