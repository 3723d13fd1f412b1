"""Δh as facts: what decides probabilities, from what geometry says (§8)."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from synthetic import belief_at, cycle_of, data, one_before_the_other, perceiver, scene, side_by_side, towers

from geometry.frames import from_rotation_translation
from plogic.cycle.delta import Options, delta_of
from plogic.facts.situation import pair_facts
from plogic.match.judged.expectation import hidden_by
from plogic.match.judged.rivals import SHARED_CLAIMS, overlap, shared_claims
from plogic.scene.worlds.ranked_worlds import ranked_worlds

READINGS = ("score", "posterior")


def delta_with(shot, rivals=(), reading="score"):
    """Δh of a scene, with further hypotheses considered beside what the cycle accepts."""
    cycle = cycle_of(shot.gamma)
    wider = replace(cycle, considered=(*cycle.considered, *rivals))
    return delta_of(wider, data(shot), towers(), perceiver().dv, Options(reading=reading))


def moved(pose, step):
    return pose @ from_rotation_translation(np.eye(3), step)


@pytest.fixture(scope="module")
def rich():
    """Two towers, one hiding a part of the other, and two rivals: a t1 in t2's place, and a shifted t2."""
    rng = np.random.default_rng(7300)
    shot = scene(rng, one_before_the_other(rng))
    of = data(shot)
    rivals = [
        belief_at("t1", shot.poses["t2"], of, "rival"),
        belief_at("t2", moved(shot.poses["t2"], [0.05, 0, 0]), of, "rival"),
    ]
    return shot, delta_with(shot, rivals)


def test_names_go_in_order_accepted_first(rich):
    _, delta = rich
    assert list(delta.beliefs) == ["h1", "h2", "h3", "h4"]
    assert [b.status for b in delta.beliefs.values()] == ["accepted", "accepted", "rival", "rival"]
    assert [h.id for h in delta.situation.hypotheses] == list(delta.beliefs)


def test_features_say_what_geometry_says(rich):
    shot, delta = rich
    ids = data(shot).ids
    assert delta.situation.hypotheses
    for h in delta.situation.hypotheses:
        posed = delta.beliefs[h.id]
        assert len(h.features) == len(posed.uv)
        for f, fact in enumerate(h.features):
            assert fact.in_image == posed.in_image[f]
            assert h.expects(fact) == posed.candidate[f]
            assert fact.match == (ids[posed.matches[f]] if posed.matches[f] >= 0 else None)
            assert (fact.residual is None) == (fact.match is None) == (fact.density == 0.0)
            assert fact.dv == perceiver().dv[fact.type]
            assert fact.hit_rate == towers().rates.hit[fact.type]


def test_hidden_by_names_exactly_those_before_the_feature(rich):
    _, delta = rich
    told = 0
    for h in delta.situation.hypotheses:
        for other, belief in delta.beliefs.items():
            if other != h.id:
                mask = hidden_by(delta.beliefs[h.id], belief)
                assert [other in f.hidden_by for f in h.features] == mask.tolist()
                told += mask.sum()
        assert all(h.id not in f.hidden_by for f in h.features)
    assert told > 0


def test_overlaps_exclusions_and_rivals_are_nested(rich):
    _, delta = rich
    situation = delta.situation
    pairs = list(combinations(delta.beliefs, 2))
    assert situation.overlaps == {p for p in pairs if overlap(delta.beliefs[p[0]], delta.beliefs[p[1]])}
    assert situation.overlaps <= situation.exclusive <= situation.rivals <= set(pairs)
    shares = {p: shared_claims(delta.beliefs[p[0]], delta.beliefs[p[1]])[1] for p in pairs}
    assert situation.exclusive == situation.overlaps | {p for p in pairs if shares[p] > SHARED_CLAIMS}
    assert situation.rivals == situation.exclusive | {p for p in pairs if shares[p] > 0}
    assert len(situation.overlaps) == 3, "the three hypotheses in t2's place"


