"""Relations by evidence (§8 of the paper, last paragraph): one alternative of how hypotheses stand."""

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, situation
from stock_worlds import evaluated

from geometry.visibility.roc import ROC20, converse
from plogic.facts.sanity import faults
from plogic.facts.situation import EvidenceFact, names_of, pair_facts
from plogic.logic.safety.mapping import shown
from plogic.scene.asking.query import answers, answers_to_all
from plogic.scene.asking.relevant import relevant
from plogic.scene.text.program_text import program_text

pytestmark = pytest.mark.usefixtures("served_here")


PAIR = (("h2", "h1"),)
STATES = ((0.6, ("partially_occludes_po",)), (0.3, ("totally_occluded_by_tpp",)), (0.1, ("non_occludes_dc",)))
GOALS = "roc(R, X, Y)", "evidence_roc(R, X, Y)", "partially_occludes(X, Y)", "non_occludes(X, Y)", "occludes(X, Y)"


def told(*facts, reading="score", opaque=True):
    """Three hypotheses, surely present in the score reading, and what is said of how they stand."""
    some = [
        hypothesis("h1", [feature("x", match="a1")]),
        hypothesis("h2", [feature("y", match="a2")], opaque=opaque),
        hypothesis("h3", [feature("z", match="a3")]),
    ]
    return situation(some, reading, evidence=facts)


def chances(subject, goal, evidence=()):
    return {a.goal: a.probability for a in answers(subject, goal, given=evidence)}


def stock(subject, goals):
    results = evaluated(program_text(subject) + "".join(f"query({goal}).\n" for goal in goals))
    return {shown(term, names_of(subject)): p for term, p in results.items() if p > 0}


@st.composite
def distributions(draw):
    """How h2 stands to h1 and to h3."""
    states = draw(st.lists(st.tuples(*[st.sampled_from(ROC20)] * 2), min_size=1, max_size=4, unique=True))
    weights = [draw(st.integers(1, 9)) for _ in states]
    shares = tuple((w / sum(weights), state) for w, state in zip(weights, states, strict=True))
    return EvidenceFact((("h2", "h1"), ("h2", "h3")), shares, draw(st.sampled_from(((), ("h2",)))))


@settings(max_examples=6, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(distributions(), st.sampled_from(("score", "posterior")), st.booleans())
def test_query_agrees_with_stock_problog(fact, reading, opaque):
    subject = told(fact, reading=reading, opaque=opaque)
    ours = {a.goal: a.probability for found in answers_to_all(subject, GOALS) for a in found if a.probability > 0}
    assert ours == pytest.approx(stock(subject, GOALS), abs=1e-9)


def test_exactly_one_relation_holds_and_the_converse_the_other_way():
    found = chances(told(EvidenceFact(PAIR, STATES, ("h2",))), "roc(R, X, Y)")
    forward = {r: found.get(f"roc({r}, h2, h1)", 0.0) for r in ROC20}
    assert sum(forward.values()) == pytest.approx(1.0, abs=1e-9)
    assert {r: found.get(f"roc({converse(r)}, h1, h2)", 0.0) for r in ROC20} == pytest.approx(forward)
    assert forward["partially_occludes_po"] == pytest.approx(0.6)


def test_the_coarse_relations_follow():
    subject = told(EvidenceFact(PAIR, STATES, ("h2",)))
    assert chances(subject, "partially_occludes(h2, h1)") == pytest.approx({"partially_occludes(h2, h1)": 0.6})
    assert chances(subject, "totally_occludes(X, Y)") == pytest.approx({"totally_occludes(h1, h2)": 0.3})
    assert chances(subject, "evidence_relation(non_occludes, h1, h2)").popitem()[1] == pytest.approx(0.1)


def test_a_relation_holds_where_both_are_present():
    subject = told(EvidenceFact(PAIR, STATES, ("h2",)), reading="posterior")
    both = chances(subject, "present(h1), present(h2)").popitem()[1]
    assert 0.0 < both < 1.0
    assert sum(p for goal, p in chances(subject, "roc(R, h2, h1)").items()) == pytest.approx(both, abs=1e-9)


def test_where_poses_tell_the_relation_evidence_is_beside_it():
    subject = replace(told(EvidenceFact(PAIR, STATES)), relations=tuple(pair_facts("mutually_occludes_po", "h1", "h2")))
    assert set(chances(subject, "roc(R, X, Y)")) == {
        "roc(mutually_occludes_po, h1, h2)",
        "roc(mutually_occludes_po, h2, h1)",
    }
    assert chances(subject, "evidence_roc(partially_occludes_po, h2, h1)").popitem()[1] == pytest.approx(0.6)


def test_glass_occludes_nothing():
    subject = told(EvidenceFact(PAIR, STATES, ("h2",)), opaque=False)
    assert chances(subject, "occludes(X, Y)") == pytest.approx({"occludes(h1, h2)": 0.3})
    assert chances(subject, "non_occludes(h2, h1)").popitem()[1] == pytest.approx(0.7)


def test_what_is_known_of_a_third_excludes_states():
    """Jointly: given how h2 stands to h3, only those relations to h1 are left that go with it."""
    joint = EvidenceFact(
        (("h2", "h1"), ("h2", "h3")),
        ((0.7, ("partially_occludes_po", "non_occludes_dc")), (0.3, ("non_occludes_dc", "totally_occludes_ntppi"))),
        ("h2",),
    )
    found = chances(told(joint), "roc(R, h2, h1)", ["totally_occludes(h2, h3)"])
    assert found == pytest.approx({"roc(non_occludes_dc, h2, h1)": 1.0})


def test_presence_does_not_depend_on_it():
    plain, with_evidence = told(reading="posterior"), told(EvidenceFact(PAIR, STATES, ("h2",)), reading="posterior")
    assert chances(with_evidence, "present(H)") == pytest.approx(chances(plain, "present(H)"), abs=1e-12)


def test_nobody_is_told_where_it_is():
    text = program_text(told(EvidenceFact(PAIR, STATES, ("h2",))))
    assert "at(h1, " in text
    assert not any(name in text for name in ("at(h2, ", "at(h2/y, ", "body_middle(h2, "))


def test_beside_nobody_it_stands_to_nobody():
    subject = told(EvidenceFact((), ((1.0, ()),), ("h2",)))
    assert chances(subject, "roc(R, X, Y)") == {}
    assert stock(subject, ["roc(R, X, Y)", "present(h2)"])["present(h2)"] == pytest.approx(1.0)


def test_a_part_of_the_situation_keeps_what_is_said_of_it():
    joint = EvidenceFact(
        (("h2", "h1"), ("h2", "h3")),
        ((0.5, ("non_occludes_dc", "non_occludes_dc")), (0.5, ("non_occludes_dc", "non_occludes_ec"))),
        ("h2",),
    )
    assert joint.among(frozenset({"h1", "h2"})) == EvidenceFact(PAIR, ((1.0, ("non_occludes_dc",)),), ("h2",))
    assert relevant(told(joint), ["roc(R, h2, h1)"]).evidence == (joint,)


def test_every_mistake_is_told():
    wrong = EvidenceFact((("h2", "h9"), ("h1", "h1")), ((0.5, ("hides",)),), ("h2",))
    said = "\n".join(fault.what for fault in faults(told(wrong)))
    for part in (
        "'h9' is unknown",
        "paired with itself",
        "sum to 0.5",
        "1 relations of 2 pairs",
        "'hides' is no relation",
    ):
        assert part in said
