"""The scenes of ``plogic bench support``: all is held as is said, and none reach into each other."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from benchmarks.support.arranged import ASTRAY, FREE, HELD, STACKED, Put, Stance, kinds_of, put_together, stays
from benchmarks.support.scenes import TILTS, WANTED, pictures_of, support_scene, tilt
from benchmarks.support.score import feet
from benchmarks.support.solids import FIRMLY, Solid, until_touching
from benchmarks.tabletop.patterns import printed_box, printed_can
from benchmarks.tabletop.scene import bounds
from geometry.bodies.resting import resting_faces
from geometry.frames import is_rigid, transform_points
from sensing.errors import SceneError
from sensing.simulated.body import TexturedMesh
from sensing.simulated.physics import has_physics

SEEDS = st.integers(0, 2**31)
SIZES = (0.12, 0.09, 0.05), (0.07, 0.06, 0.16), (0.1, 0.05, 0.12), (0.06, 0.06, 0.06)
QUICK = settings(max_examples=8, deadline=None)


@cache
def solids():
    """Boxes and cans, labelled as BOP numbers are."""
    rng = np.random.default_rng(5)
    boxes = [printed_box(np.array(size), rng) for size in SIZES]
    cans = [printed_can(0.034, 0.1, rng), printed_can(0.045, 0.06, rng)]
    return tuple(Solid(str(i), mesh) for i, mesh in enumerate((*boxes, *cans), 1))


def arrangement(seed):
    """Things put together, with their kinds; assumed that a place was found for all."""
    rng = np.random.default_rng(seed)
    kinds = kinds_of(int(rng.integers(2, 7)), rng)
    placed = put_together(list(zip(solids(), kinds, strict=False)), [], rng, 0.15)
    assume(placed is not None)
    return placed, kinds


def separation(one, other):
    """The largest m of a plane n·x = c between points (N, 3) and (M, 3): m from both, entries of n at most 1."""
    rows = np.vstack(
        [np.c_[-one, np.ones(len(one)), np.ones(len(one))], np.c_[other, -np.ones(len(other)), np.ones(len(other))]]
    )
    found = linprog([0, 0, 0, 0, -1.0], rows, np.zeros(len(rows)), bounds=[(-1, 1)] * 3 + [(None, None)] * 2)
    return found.x[-1]


@QUICK
@given(SEEDS)
def test_all_are_held_as_is_said_and_none_reach_into_each_other(seed):
    placed, kinds = arrangement(seed)
    assert [put.stance.kind for put in placed] == kinds
    for put in placed:
        assert is_rigid(put.pose)
        heights = put.corners[:, 2]
        if put.stance.kind == "standing":
            assert heights.min() == pytest.approx(0.0, abs=1e-9)
            assert (heights < 1e-6).sum() >= 3
            assert put.solid.area(put.pose, np.array([0.0, 0.0, 1.0])).buffer(1e-6).contains_properly(point(put.middle))
        elif put.stance.kind == "stacked":
            lower = placed[put.stance.on]
            up, height, area = lower.top
            assert (put.corners @ up).min() == pytest.approx(height, abs=1e-9)
            assert (lower.corners @ up).max() == pytest.approx(height, abs=1e-9)
            assert area.buffer(-FIRMLY).contains(point(put.middle))
        else:
            assert heights.min() > HELD[0] - 1e-9 or (put.solid.down @ put.pose[:3, :3].T)[:, 2].min() > -np.cos(ASTRAY)
    for one, other in combinations(placed, 2):
        assert separation(one.corners, other.corners) >= -1e-9


def point(place):
    """Seen from above."""
    from shapely import Point

    return Point(place[:2])


@QUICK
@given(st.integers(0, 10**6))
def test_faces_are_those_of_the_exact_hull_near_resting_ones(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * rng.uniform(0.02, 0.1, 3)
    solid = Solid(None, TexturedMesh(points, np.arange(39).reshape(-1, 3)))
    assert len(solid.down) <= len(resting_faces(points).down)
    for face in range(len(solid.down)):
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        pose = solid.footed(solid.stood(face, up, 1.0), up, np.array([0.1, 0.2, 0.3]))
        heights = transform_points(pose, points) @ up - up @ (0.1, 0.2, 0.3)
        assert heights.min() == pytest.approx(0.0, abs=1e-9)
        assert (heights < 1e-9).sum() >= 3
        assert np.cross(up, solid.middle_at(pose) - (0.1, 0.2, 0.3)) == pytest.approx(np.zeros(3), abs=1e-9)


@QUICK
@given(st.floats(0.001, 0.3), st.floats(0.0, 0.03))
def test_a_box_goes_until_it_touches_another(gap, aside):
    box = np.array([[x, y, z] for x in (0.0, 0.1) for y in (0.0, 0.1) for z in (0.0, 0.1)])
    there = box + np.array([0.1 + gap, aside, 0.0])
    way, at = until_touching(box, there, np.array([1.0, 0.0, 0.0]))
    assert way == pytest.approx(gap, abs=1e-8)
    assert at[0] == pytest.approx(0.1 + gap, abs=1e-8)
    assert until_touching(box, there + np.array([0.0, 0.5, 0.0]), np.array([1.0, 0.0, 0.0])) is None


def test_a_hollow_and_a_narrow_top_carry_nothing():
    rng = np.random.default_rng(1)
    box, narrow = (Solid(None, printed_box(np.array(size), rng)) for size in ((0.1, 0.1, 0.1), (0.02, 0.1, 0.1)))
    assert box.top(np.eye(4)).height == pytest.approx(0.1)
    assert narrow.top(np.eye(4)) is None
    lid = (box.mesh.normals[:, 2] > 0.5).nonzero()[0]
    hollow = Solid(None, replace(box.mesh, triangles=np.delete(box.mesh.triangles, lid, axis=0)))
    assert hollow.top(np.eye(4)) is None
    lying = Solid(None, printed_can(0.034, 0.1, rng))
    assert lying.top(np.eye(4)) is not None
    assert lying.top(lying.stood(lying.down[:, 2].__abs__().argmin(), np.array([0.0, 0.0, 1.0]), 0.3)) is None


@pytest.mark.skipif(not has_physics(), reason="pybullet has no wheel here")
def test_what_overhangs_does_not_stay():
    def stacked(aside):
        lower, upper = solids()[3], solids()[2]
        poses = np.stack([np.eye(4), np.eye(4)])
        poses[1, :3, 3] = aside, 0.0, 0.06
        return [Put(lower, poses[0], Stance("standing")), Put(upper, poses[1], Stance("stacked", 0))]

    assert stays(stacked(0.02))
    assert not stays(stacked(0.035))
    held = [
        one if one.stance.kind == "standing" else Put(one.solid, one.pose, Stance("free")) for one in stacked(0.035)
    ]
    assert stays(held)


def test_a_quarter_is_stacked_and_fifteen_in_a_hundred_are_free():
    rng = np.random.default_rng(3)
    kinds = [kind for _ in range(4000) for kind in kinds_of(int(rng.integers(2, 7)), rng)]
    assert kinds.count("stacked") / len(kinds) == pytest.approx(STACKED, abs=0.02)
    assert kinds.count("free") / len(kinds) == pytest.approx(FREE, abs=0.02)
    assert kinds_of(1, rng) == ["standing"]


@pytest.fixture(scope="module")
def scenes():
    return [support_scene([solids()], 90_000 + i, i) for i in range(6)]


def test_scenes_are_seen_as_asked_from_flat_and_steep(scenes):
    tilts = [tilt(scene.camera) for scene in scenes]
    assert tilts == pytest.approx([np.degrees(np.arcsin(-scene.plane.up[2])) for scene in scenes])
    assert min(tilts) < 25
    assert max(tilts) > 65
    assert all(TILTS[0] <= one <= TILTS[1] for one in tilts)
    for scene in scenes:
        typed = scene.bodies[: len(scene.stances)]
        assert all(body.label is not None for body in typed)
        assert min(scene.fractions[: len(typed)]) >= 0.5
        for body in typed:
            low, high = bounds(body, scene.camera)
            assert WANTED.pixels[0] <= (high - low).max() <= WANTED.pixels[1]
        heights = scene.plane.height(scene.camera_from_bodies[: len(typed), :3, 3])
        assert heights == pytest.approx([body.world_from_body[2, 3] for body in typed])


def test_some_tables_have_an_edge(scenes):
    edged = [scene for scene in scenes if scene.surroundings.floor_height < 0]
    assert 0 < len(edged) < len(scenes)
    for scene in edged:
        board = scene.bodies[-1].vertices_world
        assert board[:, 2].max() == 0.0
        assert board[:, 2].min() > scene.surroundings.floor_height


def test_a_seed_gives_the_same_scene_and_another_gives_another(scenes):
    again, other = support_scene([solids()], 90_000, 0), support_scene([solids()], 90_001, 0)
    assert again.stances == scenes[0].stances
    assert np.array_equal(again.camera_from_bodies, scenes[0].camera_from_bodies)
    assert not np.array_equal(again.camera.world_from_camera, other.camera.world_from_camera)
    one, same = (next(pictures_of([solids()], [90_000])) for _ in range(2))
    assert np.array_equal(one.shown.image, same.shown.image)
    assert one.shown.camera.world_from_camera is None
    assert one.plane.height(feet(one)) == pytest.approx(0.0, abs=1e-9)


def test_what_cannot_be_put_together_is_one_clear_line(monkeypatch):
    monkeypatch.setattr("benchmarks.support.scenes.ATTEMPTS", 2)
    huge = [Solid(str(i), printed_box(np.array([0.5, 0.5, 2.0]), np.random.default_rng(0))) for i in (1, 2)]
    with pytest.raises(SceneError, match="seed 5: no scene of 2 things was found in 2 arrangements"):
        support_scene([huge], 5, 0)