def test_groups_are_rivals_of_one_type_for_one_instance(rich):
    _, delta = rich
    group = {h.id: h.group for h in delta.situation.hypotheses}
    place = {name: (b.object_type.name, name in ("h3", "h4")) for name, b in delta.beliefs.items()}
    true_t2 = next(name for name, (kind, rival) in place.items() if kind == "t2" and not rival)
    assert group[true_t2] == group["h4"]
    assert len(set(group.values())) == 3


def test_every_pair_that_can_be_together_has_one_relation(rich):
    _, delta = rich
    situation = delta.situation
    for pair in combinations(delta.beliefs, 2):
        facts = [r for r in situation.relations if {r.x, r.y} == set(pair)]
        assert len({r.relation for r in facts}) == (0 if pair in situation.exclusive else 1)
    front = next(name for name, b in delta.beliefs.items() if b.object_type.name == "t1" and b.status == "accepted")
    back = next(name for name, b in delta.beliefs.items() if b.object_type.name == "t2" and b.status == "accepted")
    assert ("partially_occludes", front, back) in {(r.relation, r.x, r.y) for r in situation.relations}


@pytest.mark.parametrize(
    ("relation", "facts"),
    [
        (
            "non_occludes_ec",
            [("non_occludes", "x", "y", "non_occludes_ec"), ("non_occludes", "y", "x", "non_occludes_ec")],
        ),
        (
            "mutually_occludes_tpp",
            [
                ("mutually_occludes", "x", "y", "mutually_occludes_tpp"),
                ("mutually_occludes", "y", "x", "mutually_occludes_tppi"),
            ],
        ),
        ("partially_occludes_tpp", [("partially_occludes", "x", "y", "partially_occludes_tpp")]),
        ("partially_occluded_by_tppi", [("partially_occludes", "y", "x", "partially_occludes_tpp")]),
        ("totally_occludes_ntppi", [("totally_occludes", "x", "y", "totally_occludes_ntppi")]),
        ("totally_occluded_by_ntpp", [("totally_occludes", "y", "x", "totally_occludes_ntppi")]),
    ],
)
def test_relations_are_said_of_the_pair_that_they_hold_of(relation, facts):
    assert [(f.relation, f.x, f.y, f.roc) for f in pair_facts(relation, "x", "y")] == facts


def test_appearances_and_side_tables_are_carried(rich):
    shot, delta = rich
    situation = delta.situation
    assert [a.id for a in situation.appearances] == [a.id for a in shot.gamma.appearances]
    assert all(a.clutter == towers().rates.clutter[a.type] / 307200 for a in situation.appearances)
    assert situation.priors == {"t1": 0.5, "t2": 0.5}
    assert situation.dv == perceiver().dv
    assert set(situation.rank) == {"t1", "t2"}


@pytest.mark.parametrize("reading", READINGS)
def test_the_true_pair_is_the_best_world_among_rivals(reading, rich):
    shot, delta = rich
    ranking = ranked_worlds(replace(delta.situation, reading=reading))
    assert set(ranking.worlds[0].present) == {"h1", "h2"}
    assert shot.poses.keys() == {delta.beliefs[h].object_type.name for h in ranking.worlds[0].present}


def test_an_empty_delta_is_the_empty_situation():
    shot = scene(np.random.default_rng(7310), {}, clutter=3)
    delta = delta_with(shot)
    assert delta.beliefs == {}
    assert delta.situation.hypotheses == ()
    assert len(delta.situation.appearances) == 3
    assert [w.present for w in ranked_worlds(delta.situation).worlds] == [()]


def test_apart_the_two_presences_are_independent():
    rng = np.random.default_rng(7311)
    shot = scene(rng, side_by_side(rng))
    ranking = ranked_worlds(delta_with(shot).situation)
    p, q = ranking.marginals["h1"], ranking.marginals["h2"]
    both = next(w.probability for w in ranking.worlds if len(w.present) == 2)
    assert both == pytest.approx(p * q)
