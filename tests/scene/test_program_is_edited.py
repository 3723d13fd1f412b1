"""The program as one would write it: who edits a number of its text changes what follows from it (§9.8).

The oracle is stock ProbLog on the edited text; what should follow is computed here from §5.1 and §5.4 by hand.
"""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st
from problog.program import PrologString
from situations import DV, T2_CORRECT, feature, from_table, hypothesis, random_situations, situation, towers
from stock_worlds import stock

from plogic.facts.situation import LookFact, TypeFact
from plogic.scene.asking.query import answers
from plogic.scene.text.program_text import program_text

QUICK = settings(max_examples=15, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def alone(mode="to_B", **changes):
    """The right T2 of Table 1 by itself, its occluder unknown."""
    return situation([hypothesis("t2", from_table("y", T2_CORRECT), type="t2")], "score", mode, **changes)


def p_ev(cells, dv):
    """P(ev) = (A+B)/(A+B+C+D), dv-weighted, of a table of cells A, C, B, D (§5.4)."""
    good = sum(dv[kind] * (a + b) for kind, (a, _, b, _) in cells.items())
    return good / sum(dv[kind] * sum(row) for kind, row in cells.items())


def edited(text, pattern, value):
    """The text with the number after ``pattern`` replaced; there is one such place."""
    found, count = re.subn(rf"({pattern})[0-9.e-]+", rf"\g<1>{value!r}", text)
    assert count == 1
    return found


@pytest.mark.parametrize("mode", ["to_B", "drop"])
@pytest.mark.parametrize(("kind", "value"), [("corner", 0.3), ("apex", 0.0), ("other", 0.9)])
def test_editing_a_dv_changes_p_ev_as_by_hand(mode, kind, value):
    text = program_text(alone(mode))
    asked = "query(present(t2)). query(ev_holds(t2, [])). query(ev(t2, _)).\n"
    before = stock(text + asked)
    assert before["present(t2)"] == pytest.approx(p_ev(T2_CORRECT, DV), abs=1e-9)
    after = stock(edited(text, rf"\ndv\({kind}, ", value) + asked)
    wanted = p_ev(T2_CORRECT, {**DV, kind: value})
    assert after["present(t2)"] == pytest.approx(wanted, abs=1e-9)
    assert after["ev_holds(t2,[])"] == pytest.approx(wanted, abs=1e-9)
    (said,) = [goal for goal in after if goal.startswith("ev(") and after[goal] > 0]
    assert float(said.split(",")[1].rstrip(")")) == pytest.approx(2 * wanted - 1, abs=1e-9)


def test_editing_a_count_of_a_cell_changes_ev_as_by_hand():
    text = program_text(alone("drop")).replace("row(corner, 4, 2, 2, 0)", "row(corner, 9, 2, 2, 0)")
    cells = {**T2_CORRECT, "corner": (9, 2, 2, 0)}
    assert stock(text + "query(present(t2)).")["present(t2)"] == pytest.approx(p_ev(cells, DV), abs=1e-9)


def test_editing_a_dv_changes_what_occludes_in_a_cycle():
    """Two that hide each other: h1 is sure with h2 and half sure without, by the dv of what is hidden; so is h2."""
    ring = [
        hypothesis(f"h{i}", [feature("x", match=f"a{i}"), feature("y", "C", type="apex", hidden_by=(f"h{3 - i}",))])
        for i in (1, 2)
    ]
    text = program_text(situation(ring, dv={"corner": 0.5, "apex": 0.5}))
    for apex in (0.5, 0.1):
        p = 0.5 / (0.5 + apex)
        weight = {(): (1 - p) * (1 - p), ("h1",): p * 0.0, ("h2",): p * 0.0, ("h1", "h2"): 1.0}
        found = stock(edited(text, r"\ndv\(apex, ", apex) + "query(present(h1)).")
        assert found["present(h1)"] == pytest.approx(1.0 / sum(weight.values()), abs=1e-9)


def test_editing_a_hit_rate_a_prior_and_smoothing():
    """One object, one expected feature missed: P = π(1−h) / (π(1−h) + 1 − π)."""
    missed = hypothesis("h1", [feature("x", "C", hit_rate=0.8)])
    text = program_text(situation([missed], "posterior"))
    for hit, prior in ((0.8, 0.3), (0.5, 0.3), (0.5, 0.6)):
        now = edited(edited(text, r"hit_rate\(corner, ", hit), r"prior\(box, ", prior)
        wanted = prior * (1 - hit) / (prior * (1 - hit) + 1 - prior)
        assert stock(now + "query(present(h1)).")["present(h1)"] == pytest.approx(wanted, abs=1e-9)
    smooth = edited(program_text(alone("to_B", smoothing=0.01)), r"\nsmoothing\(", 0.1)
    wanted = 0.1 + 0.8 * p_ev(T2_CORRECT, DV)
    assert stock(smooth + "query(present(t2)).")["present(t2)"] == pytest.approx(wanted, abs=1e-9)


def test_what_is_drawn_is_p_dv_and_the_weights_of_picks_are_its_complement():
    text = program_text(alone())
    drawn = stock(text + "query(drawn(_)).")
    assert {goal: p for goal, p in drawn.items() if p} == pytest.approx(
        {f"drawn({kind})": 1 - v for kind, v in DV.items()}, abs=1e-9
    )
    assert {a.goal: a.probability for a in answers(alone(), "drawn(T)")} == pytest.approx(drawn, abs=1e-9)
    picks = stock(text + "query(pick(t2, _)).")
    total = sum(DV[kind] * sum(row) for kind, row in T2_CORRECT.items())
    assert picks["pick(t2,'corner/a0')"] == pytest.approx(DV["corner"] / total, abs=1e-9)
    assert sum(picks.values()) == pytest.approx(1.0, abs=1e-9)


@QUICK
@given(random_situations(readings=("score",), modes=("to_B",)))
def test_p_ev_is_what_emerges_from_pick_and_concordance(subject):
    """In each context of present occluders: of those outside cycles, unsmoothed, that have some detected feature."""
    free = replace(subject, smoothing=0.0, overlaps=frozenset(), exclusive=frozenset(), rules="")
    text = program_text(free)
    names = [h.id for h in free.hypotheses if f"alone({h.id})." in text]
    asked = "".join(
        f"both({h}, C) :- agrees({h}), context({h}, C). query(both({h}, _)). in({h}, C) :- context({h}, C). query(in({h}, _)). "
        f"query(ev_holds({h}, _)).\n"
        for h in names
    )
    found = stock(f"{text}both(_, _) :- fail. in(_, _) :- fail. {asked}")
    assert {goal.split("(")[1].split(",")[0] for goal, p in found.items() if goal.startswith("in(") and p} == set(names)
    for goal, p in found.items():
        if goal.startswith("ev_holds(") and goal.split("(")[1].split(",")[0] in names:
            context = found.get(goal.replace("ev_holds", "in"), 0.0)
            assert found.get(goal.replace("ev_holds", "both"), 0.0) == pytest.approx(p * context, abs=1e-9), goal
            event(f"context of mass {context > 0}")


def test_object_types_stand_once_and_what_is_said_of_hypotheses_follows():
    text = program_text(towers())
    assert text.count("\nobject_type(t2).") == 1
    assert text.count("type_feature(t1, 'corner/a0', corner).") == 1
    twins = [hypothesis(f"h{i}", from_table(f"x{i}", T2_CORRECT), type="t2") for i in range(3)]
    one, three = program_text(situation(twins[:1])), program_text(situation(twins))
    assert one.count("type_feature(") == three.count("type_feature(")
    found = stock(three + "query(feature_of(_, _, _)).")
    assert {goal for goal, p in found.items() if p} == {
        f"feature_of({h.id},'{f.id}',{f.type})" for h in twins for f in h.features
    }


def test_what_one_hypothesis_has_and_another_of_its_type_has_not_is_said_of_it_alone():
    subject = situation([hypothesis("h1", [feature("x"), feature("y")]), hypothesis("h2", [feature("x", match="b")])])
    found = stock(program_text(subject) + "query(feature_of(_, _, _)). query(opaque(_)).")
    assert {goal for goal, p in found.items() if goal.startswith("feature")} == {
        "feature_of(h1,x,corner)",
        "feature_of(h1,y,corner)",
        "feature_of(h2,x,corner)",
    }


@pytest.mark.parametrize("opaque", [True, False])
def test_surfaces_facets_and_parts_are_opaque_as_their_object_is(opaque):
    """A5, A6: the surface of an object, the facets of that, and its parts."""
    body = hypothesis("h1", [feature("x"), feature("y"), feature("z")], opaque=opaque)
    subject = situation([body], types={"box": TypeFact(facets=(("x", "y", "z"),), faces=(("z", "y", "x"),))})
    found = {a.goal: a.probability for a in answers(subject, "opaque(X)") if a.probability}
    everything = {"opaque(h1)", "opaque(surface(h1))", "opaque(facet(h1, [x, y, z]))", "opaque(face(h1, [z, y, x]))"}
    assert found == dict.fromkeys(everything if opaque else (), 1.0)
    assert answers(subject, "surface_of(S, h1)")[0].goal == "surface_of(surface(h1), h1)"
    parts = {a.goal for a in answers(subject, "surface_part(S, h1)") if a.probability}
    assert parts == {"surface_part(facet(h1, [x, y, z]), h1)", "surface_part(face(h1, [z, y, x]), h1)"}


def test_a_look_is_written_with_its_lobe():
    look = LookFact("x", "l_junction", (0.0, 0.6, 0.8), 1.2, 0.5, 30.0)
    subject = situation([hypothesis("h1", [feature("x")])], types={"box": TypeFact(looks=(look,))})
    goal = "type_look(box,x,l_junction,lobe(0.0,0.6,0.8,1.2,0.5,30.0))"
    assert stock(program_text(subject) + "query(type_look(_, _, _, _)).") == {goal: 1.0}


NAMES = st.lists(st.from_regex(r"[a-z][a-z0-9_]{0,4}", fullmatch=True), min_size=1, max_size=3).map("/".join)
ODD = st.text(st.characters(codec="utf-8", exclude_categories=("Cs",)), min_size=1, max_size=6)


SOME = st.lists(
    st.one_of(NAMES, ODD, st.sampled_from(["is", "mod", "a/is", "'x'", "f1", "n1"])), unique=True, max_size=20
)


@settings(QUICK, max_examples=8)
@given(SOME)
def test_plain_names_stay_themselves_and_any_other_gets_an_atom(names):
    subject = situation([hypothesis("h1", [feature(name, match=f"a{i}") for i, name in enumerate(names)])])
    text = program_text(subject)
    assert len(list(PrologString(text))) > 100
    for name in names:
        plain = re.fullmatch(r"[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*", name) is not None
        assert (f"in_image(h1, {name})" in text or f"in_image(h1, '{name}')" in text) is plain


def test_odd_names_come_back_as_they_are():
    names = ["is", "a/is", "roof/apex", "Grand Hall", "it's", "back\\slash", "f2", "ünï", "a//b", "a/", "'x'"]
    subject = situation([hypothesis("h1", [feature(name, match=f"a{i}") for i, name in enumerate(names)])])
    quoted = {name: "'" + name.replace("\\", "\\\\").replace("'", "\\'") + "'" for name in names}
    bare = {"f2": "f2"}
    found = [a.goal for a in answers(subject, "feature(h1, F, corner)")]
    assert sorted(found) == sorted(f"feature(h1, {bare.get(name, quoted[name])}, corner)" for name in names)
    goals = ", ".join(f"feature(h1, {quoted[name]}, corner)" for name in names)
    assert answers(replace(subject, rules=f"all :- {goals}."), "all")[0].probability == pytest.approx(1.0)
