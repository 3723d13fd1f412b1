"""Queries: answers, evidence, labels, rules, and errors with their place."""

from __future__ import annotations

import pytest
from situations import feature, hypothesis, situation, towers

from plogic.base.errors import (
    InconsistentError,
    NegativeCycleError,
    NonGroundError,
    PlogicError,
    ProgramError,
    UnknownPredicateError,
)
from plogic.facts.hypothesis import PartFact
from plogic.facts.situation import PairFact
from plogic.facts.vocabulary import VOCABULARY, entries, table
from plogic.logic.served.engine import Text, run
from plogic.scene.asking.query import answers, answers_to_all
from plogic.scene.worlds.ranked_worlds import ranked_worlds

pytestmark = pytest.mark.usefixtures("programs_run_here")


def asked(subject, goal, **options):
    return {a.goal: a.probability for a in answers(subject, goal, **options)}


def test_every_answer_most_probable_first_with_its_interval():
    found = answers(towers(), "object(H, T)")
    assert [a.goal for a in found] == ["object(t1, t1)", "object(t2, t2)", "object(t2_distorted, t2)"]
    assert [round(a.probability, 3) for a in found] == [1.0, 0.961, 0.010]
    assert all(a.interval == (a.probability, a.probability) for a in found)


def test_without_a_goal_a_situation_lists_its_hypotheses():
    assert asked(towers(), None) == pytest.approx(
        {f"present({h})": p for h, p in ranked_worlds(towers()).marginals.items()}, abs=1e-9
    )


def test_without_a_goal_a_program_answers_its_own_queries():
    assert asked(Text("0.3::a. b :- a. query(a). query(b)."), None) == pytest.approx({"a": 0.3, "b": 0.3})


def test_conjunction_negation_and_evidence():
    assert asked(towers(), "present(t1), \\+ present(t2)")["present(t1), \\+ present(t2)"] == pytest.approx(
        0.039, abs=5e-4
    )
    given = asked(towers(), "present(t2_distorted)", given=["\\+ present(t2)"])
    assert given["present(t2_distorted)"] == pytest.approx((1 - 0.508046) / 2, abs=1e-6)
    with pytest.raises(InconsistentError, match=r"alone is impossible; choices .* --smoothing 0.01 leaves them open"):
        answers(towers(), "present(t2)", given=["\\+ present(t1)"])
    with pytest.raises(InconsistentError, match=r"alone is impossible$"):
        answers(towers(), "present(t2)", given=["present(t1), \\+ present(t1)"])


def test_no_answer_is_an_answer():
    assert answers(towers(), "mutually_occludes(X, Y)") == []
    assert asked(towers(), "present(t9)") == {"present(t9)": 0.0}


LABELS = ["'roof top/Apex'", '"roof top/Apex"', "F"]


@pytest.mark.parametrize("label", LABELS)
def test_labels_are_mapped_both_ways(label):
    odd = hypothesis("H 1", [feature("roof top/Apex", match="Ä\n1")], type="it's")
    subject = situation([odd], priors={"it's": 0.5})
    assert asked(subject, f"cause(A, 'H 1', {label})") == {"cause('Ä\n1', 'H 1', 'roof top/Apex')": 1.0}
    assert list(asked(subject, "object(H, T)")) == ["object('H 1', 'it\\'s')"]


@pytest.mark.parametrize("node", ["'t1/corner/a0'", "t1/'corner/a0'", "t1/corner/a0"])
def test_nodes_are_written_as_paths(node):
    assert asked(towers(), f"part({node}, t1)") == {"part(t1/'corner/a0', t1)": 1.0}
    assert asked(towers(), f"atom({node})") == {"atom(t1/'corner/a0')": 1.0}


def test_no_name_is_read_as_program_text():
    evil = "x). present(zzz"
    subject = situation(
        [hypothesis(evil, [feature("a'), query(b", type="t)\n:- consult(x).\n% ")], type="% \nquery(present(zzz)).")]
    )
    assert list(asked(subject, "present(H)")) == [f"present('{evil}')"]


def test_mereology():
    parts = (PartFact("roof", "", "object", "roof"), PartFact("roof/apex", "roof", "feature", "apex"))
    tower = hypothesis("h1", [feature("roof/apex"), feature("wall")], parts=parts)
    subject = situation([tower, hypothesis("h2", [feature("wall", match="b")])])
    rows = {
        "part(P, h1)": {"part(h1/roof, h1)", "part(h1/'roof/apex', h1)", "part(h1/wall, h1)"},
        "pp(X, h1/roof)": {"pp(h1/'roof/apex', h1/roof)"},
        "p(h1/roof, X)": {"p(h1/roof, h1/roof)", "p(h1/roof, h1)"},
        "o(h1/roof, X)": {"o(h1/roof, h1/roof)", "o(h1/roof, h1)", "o(h1/roof, h1/'roof/apex')"},
        "dr(h1/roof, X)": {"dr(h1/roof, h1/wall)", "dr(h1/roof, h2)", "dr(h1/roof, h2/wall)"},
        "max_object(X)": {"max_object(h1)", "max_object(h2)"},
        "atom(X)": {"atom(h1/'roof/apex')", "atom(h1/wall)", "atom(h2/wall)"},
    }
    for answer, expected in zip(answers_to_all(subject, list(rows)), rows.values(), strict=True):
        assert {a.goal for a in answer} == expected


