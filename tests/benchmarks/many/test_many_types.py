"""The types of ``plogic bench many``.

Polyhedra with features on their corners and faces, and new prints of learned clouds.
"""

from __future__ import annotations

import numpy as np
import pytest
from learned_cube import learned_kb, outward

from benchmarks.clutter.types import type_names
from benchmarks.many.types import (
    CLUTTER,
    FEATURES,
    JUNCTIONS,
    LEARNED,
    LOOKS,
    PRIOR,
    TYPES,
    frequencies,
    many_kb,
    polyhedron,
    random_polyhedron,
    with_rates,
)

NAMES = type_names(LOOKS)


def one(seed):
    return polyhedron("p00", NAMES, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(8))
def test_a_polyhedron_is_closed_and_convex_with_a_feature_at_each_corner_and_the_others_on_its_faces(seed):
    kind = one(seed)
    surface = kind.surface
    assert surface.faults == ""
    normal, offset = outward(surface)
    assert (surface.vertices @ normal.T <= offset + 1e-9).all()
    at, corners = kind.lobes.at, len(surface.vertices)
    assert len(at) == FEATURES
    assert np.array_equal(at[:corners], surface.vertices)
    assert np.abs((at[corners:] @ normal.T - offset).max(axis=1)).max() < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_lobes_face_out_of_their_face_and_corners_look_like_junctions(seed):
    kind = one(seed)
    normal, offset = outward(kind.surface)
    corners = len(kind.surface.vertices)
    facing = (kind.lobes.at @ normal.T - offset).argmax(axis=1)
    cosine = (kind.lobes.axis * normal[facing]).sum(axis=1)
    assert cosine[corners:] == pytest.approx(1.0, abs=1e-6)
    assert (cosine[:corners] > 0.0).all()
    number = [NAMES.index(look) for look in kind.lobes.types]
    assert max(number[:corners]) < JUNCTIONS <= min(number[corners:])


def test_polyhedra_have_several_faces_of_more_than_three_corners():
    normal, offset = outward(random_polyhedron(np.random.default_rng(3)))
    faces = np.unique(np.round(np.column_stack([normal, offset]), 5), axis=0, return_counts=True)[1]
    assert 6 <= len(faces) <= 18
    assert (faces > 1).sum() >= 4


def test_without_learned_types_all_are_polyhedra(monkeypatch):
    assert [kind.name for kind in many_kb(None, 3).types] == [f"p{i:02d}" for i in range(TYPES)]
    monkeypatch.setattr("benchmarks.many.types.TYPES", 5)
    kb = many_kb(None, 3)
    assert len(kb.types) == 5
    assert kb.digest == many_kb(None, 3).digest != many_kb(None, 4).digest


def test_half_of_the_types_are_made_of_learned_ones_each_print_with_looks_of_its_own():
    kb = many_kb(learned_kb(), 0)
    names = [kind.name for kind in kb.types]
    assert names[TYPES - LEARNED :] == ["cube", *(f"cube_{i:02d}" for i in range(1, LEARNED))]
    prints = kb.types[TYPES - LEARNED :]
    assert all(kind.surface is prints[0].surface for kind in prints)
    assert all(np.array_equal(kind.lobes.at, prints[0].lobes.at) for kind in prints)
    assert len({kind.lobes.types for kind in prints}) > LEARNED // 2


def test_clutter_is_as_frequent_as_what_it_looks_like():
    kinds = [one(seed) for seed in range(3)]
    kb = with_rates(kinds, NAMES)
    share = dict(zip(NAMES, frequencies(kb), strict=True))
    assert sum(share.values()) == pytest.approx(1.0)
    counts = {name: 1 + sum(kind.lobes.types.count(name) for kind in kinds) for name in NAMES}
    assert share == pytest.approx({name: count / sum(counts.values()) for name, count in counts.items()})
    assert sum(kb.rates.clutter.values()) == pytest.approx(CLUTTER)
    assert set(kb.rates.prior.values()) == {PRIOR}
