"""Pairs of keypoints and appearances: their weights and which are kept by a loop, their order by turns."""

from __future__ import annotations

from dataclasses import replace
from math import exp, floor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, pose_before, ready
from random_cloud import random_cloud

from plogic.match.learned import keypoints as pairs_module
from plogic.match.learned.keypoints import CELL, CLOSE, EACH, FARTHEST, FARTHEST_BITS, NTH, OFF, pairs_of
from plogic.match.learned.keypoints import spread as spread_out
from sensing.detectors.keypoint_detector import fairly

FIELDS = ("datum", "lobe", "weight")


def spoilt(rng, descriptors):
    """The same with some noise: a few bits of 32 bytes, some grey levels of 128."""
    if descriptors.shape[1] == 32:
        return descriptors ^ np.packbits(rng.random((len(descriptors), 256)) < 0.1, axis=1)
    return np.clip(descriptors + rng.normal(0, 15, descriptors.shape), 0, 255).astype(np.uint8)


def crowd(seed, width=128, seen=6):
    """A type whose appearances look like one of four things, and keypoints of it; one has no descriptor."""
    rng = np.random.default_rng(seed)
    base = rng.integers(0, 256, (4, width), np.uint8)
    cloud = random_cloud(seed, 9, 20, width=width, descriptor=spoilt(rng, base[rng.integers(0, 4, 20)]))
    data = gamma_at(cloud, rng.integers(0, 20, seen), pose_before(rng))
    data.uv[:] = rng.uniform(-0.5, [639, 479], (seen, 2))
    data.described[2] = False
    return ready(cloud), replace(data, descriptors=spoilt(rng, data.descriptors))


def weight_of(apart, place):
    """As the odds that a pair is right.

    Less the farther apart, and the more keypoints look more like the appearance.
    """
    return exp(-0.5 * (max(apart - CLOSE, 0.0) / OFF) ** 2) / (1 + place) ** 1.5


def kept_by_loop(thing, data):
    """{(datum, lobe): weight} of the pairs that are kept."""
    cloud = thing.cloud
    wide = spread_out(data.descriptors).astype(float)[:, None] - spread_out(cloud.descriptor)[None]
    limit = FARTHEST_BITS if wide.shape[2] == 256 else FARTHEST
    apart = np.linalg.norm(wide, axis=2) * FARTHEST / limit
    weights = {}
    for lobe in range(len(cloud.feature)):
        near = [d for d in range(len(data.ids)) if data.described[d] and apart[d, lobe] < FARTHEST]
        for place, d in enumerate(sorted(near, key=lambda d: apart[d, lobe])[:NTH]):
            weights[d, lobe] = weight_of(apart[d, lobe], place)
    kept = {}
    for d in range(len(data.ids)):
        best = {}
        for lobe in (lobe for e, lobe in weights if e == d):
            feature = int(cloud.feature[lobe])
            if feature not in best or weights[d, lobe] > weights[d, best[feature]]:
                best[feature] = lobe
        for lobe in sorted(best.values(), key=lambda lobe: -weights[d, lobe])[:EACH]:
            kept[d, lobe] = weights[d, lobe]
    return kept


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.sampled_from([32, 128]), st.integers(3, 16))
def test_pairs_are_the_most_alike_features_of_each_keypoint_with_the_weights_of_a_loop(seed, width, seen):
    thing, data = crowd(seed, width, seen)
    found, expected = pairs_of(thing.index, data), kept_by_loop(thing, data)
    rows = list(zip(found.datum.tolist(), found.lobe.tolist(), strict=True))
    assert len(rows) == len(set(rows))
    if width == 128:  # bits tie
        assert set(rows) == set(expected)
        for row, weight in zip(rows, found.weight.tolist(), strict=True):
            assert weight == pytest.approx(expected[row], rel=1e-4)
    for d in range(seen):
        mine = found.weight[found.datum == d].tolist()
        assert sorted(mine) == pytest.approx(sorted(w for (e, _), w in expected.items() if e == d), rel=1e-4)
        assert len(set(thing.cloud.feature[found.lobe[found.datum == d]].tolist())) == len(mine) <= EACH
    assert ((found.weight > 0) & (found.weight <= 1)).all()


def turns_by_loop(weights, uv):
    """Order of pairs, the weightiest first.

    In turns the weightiest left, and the weightiest left of the cell whose turn it is.

    The cells' turns: first every cell's weightiest, in the order of their weights, then every cell's second, and so on.
    """
    left, queue, seen = list(range(len(weights))), [], {}
    for i in left:
        cell = (floor(uv[i][0] / CELL), floor(uv[i][1] / CELL))
        seen[cell] = seen.get(cell, -1) + 1
        queue.append((seen[cell], i))
    fair, order = [i for _, i in sorted(queue)], []
    for turn in range(2 * len(weights)):
        source = left if turn % 2 == 0 else fair
        place = turn // 2
        if source[place] not in order:
            order.append(source[place])
    return order


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(0, 40), st.floats(10.0, 400.0))
def test_half_of_them_are_the_weightiest_and_half_the_weightiest_of_parts_of_the_image(seed, count, spread):
    rng = np.random.default_rng(seed)
    uv, weights = rng.uniform(-0.5, spread, (count, 2)), np.sort(rng.uniform(0, 1, count))[::-1]
    order = fairly(uv, CELL).tolist()
    assert order == turns_by_loop(weights, uv)
    assert sorted(order) == list(range(count))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_pairs_come_in_that_order(seed):
    thing, data = crowd(seed, seen=16)
    found = pairs_of(thing.index, data)
    sure = np.lexsort((found.lobe, found.datum, -found.weight))
    expected = sure[turns_by_loop(found.weight[sure], data.uv[found.datum[sure]])]
    assert expected.tolist() == list(range(len(found)))
    assert found.weight[0] == found.weight.max()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(0, 40))
def test_fewer_are_the_first_of_more(seed, most):
    thing, data = crowd(seed, seen=16)
    every = pairs_of(thing.index, data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pairs_module, "MOST", most)
        few = pairs_of(thing.index, data)
    assert len(few) == min(most, len(every))
    for name in FIELDS:
        assert getattr(few, name).tolist() == getattr(every, name)[:most].tolist()
        assert getattr(every.take(slice(most)), name).tolist() == getattr(every, name)[:most].tolist()


def test_a_textured_floor_does_not_drown_what_stands_elsewhere():
    """A hundred weightier pairs in one corner, ten weak ones in ten places: the first twenty-two have all ten."""
    rng = np.random.default_rng(0)
    floor_uv = rng.uniform(0, CELL - 1, (100, 2))
    others = np.column_stack([CELL * (1.5 + np.arange(10)), np.full(10, 200.0)])
    order = fairly(np.concatenate([floor_uv, others]), CELL)
    assert set(range(100, 110)) <= set(order[:22].tolist())
    assert set(range(11)) <= set(order[:22].tolist())
