"""Why a feature is not detected, or detected and not expected (§4): by hand, as a law, by stock ProbLog."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from situations import feature, hypothesis, random_situations, situation
from stock_worlds import evaluated

from plogic.facts.situation import names_of
from plogic.logic.served.engine import Text
from plogic.scene.asking.live import scene_answers
from plogic.scene.asking.query import answers_to_all
from plogic.scene.text.program_text import program_text

pytestmark = pytest.mark.usefixtures("served_here")
QUICK = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
LAWS = r"""
why_told(H, F) :- why(H, F, _).
untold(H, F, K) :- case(H, F, K), K \= a, \+ why_told(H, F).
needless(H, F, C) :- why(H, F, C), case(H, F, a).
in_front(H, F, G) :- why(H, F, behind(G)), behind(H/F, G), opaque(G), \+ expected(H, F).
not_in_front(H, F, G) :- why(H, F, behind(G)), \+ in_front(H, F, G).
"""


def scene(reading):
    front = hypothesis("front", [feature("seen"), feature("taken", match="shared", residual=0.1)])
    back = hypothesis(
        "back",
        [
            feature("seen"),
            feature("away", "B"),
            feature("inside", "C", self_hidden=True),
            feature("out", "C", in_image=False),
            feature("covered", "C", hidden_by=("front",)),
            feature("lost", "C"),
            feature("odd", "D", match="stray"),
            feature("others", "D", match="shared"),
        ],
    )
    return situation([front, back], reading, smoothing=0.01)


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_each_cause_and_what_is_detected_as_expected_has_none(reading):
    subject = scene(reading)
    both, back, causes = answers_to_all(
        subject, ["present(front), present(back)", "present(back)", "why(back, F, Cause)"]
    )
    told = {answer.goal: answer.probability for answer in causes}
    alone, beside = back[0].probability, both[0].probability
    assert 0.0 < beside < alone < 1.0
    always = {"away": "turned_away", "inside": "self_hidden", "out": "outside", "lost": "missed", "odd": "noise"}
    sure = {f"why(back, {f}, {cause})": alone for f, cause in always.items()}
    by_front = {
        "why(back, covered, behind(front))": beside,
        "why(back, covered, missed)": alone - beside,
    }
    chosen = {k: p for k, p in told.items() if k.startswith("why(back, others,")}
    assert {k: p for k, p in told.items() if k not in chosen} == pytest.approx(sure | by_front, abs=1e-9)
    assert set(chosen) == {"why(back, others, caused_by(front/taken))", "why(back, others, noise)"}
    assert sum(chosen.values()) == pytest.approx(alone, abs=1e-9)


@QUICK
@given(random_situations(most=3))
def test_what_is_not_as_expected_has_a_cause_and_what_is_has_none(subject):
    goals = ["untold(H, F, K)", "needless(H, F, C)", "not_in_front(H, F, G)"]
    found = answers_to_all(replace(subject, own=Text(LAWS, "laws.pl")), goals)
    assert [[a for a in row if a.probability > 1e-12] for row in found] == [[], [], []]


@QUICK
@given(random_situations(most=3))
def test_probabilities_of_causes_are_stock_problogs(subject):
    from plogic.logic.safety.mapping import shown

    theirs = evaluated(f"{program_text(subject)}\nquery(why(H, F, C)).\n")
    ours = {a.goal: a.probability for a in scene_answers(subject, ["why(H, F, C)"])[0] if a.probability > 0}
    assert ours == pytest.approx({shown(term, names_of(subject)): p for term, p in theirs.items() if p > 0}, abs=1e-9)
