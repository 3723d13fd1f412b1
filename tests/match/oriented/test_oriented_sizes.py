"""Scales of data: where the knowledge base has an appearance's width, a datum's scale must fit the distance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oriented_scenes import EASY, Ready, a_trial, clouds

from geometry.frames import transform_points
from plogic.match.gamma.data import data_of
from plogic.match.oriented.oriented_models import key_of
from plogic.match.oriented.pair_votes import AS_WIDE, raw_votes

WIDTH = 0.02


def wide(kind, width):
    """The type, each appearance of which is so wide, m; ``width`` is asked for each feature by number."""
    features = tuple(
        replace(f, appearances=tuple(replace(a, lobe=replace(a.lobe, size=width(i))) for a in f.appearances))
        for i, f in enumerate(kind.features)
    )
    return replace(kind, features=features, all_features=features)


def ready(width=lambda _: WIDTH):
    kb = clouds().kb
    return Ready(replace(kb, types=tuple(wide(kind, width) for kind in kb.types)))


def scaled(case, kind, factor=1.0):
    """The data, with the scales of what is as wide as ``WIDTH``, times a factor.

    Clutter has scales too, of anything.
    """
    rng, focal = np.random.default_rng(0), case.gamma.camera.f
    at = transform_points(case.truth.camera_from_object, np.array([f.at for f in kind.features]))
    right = {name: factor * WIDTH * focal / at[f, 2] for name, f in case.causes.items()}
    rows = [replace(a, scale=float(right.get(a.id, rng.uniform(1.0, 60.0)))) for a in case.gamma.appearances]
    return data_of(rows, case.gamma.camera)


def votes(some, data):
    shared = some.shared
    looks = {name: i for i, name in enumerate(shared.looks)}
    return raw_votes(shared, np.array([looks.get(name, -1) for name in data.types]), data, some.kb.rates.sigma_angle)


def own(raw, data, which, case):
    """The votes of pairs of the object's own data for its type."""
    mine = np.array([name in case.causes for name in data.ids])
    return set(map(tuple, raw.pair[mine[raw.pair].all(axis=1) & (raw.votes.kind == which)].tolist()))


@pytest.mark.parametrize("seed", range(6))
def test_right_scales_keep_right_votes_and_drop_most_others(seed):
    some = ready()
    which, case, plain = a_trial(some, seed, EASY, 300)
    data = scaled(case, some.kb.types[which])
    without, with_scales = votes(some, plain), votes(some, data)
    kept = own(with_scales, data, which, case)
    assert len(kept) >= 0.8 * len(own(without, plain, which, case)) > 0
    assert 0 < len(with_scales.query) < 0.6 * len(without.query)


@pytest.mark.parametrize("factor", [1.0 / (2.0 * AS_WIDE), 2.0 * AS_WIDE])
def test_wrong_scales_have_no_right_vote(factor):
    some = ready()
    which, case, plain = a_trial(some, 1, EASY, 300)
    data, without = scaled(case, some.kb.types[which], factor), votes(some, plain)
    truth = np.linalg.norm(case.truth.camera_from_object[:3, 3])
    right = case.gamma.camera.f / truth
    near = np.abs(np.log(without.votes.scale / right)) < 0.3
    assert near.any()
    raw = votes(some, data)
    mine = np.array([name in case.causes for name in data.ids])
    mine = mine[raw.pair].all(axis=1) & (raw.votes.kind == which)
    assert not (np.abs(np.log(raw.votes.scale[mine] / right)) < 0.3).any()


@pytest.mark.parametrize("width", [lambda _: np.nan, lambda i: WIDTH if i % 3 else np.nan])
def test_what_is_of_unknown_size_is_of_any(width):
    some = ready(width)
    which, case, plain = a_trial(some, 2, EASY, 300)
    without, with_scales = (
        own(votes(some, data), data, which, case) for data in (plain, scaled(case, some.kb.types[which]))
    )
    assert len(with_scales) >= 0.8 * len(without) > 0
    sizes = some.shared.sizes
    assert (sizes is None) == np.isnan(width(1))
    assert sizes is None or (sizes[0] <= sizes[1]).any()


def test_data_without_scales_vote_as_before():
    some = ready()
    _, _, data = a_trial(some, 3, EASY, 300)
    one, other = votes(some, data), votes(clouds(), data)
    assert np.array_equal(one.query, other.query)
    assert np.array_equal(one.votes.scale, other.votes.scale)


def test_an_index_is_kept_under_what_its_sizes_are():
    types = clouds().kb.types
    keys = {key_of([wide(types[0], lambda _, width=width: width)]) for width in (0.01, 0.02, float("nan"))}
    assert len(keys) == 3
