"""A second oracle: every total choice of the Independent Choice Logic, one by one, by the words of §4 and §8."""

from __future__ import annotations

import math
from collections import defaultdict
from itertools import product

import pytest
from hypothesis import HealthCheck, assume, given, settings
from situations import random_situations

from plogic.facts.dependence import Scene, dependence
from plogic.scene.worlds.ranked_worlds import ranked_worlds

TINY = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def is_rival(subject, x, y):
    return (x, y) in subject.rivals or (y, x) in subject.rivals


def sees(subject, h, f, world):
    """D7 in words."""
    if not (f.in_image and f.in_lobe) or (f.self_hidden and h.opaque):
        return False
    return not any(
        g.id in f.hidden_by and g.id != h.id and g.opaque and not is_rival(subject, g.id, h.id) for g in world
    )


def allowed(subject, world, pairs):
    names = {h.id for h in world}
    return not any(x in names and y in names for x, y in pairs)


def normalised(weights):
    total = math.fsum(weights.values())
    assume(total > 0)
    return {world: w / total for world, w in weights.items() if w > 0}


def score_by_choices(subject):
    """Sum over all picks: a hypothesis is present iff its pick is concordant, its occluders decided before."""
    scene = Scene(subject)
    order = front_to_back(dependence(scene))
    picks = {h.id: [(f, f.dv) for f in h.features if f.in_image and f.dv > 0] for h in subject.hypotheses}
    weights = defaultdict(float)
    for choice in product(*(picks[h] or [(None, 1.0)] for h in order)):
        weight = math.prod(
            dv / math.fsum(v for _, v in picks[h] or [(None, 1.0)]) for h, (_, dv) in zip(order, choice, strict=True)
        )
        world = []
        for name, (f, _) in zip(order, choice, strict=True):
            h = scene.by_id[name]
            supported = any(e.match is not None and e.in_image for e in h.features)
            if f is not None and supported and sees(subject, h, f, world) == (f.match is not None):
                world.append(h)
        if allowed(subject, world, subject.overlaps | subject.exclusive):
            weights[frozenset(h.id for h in world)] += weight
    return normalised(weights)


def front_to_back(graph):
    assume(all(len(block) == 1 for block in graph.blocks))
    order = []
    while len(order) < len(graph.of):
        order += [h for h, gs in graph.of.items() if h not in order and all(g in order for g in gs)]
    return order


def posterior_by_choices(subject):
    """Sum over worlds, hits and causes.

    Every appearance is explained by exactly one cause, every hit needs its appearance.
    """
    groups = defaultdict(list)
    for h in subject.hypotheses:
        groups[h.group].append(h)
    weights = defaultdict(float)
    for choice in product(*([None, *members] for members in groups.values())):
        world = [h for h in choice if h is not None]
        prior = 1.0
        for chosen, members in zip(choice, groups.values(), strict=True):
            shares = [subject.priors.get(h.type, 0.5) / len(members) for h in members]
            prior *= 1 - math.fsum(shares) if chosen is None else shares[members.index(chosen)]
        if allowed(subject, world, subject.overlaps):
            weights[frozenset(h.id for h in world)] += prior * likelihood(subject, world)
    return normalised(weights)


def likelihood(subject, world):
    expected = [(h, f) for h in world for f in h.features if sees(subject, h, f, world)]
    clutter = {a.id: a.clutter for a in subject.appearances}
    total = 0.0
    for hits in product((False, True), repeat=len(expected)):
        weight = math.prod(f.hit_rate if hit else 1 - f.hit_rate for (_, f), hit in zip(expected, hits, strict=True))
        sources = defaultdict(list)
        for (_, f), hit in zip(expected, hits, strict=True):
            if hit:
                sources[f.match].append(f.density)
        if None in sources or any(len(fs) > 1 for fs in sources.values()):
            continue
        total += weight * math.prod(sources[a][0] if sources.get(a) else density for a, density in clutter.items())
    return total


def assert_same(subject, theirs):
    ours = {frozenset(w.present): w.probability for w in ranked_worlds(subject, 10**6).worlds}
    assert theirs
    for world, p in theirs.items():
        assert ours.get(world, 0.0) == pytest.approx(p, abs=1e-7), world


@TINY
@given(random_situations(most=3, readings=("score",), modes=("to_B",)))
def test_score_reading(subject):
    assume(subject.smoothing == 0)
    assert_same(subject, score_by_choices(subject))


@TINY
@given(random_situations(most=3, readings=("posterior",)))
def test_posterior_reading(subject):
    assert_same(subject, posterior_by_choices(subject))
