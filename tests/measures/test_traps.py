"""The traps (a) to (g) of §8.

An index of the tests that each has, and those that need a Γ, a cycle and a whole ``perceive``.
"""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from comparing import turned
from situations import feature, hypothesis, situation
from synthetic import belief_at, cycle_of, data, one_before_the_other, perceiver, scene, side_by_side, towers

from plogic.base.errors import InconsistentError
from plogic.cycle.delta import Delta, Options, delta_of
from plogic.measures.explanatory import Cells, explanatory_value, probability_of_ev
from plogic.run.perceive import SMOOTHED, ranked
from plogic.scene.worlds.ranked_worlds import ranked_worlds

TESTS = Path(__file__).parent.parent
PROGRAM, CYCLE, HERE = "scene/test_traps_of_section_8.py", "cycle/test_cycle.py", "measures/test_traps.py"

INDEX = {
    "a": [
        (PROGRAM, "test_a_rivals_that_share_an_appearance_have_exactly_one_cause_each"),
        (HERE, "test_a_every_appearance_has_one_cause_in_every_world"),
    ],
    "b": [
        (PROGRAM, "test_b_a_fully_hidden_phantom_is_not_present"),
        (PROGRAM, "test_b_one_detected_feature_makes_it_count"),
        (CYCLE, "test_b_a_fully_hidden_phantom_is_never_accepted"),
        (HERE, "test_b_a_phantom_in_delta_has_no_world"),
    ],
    "c": [
        (PROGRAM, "test_c_smoothing_moves_the_dogmatic_and_is_off_by_default"),
        (HERE, "test_c_where_certainties_clash_perceive_smooths_and_says_so"),
        (HERE, "test_c_smoothing_never_touches_the_measure"),
    ],
    "d": [
        (PROGRAM, "test_d_unexplained_data_cost_something"),
        (HERE, "test_d_the_empty_world_loses_where_data_want_an_explanation"),
    ],
    "e": [
        (PROGRAM, "test_e_a_common_appearance_is_not_noise_when_its_clutter_is_rare"),
        (HERE, "test_e_windows_are_no_noise"),
    ],
    "f": [
        (PROGRAM, "test_f_cyclic_occlusion_is_one_alternative_over_joint_states"),
        (PROGRAM, "test_f_presence_depends_on_occluders"),
        (PROGRAM, "test_f_a_cycle_without_a_stable_state_accepts_none"),
        (HERE, "test_f_what_is_behind_is_likelier_beside_what_hides_it"),
    ],
    "g": [
        (PROGRAM, "test_g_hundreds_of_weak_appearances"),
        (PROGRAM, "test_g_labels_are_never_below_problogs_threshold"),
        (HERE, "test_g_a_thousand_pieces_of_clutter_do_not_underflow"),
    ],
}


@pytest.mark.parametrize("trap", "abcdefg")
def test_every_trap_has_its_tests(trap):
    """The names that the index gives exist where it says, and assert something."""
    assert INDEX[trap]
    for file, name in INDEX[trap]:
        tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
        found = [node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == name]
        assert len(found) == 1, f"{name} is not in {file}"
        assert any(isinstance(node, ast.Assert) or is_check(node) for node in ast.walk(found[0])), (
            f"{name} asserts nothing"
        )


def is_check(node):
    """Whether a node calls one of the helpers that assert, or expects an error."""
    name = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
    return name.startswith("assert_") or name == "pytest.raises"


@pytest.fixture(scope="module")
def hiding():
    """t1 hides a part of t2, in clutter; a t2 that stands 2 cm off is considered too: (shot, cycle)."""
    rng = np.random.default_rng(8100)
    shot = scene(rng, one_before_the_other(rng))
    cycle = cycle_of(shot.gamma)
    assert len(cycle.accepted) == 2
    return shot, replace(
        cycle, considered=(belief_at("t2", turned(shot.poses["t2"], 0.0, (0.02, 0, 0)), data(shot), "rival"),)
    )


