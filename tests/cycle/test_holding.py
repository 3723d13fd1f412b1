"""Who rests on whom, by contacts.

Against what boxes at known heights do by hand, from any direction, and what poses that may be wrong change.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geometry.bodies.columns import STEEP
from kb.surfaces.surface import Surface
from plogic.cycle.placing import Laid, foot_of, gravity_of_view, rests_of

QUICK = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
ALLOWED = 0.005
"""Of a body a metre from the camera, by half of a hundredth."""
SURE = np.eye(6) * 1e-12


def surface_of(mesh):
    return Surface(np.array(mesh.vertices), np.array(mesh.faces))


def brick(*size):
    return surface_of(trimesh.creation.box(size))


def laid(name, surface, at, turn=None, covariance=SURE, allowed=ALLOWED):
    pose = np.eye(4)
    pose[:3, 3] = at
    if turn is not None:
        pose[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    return Laid(name, surface, pose, np.array(at, float), allowed, covariance)


CUBE = brick(0.1, 0.1, 0.1)
TABLE = laid("table", brick(1.0, 1.0, 0.4), (0, 0, 0.2))
PLACES = [
    ("on it", (0.2, 0.1, 0.45), None, True),
    ("nine millimetres over it", (0.2, 0.1, 0.459), None, True),
    ("two centimetres over it", (0.2, 0.1, 0.47), None, False),
    ("twenty centimetres over it", (0.2, 0.1, 0.65), None, False),
    ("sunk by nine millimetres", (0.2, 0.1, 0.441), None, True),
    ("half over its edge", (0.5, 0.1, 0.45), None, True),
    ("beside it, touching", (0.55, 0.1, 0.2), None, False),
    ("beside it, on the floor", (0.6, 0.1, 0.05), None, False),
    ("beside its edge and above", (0.6, 0.1, 0.6), None, False),
    ("under it", (0.2, 0.1, -0.05), None, False),
    ("on an edge", (0.2, 0.1, 0.4 + 0.05 * 2**0.5), (np.pi / 4, 0, 0), True),
    ("tilted by ten degrees, a corner down", (0.2, 0.1, 0.46), (0.17, 0, 0), True),
]


@pytest.mark.parametrize(("where", "at", "turn", "held"), PLACES, ids=[row[0] for row in PLACES])
def test_a_cube_at_a_table(where, at, turn, held):
    cube = laid("cube", CUBE, at, turn)
    assert (("cube", "table") in rests_of([cube, TABLE])) == held, where
    assert rests_of([TABLE, cube]) == (() if where != "under it" else (("table", "cube"),)) + (
        (("cube", "table"),) if held else ()
    )


def test_a_stack_of_three():
    stack = [laid(f"h{i}", CUBE, (0.01 * i, 0, 0.05 + 0.1 * i)) for i in range(3)]
    assert set(rests_of(stack)) == {("h1", "h0"), ("h2", "h1")}
    assert set(rests_of(stack, apart=[("h2", "h1")])) == {("h1", "h0")}
    assert [foot_of(one).low for one in stack] == pytest.approx([-0.005, 0.095, 0.195])
    assert [foot_of(one).high for one in stack] == pytest.approx([0.005, 0.105, 0.205])


def overlap_of_boxes(one, other):
    """How far two boxes along the axes are apart along each axis, negative where they overlap: the analytic oracle."""
    (a, s), (b, t) = one, other
    return np.abs(np.subtract(a, b)) - (np.array(s) + t) / 2


@QUICK
@given(st.integers(0, 9999))
def test_boxes_along_the_axes_rest_as_their_sides_say(seed):
    """By the shortest way apart of two boxes: their gap, or, where they overlap, the axis on which they do so least."""
    rng = np.random.default_rng(seed)
    one = (rng.uniform(-0.1, 0.1, 3), rng.uniform(0.06, 0.2, 3))
    other = (rng.uniform(-0.1, 0.1, 3), rng.uniform(0.06, 0.2, 3))
    along = overlap_of_boxes(one, other)
    if (along > 0).any():
        apart = np.maximum(along, 0.0)
        gap, way = np.linalg.norm(apart), apart / np.linalg.norm(apart)
    else:
        gap, way = along.max(), np.eye(3)[along.argmax()]
    sides = np.sort(along)[::-1]
    over = (one[0][2] - one[1][2] / 2) - (other[0][2] + other[1][2] / 2)
    if (
        min(abs(gap - 2 * ALLOWED), abs(way[2] - np.cos(STEEP)), abs(over + 2 * ALLOWED), abs(sides[0] - sides[1]))
        < 1e-4
    ):
        return
    expected = gap <= 2 * ALLOWED and ((way[2] >= np.cos(STEEP) and one[0][2] > other[0][2]) or over >= -2 * ALLOWED)
    found = rests_of([laid("x", brick(*one[1]), one[0]), laid("y", brick(*other[1]), other[0])])
    assert (("x", "y") in found) == expected


@QUICK
@given(st.integers(0, 9999))
def test_facts_do_not_change_where_the_world_is_turned_about_the_vertical_or_moved(seed):
    rng = np.random.default_rng(seed)
    bodies = [
        laid(f"h{i}", brick(*rng.uniform(0.05, 0.2, 3)), rng.uniform(-0.1, 0.1, 3), rng.normal(0, 1, 3))
        for i in range(4)
    ]
    shift, turn = rng.uniform(-3, 3, 3), Rotation.from_rotvec([0, 0, rng.uniform(0, 6)]).as_matrix()
    moved = []
    for one in bodies:
        pose = one.world_from_object.copy()
        pose[:3, :3], pose[:3, 3] = turn @ pose[:3, :3], turn @ pose[:3, 3] + shift
        moved.append(one._replace(world_from_object=pose, middle=turn @ one.middle + shift))
    assert set(rests_of(moved)) == set(rests_of(bodies))
    for before, after in zip(bodies, moved, strict=True):
        assert foot_of(after).low == pytest.approx(foot_of(before).low + shift[2], abs=2e-6)


@QUICK
@given(st.integers(0, 9999))
def test_what_poses_may_be_off_only_adds_to_who_may_hold(seed):
    rng = np.random.default_rng(seed)
    bodies = [laid(f"h{i}", brick(*rng.uniform(0.05, 0.2, 3)), rng.uniform(-0.12, 0.12, 3)) for i in range(4)]
    square = rng.normal(0, 0.01, (4, 6, 6))
    unsure = [one._replace(covariance=root @ root.T) for one, root in zip(bodies, square, strict=True)]
    # of two that now may each rest on the other, the higher does
    both = {frozenset(pair) for pair in rests_of(unsure)}
    assert {frozenset(pair) for pair in rests_of(bodies)} <= both
    assert all(
        foot_of(a).low <= foot_of(b).low and foot_of(a).high >= foot_of(b).high
        for a, b in zip(unsure, bodies, strict=True)
    )


def test_depth_that_is_little_known_lets_a_cube_rest_that_seems_to_stand_beside_its_post():
    """A level camera along y: 3 cm behind a post in depth.

    A deviation of 1.5 cm of depth allows that, one of 1 mm does not.
    """
    post = laid("post", brick(0.05, 0.05, 0.3), (0, 0, 0.15))
    cube = laid("cube", CUBE, (0, 0.105, 0.35))
    assert rests_of([cube, post]) == ()
    depth = np.diag([1e-12, 1e-12, 1e-12, 1e-8, 0.015**2, 1e-8])
    assert rests_of([cube._replace(covariance=depth), post]) == (("cube", "post"),)
    assert foot_of(cube._replace(covariance=depth)) == foot_of(cube)


def test_what_stands_in_a_crate_or_on_a_shelf_rests_on_it_and_what_hovers_there_does_not():
    hollow = trimesh.creation.box((0.36, 0.36, 0.3)).apply_translation((0, 0, 0.02))
    crate = trimesh.boolean.difference([trimesh.creation.box((0.4, 0.4, 0.3)), hollow])
    body = laid("crate", surface_of(crate), (0, 0, 0.15))
    for height, held in ((0.07, True), (0.14, False)):
        assert (("cube", "crate") in rests_of([laid("cube", CUBE, (0.05, 0.03, height)), body])) == held
    open_crate = Surface(
        body.surface.vertices, body.surface.triangles[1:]
    )  # a facet is missing, so it may be no solid: its own facets are asked
    for height, held in ((0.07, True), (0.14, False)):
        assert (
            ("cube", "crate") in rests_of([laid("cube", CUBE, (0.05, 0.03, height)), body._replace(surface=open_crate)])
        ) == held


def test_a_scan_is_asked_by_its_facets_when_something_stands_on_it():
    """A bowl of 2560 facets has too many dents to be cut; a ball in it rests on it, one over its rim does not."""
    ball = trimesh.creation.icosphere(4, radius=0.2)
    inside, over = (
        trimesh.creation.icosphere(4, radius=0.18),
        trimesh.creation.box((1, 1, 0.4)).apply_translation((0, 0, 0.2)),
    )
    bowl = trimesh.boolean.difference([ball, inside, over])
    scan = laid("bowl", surface_of(bowl), (0, 0, 0.2))
    small = surface_of(trimesh.creation.icosphere(2, radius=0.03))
    for height, held in ((0.05, True), (0.12, False)):
        assert (("ball", "bowl") in rests_of([laid("ball", small, (0, 0, height)), scan])) == held


def test_without_gravity_there_is_nothing_and_without_an_up_it_keeps_silent():
    unknown = SimpleNamespace(world_from_camera=None)
    assert gravity_of_view({}, (), unknown, SimpleNamespace(gravity=False)) is None
    found = gravity_of_view({}, (), unknown, SimpleNamespace(gravity=True, unknown_support=0.2, ground=None))
    assert (found.unknown_support, found.feet, found.rests) == (0.2, (), ())
    assert "which way is up" in found.silent
