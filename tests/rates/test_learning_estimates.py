"""Counts where everything is observed; EM, held to an EM of the definition, where not."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kb.clouds.cloud import Counts, Rates
from plogic.rates.estimates import added, counted, expected_counts, learned, mean, open_slots, presence, share
from plogic.rates.scene_records import Record, Sighting, Slot

QUICK = settings(max_examples=100, deadline=None, derandomize=True)
RATES = Rates(hit={"apex": 0.9, "corner": 0.7}, clutter={"l": 8.0}, prior={"t1": 0.5, "t2": 0.5})


def slot(near, present=None, kind="t1", feature="corner", chance=0.01):
    return Slot(kind, present, tuple(Sighting(feature, near=flag, chance=chance) for flag in near))


def test_counts_of_a_complete_scene():
    first = Record((slot([True, True, False], present=True), Slot("t2", present=False)), {"l": 7})
    second = Record((slot([True], present=True, feature="apex"), slot([False], present=True, kind="t2")), {"l": 2})
    counts = counted([first, second])
    assert counts.hit == {"apex": (1, 1), "corner": (2, 4)}
    assert counts.clutter == {"l": (9, 2)}
    assert counts.prior == {"t1": (2, 2), "t2": (1, 2)}


def test_a_scene_that_is_not_complete_says_nothing_of_clutter():
    record = Record((slot([True]), slot([True], present=True)), None)
    assert counted([record]) == Counts(hit={"corner": (1, 1)}, prior={"t1": (1, 1)})
    assert open_slots([record]) == [slot([True])]


def test_rates_of_what_was_never_seen_stay():
    rates = learned(Counts(hit={"corner": (8, 8)}, prior={"t1": (0, 3)}), RATES)
    assert rates.hit == {"apex": 0.9, "corner": 0.9}
    assert rates.prior == {"t1": 0.2, "t2": 0.5}
    assert rates.clutter == RATES.clutter


@QUICK
@given(st.integers(0, 1000), st.integers(0, 1000))
def test_no_rate_is_ever_certain(n, more):
    assert 0 < share((n, n + more)) < 1
    assert mean((n, max(more, 1))) > 0


PAIRS = st.dictionaries(
    st.sampled_from(["x", "y"]), st.tuples(st.integers(0, 9).map(float), st.integers(9, 20).map(float))
)
COUNTS = st.builds(Counts, hit=PAIRS, clutter=PAIRS, prior=PAIRS)


@QUICK
@given(COUNTS, COUNTS)
def test_counts_add_in_any_order(one, other):
    assert added(one, other) == added(other, one)
    assert added(one, Counts()) == added(one)


def em_by_definition(slots, observed, start):
    """E: P(present | sightings) and P(hit | near, present) of each slot; M: the shares of the sums.

    Until nothing changes.
    """
    hit = {name: start.hit[name] for s in slots for name in {x.feature_type for x in s.sightings}}
    prior = {s.object_type: start.prior[s.object_type] for s in slots}
    for _ in range(20000):
        sums = {("hit", n): list(observed.hit.get(n, (0, 0))) for n in hit} | {
            ("prior", n): list(observed.prior.get(n, (0, 0))) for n in prior
        }
        for s in slots:
            there, absent = prior[s.object_type], 1 - prior[s.object_type]
            for x in s.sightings:
                near = 1 - (1 - hit[x.feature_type]) * (1 - x.chance)
                there *= near if x.near else 1 - near
                absent *= x.chance if x.near else 1 - x.chance
            p = there / (there + absent)
            sums["prior", s.object_type][0] += p
            sums["prior", s.object_type][1] += 1
            for x in s.sightings:
                near = 1 - (1 - hit[x.feature_type]) * (1 - x.chance)
                sums["hit", x.feature_type][0] += p * (hit[x.feature_type] / near if x.near else 0)
                sums["hit", x.feature_type][1] += p
        old = {**hit, **prior}
        hit = {n: sums["hit", n][0] / sums["hit", n][1] for n in hit}
        prior = {n: sums["prior", n][0] / sums["prior", n][1] for n in prior}
        if max(abs(v - old[n]) for n, v in {**hit, **prior}.items()) < 1e-10:
            break
    return hit, prior, sums


def test_lfi_reaches_the_maximum_of_em_by_definition():
    """Three open slots (two that look present, one that does not) beside observed ones."""
    slots = [slot([True, True, True, False]), slot([True, True, False, True]), slot([False] * 4)]
    observed = Counts(hit={"corner": (16.0, 20.0)}, prior={"t1": (4.0, 6.0)})
    hit, prior, _ = em_by_definition(slots, observed, RATES)
    counts = expected_counts(slots, observed, RATES)
    assert counts.hit["corner"][0] / counts.hit["corner"][1] == pytest.approx(hit["corner"], abs=1e-3)
    assert counts.prior["t1"][0] / counts.prior["t1"][1] == pytest.approx(prior["t1"], abs=1e-3)
    assert counts.prior["t1"] == pytest.approx((6.0, 9.0), abs=0.01), (
        "two of the three open slots are taken for present"
    )


def test_em_without_open_slots_is_counting():
    observed = Counts(hit={"corner": (3.0, 4.0)})
    assert expected_counts([], observed, RATES) is observed


@QUICK
@given(st.lists(st.booleans(), max_size=8), st.floats(0.05, 0.95), st.floats(0.05, 0.95), st.floats(0.001, 0.2))
def test_presence_is_bayes_rule(near, h, p, chance):
    got = presence(slot(near, chance=chance), {"corner": h}, {"t1": p})
    there = p * math.prod((1 - (1 - h) * (1 - chance)) if n else (1 - h) * (1 - chance) for n in near)
    absent = (1 - p) * math.prod(chance if n else 1 - chance for n in near)
    assert got == pytest.approx(there / (there + absent), abs=1e-12)
