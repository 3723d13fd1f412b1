"""Cyclic occlusion beside rivals (§8, trap f): the joint states are those that Σc allows, and then they are normalised.

The oracle enumerates Σc's worlds by the words of §4 and §5, and nothing else of ours.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from random import Random

import pytest
from situations import feature, hypothesis, situation
from stock_worlds import assert_same_worlds

from plogic.cycle.delta import Delta
from plogic.facts.dependence import Scene, dependence
from plogic.run.perceive import SMOOTHED, ranked
from plogic.scene.worlds.ranked_worlds import ranked_worlds


def planks(rival_ev_cells="AAAC", mode="to_B"):
    """Three planks that hide each other in a ring, each all that is detected of it; one has a worse rival."""
    names = ["h0", "h1", "h2"]
    ring = [
        hypothesis(
            name,
            [
                *(feature(f"x{j}", match=f"{name}_{j}") for j in range(6)),
                *(feature(f"y{j}", "C", hidden_by=(names[i - 1], *(["r"] if i == 1 else []))) for j in range(3)),
            ],
        )
        for i, name in enumerate(names)
    ]
    theirs = [
        feature(f"x{j}", case, match=f"h0_{j}" if case in "AD" else None) for j, case in enumerate(rival_ev_cells)
    ]
    rival = hypothesis("r", [*theirs, feature("y", "C", hidden_by=("h2",))], group="g_h0")
    pair = frozenset({("h0", "r")})
    return situation([*ring, rival], mode=mode, overlaps=pair, rivals=pair)


@pytest.mark.parametrize("mode", ["to_B", "drop", "reassign"])
def test_planks_in_a_ring_are_present_beside_a_rival(mode):
    """Every datum is explained by the ring, each of which has ev 1 there: the ring is by far the most probable."""
    subject = planks(mode=mode)
    ranking = assert_same_worlds(subject)
    assert ranking.worlds[0].present == ("h0", "h1", "h2")
    assert ranking.worlds[0].probability > 0.5
    assert all(not {"h0", "r"} <= set(world.present) for world in ranking.worlds)


def test_what_two_certain_rivals_leave_of_a_ring_is_decided_by_smoothing_and_said():
    """Both have ev 1 in the ring: nothing but the empty world is stable, which is no evidence that nothing is there."""
    subject = planks("AAAAAA")
    assert ranked_worlds(subject).marginals == dict.fromkeys(("h0", "h1", "h2", "r"), 0.0)
    trace = []
    smoothed, ranking = ranked(accepted(subject), trace)
    assert [(step["event"], step["hypothesis"]) for step in trace] == [("smooth", None)]
    assert smoothed.situation.smoothing == SMOOTHED
    assert all(0.05 < p < 0.95 for p in ranking.marginals.values()), ranking.marginals
    assert_same_worlds(smoothed.situation)


def test_what_is_accepted_with_probability_0_is_said():
    """One of ev 0.6 that a certain one excludes from every world, beside another that is accepted."""
    doubtful = hypothesis("h1", [feature(f"x{j}", "AAAAC"[j], match=f"a{j}" if j < 4 else None) for j in range(5)])
    certain = hypothesis("h2", [feature(f"x{j}", match=f"a{j}") for j in range(4)])
    other = hypothesis("h3", [feature("x")])
    pair = frozenset({("h1", "h2")})
    trace = []
    _, ranking = ranked(accepted(situation([doubtful, certain, other], overlaps=pair, rivals=pair)), trace)
    assert ranking.marginals == {"h1": 0.0, "h2": 1.0, "h3": 1.0}
    assert [(step["event"], step["hypothesis"], step["type"]) for step in trace] == [("impossible", "h1", "box")]


def accepted(subject):
    """All but rivals."""
    status = {h.id: "rival" if h.id == "r" else "accepted" for h in subject.hypotheses}
    told = tuple(replace(h, status=status[h.id]) for h in subject.hypotheses)
    return Delta(replace(subject, hypotheses=told), subject.dv)


def ring_with_rivals(rng):
    """Three or four that hide each other in a ring, one or two with a rival that hides and is hidden as they are."""
    names = [f"h{i}" for i in range(rng.randint(3, 4))]
    rivals = {f"r{i}": name for i, name in enumerate(rng.sample(names, rng.randint(1, 2)))}
    places = {name: [name, *(r for r, of in rivals.items() if of == name)] for name in names}

    def features(me):
        before = rng.sample(places[names[names.index(me) - 1]], 1)
        more = rng.sample([g for g in (*names, *rivals) if me not in (g, rivals.get(g))], 1)
        cases = ["A", rng.choice("ACD"), rng.choice("ACBD")]
        plain = [feature(f"x{j}", case, dv=rng.choice([0.15, 0.5, 0.86])) for j, case in enumerate(cases)]
        hidden = [
            feature("y", "C", dv=rng.choice([0.5, 0.9]), hidden_by=tuple(before)),
            feature("z", rng.choice("AC"), dv=rng.choice([0.2, 0.7]), hidden_by=tuple(more)),
        ]
        return [*plain, *hidden]

    known = [hypothesis(name, own_data(name, features(name)), group=f"g{i}") for i, name in enumerate(names)]
    known += [hypothesis(r, own_data(r, features(of)), group=f"g{names.index(of)}") for r, of in rivals.items()]
    pairs = frozenset((of, r) for r, of in rivals.items())
    return situation(known, overlaps=pairs, rivals=pairs)


def own_data(name, features):
    return [replace(f, match=f"{name}_{f.id}") if f.match else f for f in features]


def by_brute_force(subject):
    """World → its probability: Π P(ev) of who is present, Π 1 − P(ev) of who is not, over the worlds without rivals."""
    names = [h.id for h in subject.hypotheses]
    clash = [set(pair) for pair in subject.overlaps]
    weights = {}
    for world in (set(w) for n in range(len(names) + 1) for w in combinations(names, n)):
        if not any(pair <= world for pair in clash):
            chances = [
                p_ev(subject, h, world) if h.id in world else 1 - p_ev(subject, h, world) for h in subject.hypotheses
            ]
            weights[frozenset(world)] = math.prod(chances)
    total = math.fsum(weights.values())
    return {world: w / total for world, w in weights.items()}


def p_ev(subject, h, world):
    """§5.4 and §5.5, `to_B`: the share of dv of cases A and B among what is in the image."""
    rivals = {x for pair in subject.rivals for x in pair if h.id in pair}
    good = total = 0.0
    for f in (f for f in h.features if f.in_image):
        hidden = any(g in world and g not in rivals for g in f.hidden_by)
        expected = f.in_lobe and not f.self_hidden and not hidden
        good += f.dv * (expected == (f.match is not None))
        total += f.dv
    return good / total


def test_two_hundred_random_rings_equal_brute_force():
    joint = 0
    for seed in range(400):
        subject = ring_with_rivals(Random(seed))  # noqa: S311 - a test's
        if len(dependence(Scene(subject)).blocks) > 1:
            continue
        joint += 1
        ours = {frozenset(w.present): w.probability for w in ranked_worlds(subject, 10**6).worlds}
        theirs = by_brute_force(subject)
        assert {w: ours.get(w, 0.0) for w in theirs} == pytest.approx(theirs, abs=1e-9), seed
    assert joint >= 200
