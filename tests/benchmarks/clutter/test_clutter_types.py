"""The types of ``plogic bench clutter``: bodies, features on them, what is made of learned clouds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from learned_cube import CUBE, SIDES, UPS, learned_kb, outward

from benchmarks.clutter.types import (
    DIAMETER,
    EASY,
    HALF_ANGLE,
    HARD,
    LEAST_HALF_ANGLE,
    knowledge_base,
    learned_types,
    random_body,
    random_types,
    type_names,
    with_learned,
)
from geometry.frames import from_rotation_translation, is_rigid
from plogic.run.perceive import Perceiver


def some_kb(seed=0, count=3, features=40, looks=20, detector=EASY):
    return random_types(count, features, looks, np.random.default_rng(seed), detector)


@pytest.mark.parametrize("seed", range(8))
def test_a_body_is_closed_convex_and_of_a_hand_s_size(seed):
    body = random_body(np.random.default_rng(seed))
    assert body.faults == ""
    assert body.volume > 0
    normal, offset = outward(body)
    assert (body.vertices @ normal.T - offset).max() < 1e-9
    across = np.linalg.norm(body.vertices[:, None] - body.vertices[None], axis=2).max()
    assert 0.95 * DIAMETER[0] <= across <= DIAMETER[1] + 1e-9


def test_features_lie_on_the_surface_and_face_outward():
    kinds = some_kb().types
    assert len(kinds) > 0
    for kind in kinds:
        normal, offset = outward(kind.surface)
        assert len(kind.features) == 40
        for feature in kind.features:
            above = normal @ feature.at - offset
            assert above.max() == pytest.approx(0, abs=1e-9)
            assert is_rigid(from_rotation_translation(feature.rotation, feature.at))
            assert (normal[np.abs(above) < 1e-9] @ feature.rotation[:, 2]).max() == pytest.approx(1)


def test_a_lobe_is_a_cone_about_the_outward_normal():
    (appearance,) = some_kb().types[0].features[0].appearances
    assert appearance.lobe.axis.tolist() == [0, 0, 1]
    assert appearance.lobe.half_angle == HALF_ANGLE
    table = some_kb().types[0].lobes
    assert np.allclose(table.axis, [feature.rotation[:, 2] for feature in some_kb().types[0].features])


def test_x_axes_are_turned_every_way_about_the_normal():
    x, z = (np.array([f.rotation[:, axis] for f in some_kb(features=400).types[0].features]) for axis in (0, 2))
    aside = np.cross(z, (0.0, 0.0, 1.0))
    angle = np.arctan2((np.cross(z, aside) * x).sum(axis=1), (aside * x).sum(axis=1))
    assert np.histogram(angle, 4, (-np.pi, np.pi))[0].min() > 60


def test_the_knowledge_base_is_one_that_can_be_perceived_with():
    kb = some_kb(looks=7)
    assert kb.appearance_types == type_names(7) == tuple(sorted(kb.appearance_types))
    assert set(kb.sought) == {look for kind in kb.types for look in kind.lobes.types}
    assert sum(kb.rates.clutter.values()) == pytest.approx(1000)
    assert sum(kb.rates.prior.values()) == pytest.approx(1)
    assert set(kb.rates.hit.values()) == {EASY.hit}
    assert set(Perceiver(kb).models) == {"r0000", "r0001", "r0002"}


def test_the_tree_says_what_the_features_say():
    kind = some_kb().types[1]
    assert sum(node.kind == "feature" for node in kind.tree.nodes.values()) == len(kind.features)
    assert np.array_equal(kind.tree.nodes["f007"].at, kind.features[7].at)
    assert kind.tree.nodes["f007#0"].type == kind.features[7].appearances[0].type


def test_the_same_seed_gives_the_same_content_and_the_digest_tells():
    assert some_kb().digest == some_kb().digest != some_kb(1).digest
    hard = some_kb(detector=HARD)
    assert hard.digest != some_kb().digest
    assert np.array_equal(hard.types[2].lobes.at, some_kb().types[2].lobes.at)


def test_a_learned_feature_keeps_its_lobe_its_direction_and_its_word():
    (cube,) = learned_types(learned_kb(word=[0, 1, 2, 3, 4, 13], half_angle=[0.3, 1.4, 0.3, 0.3, 0.3, 0.3]), 6, 5)
    assert cube.name == "cube"
    assert cube.surface is CUBE
    by_place = {tuple(np.round(f.at * 10).astype(int)): f for f in cube.features}
    assert set(by_place) == {tuple(side.astype(int)) for side in SIDES}
    for side, up, look, angle in zip(SIDES, UPS, (0, 1, 2, 3, 4, 3), (None, 1.4, None, None, None, None), strict=True):
        feature = by_place[tuple(side.astype(int))]
        assert feature.rotation[:, 2] == pytest.approx(side)
        assert feature.rotation[:, 0] == pytest.approx(up)
        assert feature.appearances[0].type == f"a{look:03d}" == feature.type
        assert feature.appearances[0].lobe.half_angle == pytest.approx(angle or LEAST_HALF_ANGLE)


def test_of_a_feature_s_lobes_the_surest_is_taken_and_of_equal_ones_the_wider():
    kb = learned_kb(
        at=[(0.1, 0, 0), (0, 0.1, 0)], axis=SIDES[[0, 0, 2, 2]], up=UPS[[0, 0, 2, 2]], feature=[0, 0, 1, 1],
        hit=[0.2, 0.9, 0.4, 0.4], half_angle=[1.5, 1.35, 1.4, 1.45], word=[0, 1, 2, 3],
    )  # fmt: skip
    (cube,) = learned_types(kb, 9, 10)
    assert {(f.type, round(f.appearances[0].lobe.half_angle, 6)) for f in cube.features} == {
        ("a001", 1.35),
        ("a003", 1.45),
    }


def test_the_surest_are_taken_but_from_all_directions():
    """Two features a side, one of them surer.

    One side's are surer than all others': each side comes once before any comes twice.
    """
    at = np.concatenate([SIDES * 0.1 + 0.03 * UPS, SIDES * 0.1 - 0.03 * UPS])
    hit = np.concatenate([[0.99, 0.4, 0.4, 0.4, 0.4, 0.4], [0.98, 0.3, 0.3, 0.3, 0.3, 0.3]])
    kb = learned_kb(at=at, axis=np.tile(SIDES, (2, 1)), up=np.tile(UPS, (2, 1)), hit=hit, word=np.arange(12))
    (six,) = learned_types(kb, 6, 12)
    assert six.features[0].type == "a000"
    assert {f.type for f in six.features} == {f"a{i:03d}" for i in range(6)}
    (seven,) = learned_types(kb, 7, 12)
    assert seven.features[6].type == "a006"


def test_sides_of_edges_hidden_features_and_second_ones_at_a_place_are_left_out():
    at = np.vstack([SIDES[:3] * 0.1, [(0.1, 0.001, 0)], [(0.0, 0, 0)]])
    axis, up = np.vstack([SIDES[:3], SIDES[0], SIDES[4]]), np.vstack([UPS[:3], UPS[0], UPS[4]])
    kb = learned_kb(at=at, axis=axis, up=up, size=[0.01, 0.0, 0.01, 0.01, 0.01], hit=[0.9, 0.9, 0.9, 0.8, 0.9])
    (cube,) = learned_types(kb, 9, 5)
    assert sorted(tuple(f.at.tolist()) for f in cube.features) == [(0, 0.1, 0), (0.1, 0, 0)]


def test_learned_types_stand_for_as_many_random_ones():
    kb = some_kb()
    mixed = with_learned(kb, learned_types(learned_kb(), 6, 20), EASY)
    assert [kind.name for kind in mixed.types] == ["cube", "r0000", "r0001"]
    assert mixed.appearance_types == kb.appearance_types
    assert set(mixed.rates.prior) == {"cube", "r0000", "r0001"}
    assert mixed.digest != kb.digest
    assert len(Perceiver(mixed).models["cube"].points) == 6


def test_a_wider_tolerance_goes_with_more_noise():
    kinds = some_kb().types
    easy, hard = (knowledge_base(kinds, type_names(20), detector).rates for detector in (EASY, HARD))
    assert all(
        low < high for low, high in pairwise([easy.sigma, hard.sigma, easy.match_tolerance, hard.match_tolerance])
    )
    assert (hard.match_tolerance, hard.sigma_angle) == (6, HARD.turn)
    assert (easy.hit["a000"], hard.hit["a000"]) == (0.6, 0.35)
