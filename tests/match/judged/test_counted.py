"""How much of an observation each expected feature counts, and what the program is told of it, each by a loop."""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp, log, pi, sin

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready
from synthetic import camera_pose, data, posed_at, scene, towers

from plogic.match.judged.evidence import as_counted, clutter_density, hit_rates, match_density
from plogic.measures.crowding import ALONG, BENT, CROWDED

COUNT = 30
CROWDS = st.tuples(st.integers(0, 9999), st.sampled_from([0.0, 1.0, 4.0, 12.0, 60.0]))


def crowded(seed, spread, found=20):
    """A hypothesis whose features stand within so many pixels of each other, some of them not expected, some found."""
    rng = np.random.default_rng(seed)
    thing, pose = ready(one_sided(1, COUNT)), pose_before(np.random.default_rng(5))
    of = gamma_at(thing.cloud, range(found), pose)
    of.uv[:] += rng.normal(0, 0.3, of.uv.shape)
    posed = thing.index.settle(pose, of, thing.kb, rounds=0)
    uv = np.array([320.0, 240.0]) + rng.uniform(-spread, spread, (COUNT, 2))
    turn = rng.choice([0.3, 1.7], COUNT) + rng.choice([0.0, pi], COUNT) + rng.normal(0, 0.15, COUNT)
    return replace(posed, uv=uv, turn=turn, in_lobe=rng.random(COUNT) < 0.8), of, thing.kb


def together(posed, i, j):
    """How much two features go with each other: as near in the image, or along one edge that both lie on."""
    apart = posed.uv[j] - posed.uv[i]
    if np.linalg.norm(apart) > 3 * max(CROWDED, ALONG):
        return 0.0
    bent = (posed.turn[j] - posed.turn[i] + pi / 2) % pi - pi / 2
    mean = posed.turn[i] + bent / 2
    across = apart @ [cos(mean), sin(mean)]
    along = apart @ [-sin(mean), cos(mean)]
    crowd = exp(-0.5 * (apart @ apart) / CROWDED**2)
    return max(crowd, exp(-0.5 * ((across / CROWDED) ** 2 + (along / ALONG) ** 2 + (bent / BENT) ** 2)))


def by_loop(posed):
    shares, expected = np.ones(len(posed.uv)), np.flatnonzero(posed.candidate)
    for i in expected:
        shares[i] = 1.0 / (1.0 + sum(together(posed, min(i, j), max(i, j)) for j in expected if j != i))
    return shares.tolist()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(CROWDS)
def test_shares_are_one_over_the_crowd(how):
    posed, _, _ = crowded(*how)
    shares = posed.counted
    assert shares.tolist() == pytest.approx(by_loop(posed))
    assert ((shares > 0) & (shares <= 1)).all()
    assert (shares[~posed.candidate] == 1).all()


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(1, COUNT))
def test_copies_at_one_place_count_one_together_and_one_alone_counts_one(copies):
    posed, _, _ = crowded(0, 1.0)
    uv = np.column_stack([50.0 * np.arange(COUNT), np.full(COUNT, 100.0)])
    uv[:copies] = uv[0]
    shares = replace(posed, uv=uv, in_lobe=np.ones(COUNT, bool), in_image=np.ones(COUNT, bool)).counted
    assert shares[:copies].sum() == pytest.approx(1.0)
    assert shares[copies:].tolist() == [1.0] * (COUNT - copies)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(CROWDS, st.floats(-200, 200), st.floats(-3, 3), st.integers(0, COUNT - 1))
def test_moving_and_turning_the_picture_changes_nothing_and_company_never_adds(how, shift, roll, away):
    posed, _, _ = crowded(*how)
    c, s = cos(roll), sin(roll)
    moved = replace(
        posed, uv=posed.uv @ np.array([[c, s], [-s, c]]) + shift, turn=posed.turn + roll, in_image=np.ones(COUNT, bool)
    )
    posed = replace(posed, in_image=np.ones(COUNT, bool))
    assert moved.counted.tolist() == pytest.approx(posed.counted.tolist())
    alone = replace(posed, in_lobe=posed.in_lobe & (np.arange(COUNT) != away))
    rest = np.arange(COUNT) != away
    assert (alone.counted[rest] >= posed.counted[rest] * (1 - 1e-12)).all()  # sums in another order


