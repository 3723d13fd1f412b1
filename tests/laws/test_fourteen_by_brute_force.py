"""Up to 14 hypotheses: every world, in order, against the weights of all subsets.

And what excludes each other is never listed together.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from crowds import crowd
from enumeration import log_weights
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import random_situations
from stopping import LONG, stopped

from plogic.base.errors import InconsistentError
from plogic.scene.asking.live import LiveScene
from plogic.scene.factors.scene_graph import scene_graph
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
KINDS = [("score", "to_B"), ("score", "drop"), ("score", "reassign"), ("posterior", "to_B")]


def expected(subject):
    """(log evidence, P of every subset with bit i for the i-th hypothesis)."""
    logs = log_weights(subject)
    evidence = float(np.logaddexp.reduce(logs))
    return evidence, np.exp(logs - evidence)


@pytest.mark.parametrize(("reading", "mode"), KINDS)
@pytest.mark.parametrize("count", [11, 14])
@pytest.mark.parametrize("seed", range(3))
def test_all_worlds_and_marginals(reading, mode, count, seed):
    subject = crowd(count, seed, reading, mode)
    evidence, chances = expected(subject)
    ranking = ranked_worlds(subject, 2**count)
    assert ranking.log_evidence == pytest.approx(evidence, abs=1e-9)
    bit = {h.id: 1 << i for i, h in enumerate(subject.hypotheses)}
    ours = np.zeros(len(chances))
    for w in ranking.worlds:
        ours[sum(bit[name] for name in w.present)] += w.probability
    assert len(ranking.worlds) == np.count_nonzero(np.isfinite(log_weights(subject)))
    np.testing.assert_allclose(ours, chances, atol=1e-9)
    assert all(a.probability >= b.probability * (1 - 1e-9) for a, b in pairwise(ranking.worlds))
    for name, p in ranking.marginals.items():
        assert p == pytest.approx(float(chances[np.arange(len(chances)) & bit[name] > 0].sum()), abs=1e-9)
        assert p == pytest.approx(math.fsum(w.probability for w in ranking.worlds if name in w.present), abs=1e-9)


def test_the_crowds_have_what_they_are_to_test():
    """Components of several hypotheses, more than one of them; groups of rivals; pairs of every kind."""
    for seed in range(3):
        subject = crowd(14, seed)
        graph = scene_graph(subject)
        assert subject.overlaps
        assert subject.exclusive
        assert subject.rivals > subject.exclusive
        assert max(len(v.states) for v in graph.variables) >= 3
        assert max(len(f.scope) for f in graph.graph.factors) >= 3
        assert any(len(set(f.hidden_by)) > 1 for h in subject.hypotheses for f in h.features)


def assert_never_together(subject, worlds):
    pairs = subject.overlaps | (subject.exclusive if subject.reading == "score" else frozenset())
    same = [
        (g.id, h.id) for i, g in enumerate(subject.hypotheses) for h in subject.hypotheses[:i] if g.group == h.group
    ]
    assert worlds
    for w in worlds:
        assert not any(
            x in w.present and y in w.present for x, y in (*pairs, *(same if subject.reading == "posterior" else ()))
        )


@QUICK
@given(random_situations(), st.integers(0, 12))
def test_what_excludes_each_other_is_never_listed_together(subject, checks):
    """A4 in both readings, shared data in the score reading, one instance in the posterior reading.

    At any deadline, too.
    """
    try:
        worlds = ranked_worlds(subject, 10**6).worlds
    except InconsistentError:
        return
    assert worlds
    assert_never_together(subject, worlds)
    with stopped(checks, 1.0):
        assert_never_together(subject, ranked_worlds(subject, 10**6, seconds=LONG).worlds)
        assert_never_together(subject, LiveScene(subject).worlds(10**6, seconds=LONG).worlds)


@QUICK
@given(random_situations(readings=("posterior",)))
def test_rivals_for_one_instance_are_one_variable_of_the_graph(subject):
    """Not a clique of binary ones: the variables are the groups, and nothing else of the scene is one."""
    groups = {}
    for h in subject.hypotheses:
        groups.setdefault(h.group, []).append(h.id)
    graph = scene_graph(subject)
    assert [v.states for v in graph.variables] == [(None, *members) for members in groups.values()]
    assert graph.graph.cards == tuple(1 + len(members) for members in groups.values())


@QUICK
@given(random_situations(readings=("score",)))
def test_in_the_score_reading_what_excludes_each_other_in_a_group_is_one_variable(subject):
    apart = {frozenset(pair) for pair in subject.overlaps | subject.exclusive}
    group = {h.id: h.group for h in subject.hypotheses}
    states = [v.states[1:] for v in scene_graph(subject).variables]
    assert sorted(name for members in states for name in members) == sorted(group)
    for members in states:
        assert len({group[name] for name in members}) == 1
        assert all(frozenset((x, y)) in apart for i, x in enumerate(members) for y in members[:i])
    clique = replace(subject, overlaps=frozenset((x, y) for x in group for y in group if x < y))
    assert len(scene_graph(clique).variables) == len(set(group.values()))
