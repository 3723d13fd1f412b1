"""The factor graph weighs every joint state as the definitions do, one by one (§8)."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from enumeration import log_weights
from factor_graphs import log_weight
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation, towers

from plogic.inference.gates import Literal, observed
from plogic.inference.marginals import beliefs
from plogic.scene.factors.scene_graph import scene_graph

QUICK = settings(max_examples=200, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def by_graph(subject, **options):
    """Subset → log weight by the graph, auxiliary variables summed out by brute force.

    −inf for a subset that is no joint state.
    """
    scene = scene_graph(subject, **options)
    ids = [h.id for h in subject.hypotheses]
    logs = np.full(2 ** len(ids), -np.inf)
    hidden = [range(scene.graph.cards[v]) for v in scene.auxiliary]
    for states in product(*(range(len(v.states)) for v in scene.variables)):
        row = sum(1 << ids.index(name) for name in scene.present(states))
        logs[row] = np.logaddexp.reduce([log_weight(scene.graph, (*states, *rest)) for rest in product(*hidden)])
    return logs


def by_conditioning(subject):
    """As ``by_graph``, the sums over auxiliary variables by elimination: there may be many of them."""
    scene = scene_graph(subject)
    ids = [h.id for h in subject.hypotheses]
    logs = np.full(2 ** len(ids), -np.inf)
    for states in product(*(range(len(v.states)) for v in scene.variables)):
        held = observed(scene.graph, [Literal(v, frozenset({s})) for v, s in enumerate(states)])
        logs[sum(1 << ids.index(name) for name in scene.present(states))] = beliefs(held).log_z[0]
    return logs


def assert_equal(ours, theirs):
    finite = np.isfinite(theirs)
    assert (np.isfinite(ours) == finite).all(), "the same worlds are impossible"
    assert ours[finite] == pytest.approx(theirs[finite], abs=1e-9)


@QUICK
@given(random_situations())
def test_every_joint_state_weighs_what_the_definitions_say(subject):
    assert_equal(by_graph(subject), log_weights(subject))


@settings(QUICK, max_examples=60)
@given(random_situations(most=4, readings=("posterior",)))
def test_causes_as_variables_change_no_weight(subject):
    claimed = sorted({f.match for h in subject.hypotheses for f in h.features if f.match and h.expects(f)})[:2]
    assert set(scene_graph(subject, explicit=claimed).causes) == set(claimed)
    assert_equal(by_graph(subject, explicit=claimed), log_weights(subject))


@settings(QUICK, max_examples=60)
@given(random_situations(most=4))
def test_auxiliary_variables_change_no_weight(subject):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("plogic.scene.factors.weight_tables.WIDEST", 1)
        patch.setattr("plogic.scene.factors.score_factors.WIDEST", 0)
        assert_equal(by_conditioning(subject), log_weights(subject))


@settings(QUICK, max_examples=100)
@given(random_situations())
def test_arrays_weigh_what_lists_do(subject):
    with pytest.MonkeyPatch.context() as patch:
        for module in ("weight_tables", "posterior_factors", "score_factors"):
            patch.setattr(f"plogic.scene.factors.{module}.LONGEST_LIST", 1)
        assert_equal(by_graph(subject), log_weights(subject))


@settings(QUICK, max_examples=60)
@given(random_situations(), st.randoms(use_true_random=False))
def test_one_feature_changes_exactly_its_own_factor(subject, random):
    """What one feature's case is, only factors over its hypothesis' variable say.

    The others stay as they are, bit by bit.
    """
    h = random.choice(subject.hypotheses)
    k = random.randrange(len(h.features))
    changed = replace(h.features[k], hit_rate=0.61, dv=0.37, density=0.011)
    other = replace(h, features=tuple(changed if i == k else f for i, f in enumerate(h.features)))
    after = replace(subject, hypotheses=tuple(other if g.id == h.id else g for g in subject.hypotheses))
    before, now = scene_graph(subject), scene_graph(after)
    old = {f.scope: f.table for f in before.graph.factors}
    new = {f.scope: f.table for f in now.graph.factors}
    touched = {scope for scope in old.keys() | new.keys() if not np.array_equal(old.get(scope), new.get(scope))}
    if subject.reading == "posterior":
        allowed = {scope for scope in touched if before.place[h.id][0] in scope}
        claim = changed.match if h.expects(changed) else None
        rest = touched - allowed
        assert not rest or claim is not None
        assert len(touched) <= (1 if h.expects(changed) else 0)
    else:
        assert all(before.place[h.id][0] in scope for scope in touched)
        assert len(touched) <= 1


def test_rivals_for_one_instance_are_one_variable():
    towers_graph = scene_graph(towers("posterior"))
    assert [v.states for v in towers_graph.variables] == [(None, "t1"), (None, "t2", "t2_distorted")]
    assert [v.states for v in scene_graph(towers("score")).variables] == [(None, "t1"), (None, "t2", "t2_distorted")]


def test_a_lone_feature_weighs_its_closed_form():
    """For one claimant: E∧D, ln((h + f' − h f')/f') in shares; E∧¬D, ln(1 − h) (§8)."""
    subject = situation([hypothesis("h1", [feature("x", "A"), feature("y", "C")])], "posterior")
    logs = by_graph(subject)
    h, density, clutter = 0.8, 0.05, 2e-5
    prior = np.log(0.3 / 0.7)
    assert logs[1] - logs[0] == pytest.approx(
        prior + np.log((h * density + (1 - h) * clutter) / clutter) + np.log(1 - h)
    )


def test_no_hypothesis_is_an_empty_graph():
    assert log_weight(scene_graph(situation(())).graph, ()) == 0.0