def situation_of(shot, cycle, reading, **changes):
    return replace(delta_of(cycle, data(shot), towers(), perceiver().dv, Options(reading=reading)).situation, **changes)


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_a_every_appearance_has_one_cause_in_every_world(reading, hiding):
    shot, cycle = hiding
    subject = situation_of(shot, cycle, reading)
    claimed = [f.match for h in subject.hypotheses for f in h.features if f.match]
    assert len(claimed) > len(set(claimed)), "some appearance is claimed twice"
    ranking = ranked_worlds(subject, 1000)
    for world in ranking.worlds:
        assert world.causes.keys() == {a.id for a in subject.appearances}
        causes = [c for c in world.causes.values() if c != "noise"]
        assert len(set(causes)) == len(causes), "a feature causes one appearance"
        assert all(c.split("/")[0] in world.present for c in causes)


def test_b_a_phantom_in_delta_has_no_world():
    """Put among the hypotheses by hand, a t2 wholly hidden by t1 has probability 0 in the score reading.

    Alone its ev would be 1.
    """
    rng = np.random.default_rng(8101)
    front = side_by_side(rng)["t1"]
    shot = scene(rng, {"t1": front}, clutter=0)
    away = front.copy()
    away[:3, 3] = 4.0 * front[:3, 3]
    empty = data(replace(shot, gamma=replace(shot.gamma, appearances=())))
    phantom = belief_at("t2", away, empty)
    hidden = np.ones(len(phantom.uv), dtype=bool)
    assert explanatory_value(phantom.support(hidden), perceiver().dv) == 1.0
    cycle = cycle_of(shot.gamma)
    subject = situation_of(shot, replace(cycle, considered=(replace(phantom, status="rival"),)), "score")
    for mode in ("to_B", "drop", "reassign"):
        assert ranked_worlds(replace(subject, reconsider=mode)).marginals["h2"] == 0.0


def certain_rivals():
    """Two hypotheses in one place, each with P(ev) = 1: no world satisfies A4."""
    both = [hypothesis("h1", [feature("x")]), hypothesis("h2", [feature("y")])]
    return situation(both, overlaps=frozenset({("h1", "h2")}))


def test_c_where_certainties_clash_perceive_smooths_and_says_so():
    subject, trace = certain_rivals(), []
    with pytest.raises(InconsistentError):
        ranked_worlds(subject)
    softer, ranking = ranked(Delta(subject), trace)
    assert softer.situation == replace(subject, smoothing=SMOOTHED)
    assert ranking.marginals["h1"] == pytest.approx(ranking.marginals["h2"])
    assert {w.present for w in ranking.worlds} == {("h1",), ("h2",), ()}
    assert sum(w.probability for w in ranking.worlds) == pytest.approx(1.0)
    assert [row["event"] for row in trace] == ["smooth"]
    assert str(SMOOTHED) in trace[0]["why"]
    assert "h1, h2" in trace[0]["why"]


def test_c_without_a_clash_nothing_is_smoothed():
    subject, trace = replace(certain_rivals(), overlaps=frozenset()), []
    delta, ranking = ranked(Delta(subject), trace)
    assert delta.situation.smoothing == 0.0
    assert trace == []
    assert ranking.marginals == {"h1": 1.0, "h2": 1.0}


def test_c_smoothing_never_touches_the_measure(hiding):
    """The ev in the document is the same with and without ε; only the program's choices move."""
    shot, _ = hiding
    plain, smooth = (perceiver()(shot.gamma, Options(smoothing=e)) for e in (0.0, 0.05))
    assert Options().smoothing == 0.0
    assert [h["ev_reconsidered"] for h in plain["hypotheses"]] == [h["ev_reconsidered"] for h in smooth["hypotheses"]]
    assert plain["worlds"][0]["probability"] != smooth["worlds"][0]["probability"]
    certain = {"corner": Cells(4, 0, 2, 0)}
    assert probability_of_ev(explanatory_value(certain, perceiver().dv)) == 1.0