def test_occlusion_by_outlines_and_by_features():
    front = hypothesis("h1", [feature("x")])
    back = hypothesis("h2", [feature("y", "C", hidden_by=("h1",)), feature("z", "D", hidden_by=("h1",), match="b")])
    subject = situation(
        [front, back], relations=(PairFact("totally_occludes", "h1", "h2", "totally_occludes_tppi"),), smoothing=0.01
    )
    goals = ["hides_all_features(X, Y)", "occludes(X, Y)", "roc(R, X, Y)", "behind(Y, X)", "non_occludes(X, Y)"]
    hides, occludes, roc, behind, non = ([a.goal for a in row] for row in answers_to_all(subject, goals))
    assert (hides, occludes, non) == (["hides_all_features(h1, h2)"], ["occludes(h1, h2)"], [])
    assert roc == ["roc(totally_occluded_by_tpp, h2, h1)", "roc(totally_occludes_tppi, h1, h2)"]
    assert behind == ["behind(h2, h1)", "behind(h2/y, h1)", "behind(h2/z, h1)"]


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_the_whole_vocabulary_can_be_asked(reading):
    letters = "XYZ"
    goals = [f"{e.usage.split('(')[0]}({', '.join(letters[: e.arity])})" for e in entries(reading) if e.name != "near"]
    two = situation(
        [hypothesis("h1", [feature("x")]), hypothesis("h2", [feature("y", match="b"), feature("z", "D")])], reading
    )
    assert len(answers_to_all(two, [*goals, "near(X, Y, 1)"])) == len(goals) + 1


def test_the_vocabulary_is_the_contracts():
    contract = """object/2 present/1 part/2 pp/2 p/2 o/2 dr/2 max_object/1 feature/3 expected/2 detected/2 case/3
    cause/3 noise/1 behind/2 occludes/2 totally_occludes/2 partially_occludes/2 mutually_occludes/2 non_occludes/2
    roc/3 opaque/1 dv/2 rank/2 ev/2 left_of/2 nearer/2 near/3"""
    assert set(contract.split()) <= {e.signature for e in VOCABULARY}
    assert "| `atom(X)` |" in table()
    assert all(f"| `{e.usage}` | {e.meaning} |" in table() for e in VOCABULARY if e.reading != "posterior")


def test_rules_of_a_knowledge_base_and_of_a_user():
    rules = "alone(H) :- present(H).\n"
    with pytest.raises(ProgramError, match=r"rules\.pl:1:1: alone/1 is defined by the program"):
        answers(towers(rules=rules))
    subject = towers(
        rules="tip(H) :- feature(H, 'corner/a0', corner), \\+ noise(\"y_apex_A0\"). 0.5::lucky(H) :- tip(H)."
    )
    assert asked(subject, "lucky(t2)")["lucky(t2)"] == pytest.approx(0.961 / 2, abs=5e-4)
    assert ranked_worlds(subject).marginals == ranked_worlds(towers()).marginals
    both = Text("both(X, Y) :- present(X), present(Y), X \\= Y.", "mine.pl")
    assert asked(towers(own=both), "both(t1, t2)")["both(t1, t2)"] == pytest.approx(0.961, abs=5e-4)


ERRORS = [
    ("a :- \\+ b.\nb :- \\+ a.\nquery(a).", NegativeCycleError, "u.pl:2:6: "),
    ("0.5::a(X).\nquery(a(_)).", NonGroundError, "u.pl:1:6: "),
    ("a(1).\nb :- a(X),\n  nothing(X).\nquery(b).", UnknownPredicateError, "u.pl:3:3: no clauses for nothing/1"),
    ("a :- member(1, [1]). query(a).", UnknownPredicateError, "u.pl:1:6: "),
    ("a :- b(.", ProgramError, "u.pl:1:7: Unmatched"),
    ("a.\nb :- ,c.", ProgramError, "u.pl:2:6: "),
    ("a :- !. query(a).", UnknownPredicateError, "u.pl:1:6: "),
    ("a :- b(X), X > 1. b(z). query(a).", ProgramError, "u.pl:1:"),
    ("1.5::a. query(a).", ProgramError, "u.pl"),
    ("X.", ProgramError, "u.pl:1:1: "),
]


@pytest.mark.parametrize(("program", "kind", "start"), ERRORS)
def test_errors_state_file_line_and_column(program, kind, start):
    with pytest.raises(kind) as caught:
        run([Text(program, "u.pl")])
    assert str(caught.value).startswith(start)
    assert "\n" not in str(caught.value)


def test_errors_in_rules_and_goals_name_them():
    with pytest.raises(ProgramError, match=r"^mine\.pl:2:6: no clauses for b/0"):
        answers(towers(own=Text("c.\na :- b.", "mine.pl")))
    with pytest.raises(ProgramError, match=r"^goal:1:8: "):
        answers(towers(), "present(")
    with pytest.raises(PlogicError, match=r"^goal: a goal is one term"):
        answers(towers(), "present(t1). present(t2)")