@settings(max_examples=30, deadline=None, derandomize=True, phases=[Phase.generate])
@given(CROWDS, st.permutations(range(COUNT)))
def test_the_order_of_features_changes_nothing(how, order):
    posed, _, _ = crowded(*how)
    arrays = {name: getattr(posed, name)[order] for name in ("uv", "turn", "in_image", "in_lobe", "self_hidden")}
    assert replace(posed, **arrays).counted.tolist() == pytest.approx(posed.counted[order].tolist())


@pytest.mark.parametrize(("turn", "share"), [(0.0, 1.0), (pi / 2, 1 / (1 + exp(-0.5))), (-pi / 2, 1 / (1 + exp(-0.5)))])
def test_two_along_one_edge_go_together_and_two_abreast_do_not(turn, share):
    """Ten pixels apart along +u, both turned alike: together only where the gradient points across that."""
    posed, _, _ = crowded(0, 1.0)
    uv = np.array([[100.0, 100.0], [100.0 + ALONG, 100.0]])
    two = np.arange(COUNT) < 2
    posed = replace(
        posed,
        uv=np.where(two[:, None], uv[np.minimum(np.arange(COUNT), 1)], 300.0),
        turn=np.full(COUNT, turn),
        in_lobe=two,
    )
    assert posed.counted[:2] == pytest.approx([share, share], abs=0.01)


def test_types_written_by_hand_count_in_full_and_are_told_as_they_are():
    rng = np.random.default_rng(3)
    pose = camera_pose(rng, (8.0, 9.0))  # far off: features crowd
    of = data(scene(rng, {"t1": pose}))
    posed = posed_at("t1", pose, of)
    assert posed.candidate.sum() > 10
    assert posed.counted.tolist() == [1.0] * len(posed.uv)
    hit, near = as_counted(posed, of, towers())
    assert hit.tolist() == hit_rates(posed, towers()).tolist()
    assert near.tolist() == match_density(posed, towers()).tolist()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(CROWDS, st.integers(0, COUNT), st.integers(0, 2**COUNT - 1))
def test_what_the_program_is_told_says_as_much_as_is_counted(how, found, bits):
    """With its h' and N' the formulas of §8 give the power w of what a match, and of what a miss, says."""
    posed, of, kb = crowded(*how, found)
    hidden = np.array([bits >> f & 1 for f in range(COUNT)], bool)
    rates, near, shares = hit_rates(posed, kb, hidden), match_density(posed, kb), posed.counted
    told, dense = as_counted(posed, of, kb, hidden)
    clutter = clutter_density(kb, of)
    assert ((told > 0) & (told <= rates + 1e-15)).all()
    assert (dense >= 0).all()
    for f in range(COUNT):
        assert log(1 - told[f]) == pytest.approx(shares[f] * log(1 - rates[f]))
        if posed.matches[f] < 0:
            assert dense[f] == 0.0
            continue
        noise = clutter[posed.matches[f]]
        says = log((told[f] * dense[f] + (1 - told[f]) * noise) / noise)
        assert says == pytest.approx(shares[f] * log((rates[f] * near[f] + (1 - rates[f]) * noise) / noise), abs=1e-9)


def test_nothing_is_changed_in_place():
    posed, of, kb = crowded(0, 4.0)
    before = {name: getattr(posed, name).copy() for name in ("hit", "sigma", "likeness", "residual", "uv")}
    one, other = as_counted(posed, of, kb), as_counted(posed, of, kb)
    assert [some.tolist() for some in one] == [some.tolist() for some in other]
    for name, values in before.items():
        np.testing.assert_array_equal(getattr(posed, name), values)