def test_d_the_empty_world_loses_where_data_want_an_explanation(hiding):
    """The posterior makes unexplained data pay: however small a tower's prior, the empty world is no refuge."""
    shot, cycle = hiding
    for prior in (0.5, 1e-3, 1e-6):
        ranking = ranked_worlds(situation_of(shot, cycle, "posterior", priors={"t1": prior, "t2": prior}))
        assert set(ranking.worlds[0].present) == {"h1", "h2"}
        assert sum(w.probability for w in ranking.worlds if not w.present) < 1e-6


def test_d_without_the_cost_of_clutter_the_empty_world_would_win(hiding):
    """The trap itself: let clutter be as dense as hits, and a missed feature is all that is left to tell."""
    shot, cycle = hiding
    subject = situation_of(shot, cycle, "posterior")
    dense = tuple(replace(a, clutter=1e3) for a in subject.appearances)
    assert ranked_worlds(replace(subject, appearances=dense)).worlds[0].present == ()


def test_e_windows_are_no_noise(hiding):
    """Patches are the least distinctive type; where a tower expects one, it is the tower that causes it."""
    shot, cycle = hiding
    subject = situation_of(shot, replace(cycle, considered=()), "posterior")
    world = ranked_worlds(subject).worlds[0]
    kind = {a.id: a.type for a in subject.appearances}
    true_windows = [a for a in shot.causes if kind[a] == "patch"]
    assert len(true_windows) > 15
    noise = [a for a in true_windows if world.causes[a] == "noise"]
    assert len(noise) <= 0.1 * len(true_windows)
    assert min(perceiver().dv, key=perceiver().dv.get) == "patch"


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_e_dv_is_no_odds_of_cause_against_noise(reading, hiding):
    """In the posterior dv does not enter at all; in the score it weighs features, and never decides a cause."""
    shot, cycle = hiding
    subject = situation_of(shot, cycle, reading)
    flat = tuple(replace(h, features=tuple(replace(f, dv=0.5) for f in h.features)) for h in subject.hypotheses)
    before, after = ranked_worlds(subject, 1000), ranked_worlds(replace(subject, hypotheses=flat), 1000)
    causes = {w.present: w.causes for w in before.worlds}
    for world in after.worlds:
        assert causes[world.present] == world.causes
    if reading == "posterior":
        assert [w.probability for w in after.worlds] == [w.probability for w in before.worlds]


def test_f_what_is_behind_is_likelier_beside_what_hides_it(hiding):
    """P(t2 | t1) > P(t2 | not t1) in the score reading: worlds are not products of marginals."""
    shot, cycle = hiding
    subject = situation_of(shot, replace(cycle, considered=()), "score", smoothing=0.05)
    front = next(h.id for h in subject.hypotheses if h.type == "t1")
    back = next(h.id for h in subject.hypotheses if h.type == "t2")
    p = {w.present: w.probability for w in ranked_worlds(subject, 100).worlds}
    both, alone, only_front, neither = (p[key] for key in ((*sorted((front, back)),), (back,), (front,), ()))
    assert both / (both + only_front) > alone / (alone + neither)


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_g_a_thousand_pieces_of_clutter_do_not_underflow(reading):
    """The answer is what it is without the clutter that nobody claims."""
    rng = np.random.default_rng(8110)
    shot = scene(rng, {"t1": side_by_side(rng)["t1"]}, clutter=0)
    of = data(shot)
    cycle = replace(cycle_of(shot.gamma), accepted=(belief_at("t1", shot.poses["t1"], of),))
    subject = situation_of(shot, cycle, reading)
    many = tuple(replace(subject.appearances[0], id=f"c{i}", uv=(1.0, 1.0)) for i in range(1000))
    crowded = replace(subject, appearances=(*subject.appearances, *many))
    before, after = ranked_worlds(subject), ranked_worlds(crowded)
    assert after.marginals == before.marginals
    assert sum(w.probability for w in after.worlds) == pytest.approx(1.0)
    assert all(after.worlds[0].causes[f"c{i}"] == "noise" for i in range(1000))
