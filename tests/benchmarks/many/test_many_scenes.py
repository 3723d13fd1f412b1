"""The scenes of ``plogic bench many``: who stands where, who hides what, and what the detector makes of it."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from learned_cube import CUBE

from benchmarks.clutter.bench import ours
from benchmarks.clutter.scenes import CAMERA, surface_of
from benchmarks.clutter.types import made, type_names
from benchmarks.many.placing import HALF_HIDDEN, OBJECTS, Placed, depth_of, meet, visible_shares
from benchmarks.many.scenes import NOISE, scene, seen
from benchmarks.many.types import DETECTOR, LOOKS, frequencies, polyhedron, with_rates
from geometry.frames import from_rotation_translation, transform_points
from geometry.visibility.occlusion import PosedSurface, visible_fraction
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.run.perceive import Perceiver
from sensing.appearance import Gamma

SEEDS = range(5000, 5012)


@pytest.fixture(scope="module")
def kb():
    rng, names = np.random.default_rng(7), type_names(LOOKS)
    return with_rates([polyhedron(f"p{i:02d}", names, rng) for i in range(6)], names)


@pytest.fixture(scope="module")
def scenes(kb):
    return [scene(kb, seed) for seed in SEEDS]


def standing(kind, x, z):
    pose = from_rotation_translation(np.eye(3), np.array([x, 0.0, z]))
    return Placed(kind, pose, depth_of(kind, pose))


def test_there_are_as_many_objects_as_promised_and_no_two_share_volume(kb, scenes):
    assert {len(s.truths) for s in scenes} <= set(range(OBJECTS[0], OBJECTS[1] + 1))
    assert len({len(s.truths) for s in scenes}) > 2
    for s in scenes:
        for a, b in itertools.combinations(s.truths, 2):
            assert not meet(kb.type(a.type), a.camera_from_object, kb.type(b.type), b.camera_from_object)


def test_a_good_share_is_half_hidden_and_several_of_one_type_occur(scenes):
    shares = np.array([t.fraction for s in scenes for t in s.truths])
    assert ((shares >= HALF_HIDDEN[0]) & (shares <= HALF_HIDDEN[1])).mean() > 0.3
    assert any(len({t.type for t in s.truths}) < len(s.truths) for s in scenes)


def test_clutter_is_three_tenths_of_the_data_with_the_vocabulary_s_looks(kb, scenes):
    for s in scenes:
        assert 1.0 - len(s.causes) / len(s.gamma.appearances) == pytest.approx(NOISE, abs=0.01)
    noise = [a for s in scenes for a in s.gamma.appearances if a.id not in s.causes]
    share = frequencies(kb)
    often = {name for name, f in zip(kb.appearance_types, share, strict=True) if f > np.median(share)}
    hoped = sum(f for name, f in zip(kb.appearance_types, share, strict=True) if name in often)
    assert np.mean([a.type in often for a in noise]) == pytest.approx(hoped, abs=0.08)
    assert (
        np.histogram2d(*np.array([a.uv for a in noise]).T, bins=(2, 2), range=((0, 640), (0, 480)))[0].min()
        > len(noise) / 8
    )


def test_a_fifth_of_what_shows_is_missed_and_the_noise_is_the_detector_s(kb, scenes):
    found = there = 0
    off, turned = [], []
    assert len(scenes) == len(SEEDS)
    for s in scenes:
        objects = [Placed(kb.type(t.type), t.camera_from_object, np.zeros(0)) for t in s.truths]
        there += sum(len(seen(kb, objects, which)) for which in range(len(objects)))
        found += len(s.causes)
        for a in s.gamma.appearances:
            if a.id in s.causes:
                which, f = s.causes[a.id]
                one = objects[which]
                at = transform_points(one.pose, one.kind.lobes.at[f][None])[0]
                off += list(np.array(a.uv) - CAMERA.project(at[None])[0])
                turned.append(
                    float(wrapped(a.angle - screen_angle(one.pose[:3, :3] @ one.kind.features[f].rotation[:, 0], at)))
                )
    assert found / there == pytest.approx(DETECTOR.hit, abs=0.04)
    assert np.std(off) == pytest.approx(DETECTOR.sigma, rel=0.1)
    assert np.std(turned) == pytest.approx(DETECTOR.turn, rel=0.12)


def test_visible_shares_are_those_of_the_outlines(scenes, kb):
    assert min(len(s.truths) for s in scenes[:3]) > 0
    for s in scenes[:3]:
        posed = [PosedSurface(*_mesh(kb, t), t.camera_from_object) for t in s.truths]
        for i, t in enumerate(s.truths):
            assert t.fraction == pytest.approx(visible_fraction(posed[i], posed[:i] + posed[i + 1 :], CAMERA), abs=0.06)


def _mesh(kb, truth):
    surface = surface_of(kb.type(truth.type))
    return surface.vertices, surface.triangles, surface.rays


def test_who_stands_before_another_hides_it_and_what_is_on_it(kb):
    kind = kb.types[0]
    near, far, aside = standing(kind, 0.0, 0.8), standing(kind, 0.0, 2.0), standing(kind, 0.6, 2.0)
    assert visible_shares([near, far, aside]) == pytest.approx([1, 0, 1])
    assert not len(seen(kb, [near, far], 1))
    assert len(seen(kb, [near, far], 0)) == len(seen(kb, [near], 0)) > 10
    assert visible_shares([]).shape == (0,)


def test_touching_is_allowed_and_sharing_volume_is_not():
    cube = made("cube", CUBE, np.array([[0.1, 0, 0]]), np.eye(3)[None], ["a"], np.ones(1))
    first = from_rotation_translation(np.eye(3), np.array([0.0, 0.0, 2.0]))
    for apart, met in ((0.2, False), (0.25, False), (0.199, True), (0.0, True)):
        assert meet(cube, first, cube, from_rotation_translation(np.eye(3), np.array([apart, 0.0, 2.0]))) == met


def test_a_seed_gives_one_scene_and_another_another(kb, scenes):
    again = scene(kb, SEEDS[0])
    assert again.gamma.appearances == scenes[0].gamma.appearances
    assert again.causes == scenes[0].causes
    assert again.gamma.appearances != scenes[1].gamma.appearances


def test_neither_ids_nor_order_tell_whose_a_datum_is(scenes):
    for s in scenes:
        assert [a.id for a in s.gamma.appearances] == [f"d{n}" for n in range(len(s.gamma.appearances))]
    places = [
        int(name[1:]) / len(s.gamma.appearances) for s in scenes for name, (which, _) in s.causes.items() if which == 0
    ]
    assert np.histogram(places, 4, (0, 1))[0].min() > 0.15 * len(places)


def test_the_order_of_the_data_decides_nothing(kb):
    perceiver = Perceiver(kb)
    gamma = scene(kb, SEEDS[0], (3, 4)).gamma
    order = np.random.default_rng(1).permutation(len(gamma.appearances))
    first, _ = ours(perceiver, gamma)
    other, _ = ours(perceiver, Gamma(gamma.camera, tuple(replace(gamma.appearances[i]) for i in order)))
    assert len(first) >= 3
    assert [f.type for f in first] == [f.type for f in other]
    assert np.allclose([f.camera_from_object for f in first], [f.camera_from_object for f in other], atol=1e-6)
