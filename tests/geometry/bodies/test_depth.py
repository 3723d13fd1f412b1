"""Penetration depth (A4): by hand for boxes, by its definition for all, its laws, and bounds for the rest."""

import numpy as np
import pytest
import trimesh
from geometry_bodies import at, box, bracket, prism, random_rotations, wedge
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.depth import parts_of, penetration
from geometry.bodies.overlap import Solid, solid_overlap
from geometry.frames import from_rotation_translation

ELL = prism([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], 1.0)
CUBE, BRICK, WEDGE, YOU, EL = Solid(*box()), Solid(*box(0.8, 0.6, 1.3)), Solid(*wedge()), Solid(*bracket()), Solid(*ELL)
CONVEX, ALL = (CUBE, BRICK, WEDGE), (CUBE, BRICK, WEDGE, YOU, EL)
QUICK = settings(max_examples=40, deadline=None, derandomize=True)
TOUCH = [(1, 0, 0), (0, -1, 0.3), (0.2, 0.4, 1), (1, 1, 0), (1, 0.2, 1), (1, 1, 1), (5, 0, 0)]


def anywhere(rng, spread=0.6):
    return from_rotation_translation(random_rotations(rng, 1)[0], rng.uniform(-spread, spread, 3))


def moved(T, way):
    result = np.array(T)
    result[:3, 3] += way
    return result


def overlapping(seed, solids=ALL):
    rng = np.random.default_rng(seed)
    while True:
        a, b = (solids[k] for k in rng.integers(0, len(solids), 2))
        T_a, T_b = anywhere(rng), anywhere(rng)
        found = penetration(a, T_a, b, T_b)
        if found is not None:
            return a, T_a, b, T_b, found


@QUICK
@given(st.tuples(*[st.floats(-0.99, 0.99)] * 3), st.integers(0, 99))
def test_two_cubes_come_apart_by_the_least_of_the_three_slabs(shift, seed):
    world_from_a = from_rotation_translation(random_rotations(np.random.default_rng(seed), 1)[0], [3, -2, 7])
    low, high, way = penetration(CUBE, world_from_a, CUBE, world_from_a @ at(*shift))
    assert low == high == pytest.approx(1.0 - np.abs(shift).max(), abs=1e-9)
    assert np.linalg.norm(way) == pytest.approx(1.0)


@pytest.mark.parametrize("shift", TOUCH)
def test_what_only_touches_has_no_depth(shift):
    places = [from_rotation_translation(R, [3, -2, 7]) for R in random_rotations(np.random.default_rng(1), 3)]
    assert [penetration(CUBE, T, CUBE, T @ at(*shift)) for T in places] == [None] * 3


def test_two_balls_come_apart_by_what_their_radii_say():
    """Nearly: a ball of triangles is a little too small."""
    a, b = (trimesh.creation.icosphere(subdivisions=4, radius=r) for r in (1.0, 0.5))
    found = penetration(Solid(a.vertices, a.faces), np.eye(4), Solid(b.vertices, b.faces), at(1.4, 0.1, 0.0))
    assert found.low == found.high == pytest.approx(1.5 - np.hypot(1.4, 0.1), abs=0.01)


@QUICK
@given(st.integers(0, 9999))
def test_moved_by_the_depth_it_is_free_and_by_less_it_is_not(seed):
    """The definition, in 60 directions; concave bodies too."""
    a, T_a, b, T_b, found = overlapping(seed)
    assert solid_overlap(a, T_a, b, moved(T_b, (found.high + 1e-6) * found.way)) < 1e-9
    ways = np.random.default_rng(seed).normal(size=(60, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    assert min(solid_overlap(a, T_a, b, moved(T_b, 0.98 * found.low * way)) for way in ways) > 0.0


@QUICK
@given(st.integers(0, 9999))
def test_volume_and_depth_are_symmetric_and_the_same_in_any_frame(seed):
    a, T_a, b, T_b, found = overlapping(seed)
    back = penetration(b, T_b, a, T_a)
    T = from_rotation_translation(random_rotations(np.random.default_rng(seed + 1), 1)[0], [1, 2, 3])
    other = penetration(a, T @ T_a, b, T @ T_b)
    for one in (back, other):
        assert one.low <= found.high + 1e-6
        assert found.low <= one.high + 1e-6
    volume = solid_overlap(a, T_a, b, T_b)
    assert solid_overlap(b, T_b, a, T_a) == pytest.approx(volume, rel=1e-6)
    assert solid_overlap(a, T @ T_a, b, T @ T_b) == pytest.approx(volume, rel=1e-6)


@QUICK
@given(st.integers(0, 9999))
def test_pushed_along_the_way_out_a_convex_body_is_less_deep_and_against_it_deeper(seed):
    a, T_a, b, T_b, found = overlapping(seed, CONVEX)
    out = penetration(a, T_a, b, moved(T_b, 0.3 * found.high * found.way))
    assert out.high == pytest.approx(0.7 * found.high, abs=1e-7)
    assert solid_overlap(a, T_a, b, moved(T_b, 0.3 * found.high * found.way)) < solid_overlap(a, T_a, b, T_b)


def test_bodies_that_interlock_without_touching_share_nothing_though_their_hulls_do():
    """Two Us hooked into each other, and two Ls back in each other's corner; then the same, pushed 5 cm in."""
    hooked = at(0.75, 0.95, 0, [[-1, 0, 0], [0, -1, 0], [0, 0, 1]])
    nested = at(1.1, 1.1, 0)
    for solid, pose in ((YOU, hooked), (EL, nested)):
        hull = solid.body.hull()
        assert (hull ^ hull.transform(pose[:3])).volume() > 0.1
        assert solid_overlap(solid, np.eye(4), solid, pose) == 0.0
        assert penetration(solid, np.eye(4), solid, pose) is None
    assert penetration(EL, np.eye(4), EL, at(0.95, 1.2, 0)).high == pytest.approx(0.05, abs=1e-9)


def test_a_concave_body_is_as_deep_as_its_arm_and_not_as_its_hull():
    """A block between the arms of a U, 5 cm in its bottom: by hand 5 cm, where the hulls would need 45."""
    found = penetration(YOU, np.eye(4), Solid(*box(1.0, 0.5, 0.8)), at(0, 0.0, 0))
    assert found.low == found.high == pytest.approx(0.05, abs=1e-9)
    assert np.allclose(found.way, [0, 1, 0], atol=1e-6)
    assert parts_of(YOU).exact
    assert len(parts_of(YOU).parts) == 3


def test_what_is_too_dented_to_be_cut_is_known_within_bounds():
    """A torus lying on another, 10 cm in: so much, from straight below; its hull is flat there too."""
    ring = trimesh.creation.torus(1.0, 0.3)
    solid = Solid(ring.vertices, ring.faces)
    assert not parts_of(solid).exact
    low, high, way = penetration(solid, np.eye(4), solid, at(0, 0, 0.5))
    assert 0.0 < low < high == pytest.approx(0.1, abs=1e-6)
    assert solid_overlap(solid, np.eye(4), solid, moved(at(0, 0, 0.5), (high + 1e-6) * way)) < 1e-9


def within(points):
    """In the L, by its two boxes."""
    return ((points >= 0) & (points <= [3, 1, 1])).all(axis=1) | ((points >= 0) & (points <= [1, 3, 1])).all(axis=1)


@pytest.mark.parametrize("seed", range(4))
def test_the_volume_that_two_ls_share_is_what_drawn_points_say(seed):
    """Oracle: Monte Carlo."""
    rng = np.random.default_rng(seed)
    T = from_rotation_translation(random_rotations(rng, 1)[0], rng.uniform(0, 1, 3))
    points = rng.uniform(0, [3, 3, 1], (100_000, 3))
    share = (within(points) & within((points - T[:3, 3]) @ T[:3, :3])).mean()
    assert solid_overlap(EL, np.eye(4), EL, T) == pytest.approx(9 * share, abs=0.05)
    assert share > 0.0


def test_a_crate_whose_walls_single_precision_leaves_beside_its_planes_is_told_within_bounds():
    """Its second cut used to run beside the wall that the first had left, again and again."""
    hollow = trimesh.creation.box((0.36, 0.36, 0.3)).apply_translation((0, 0, 0.02))
    crate = trimesh.boolean.difference([trimesh.creation.box((0.4, 0.4, 0.3)), hollow])
    solid = Solid(np.array(crate.vertices), np.array(crate.faces))
    cube = Solid(*box(0.1, 0.1, 0.1))
    found = penetration(solid, np.eye(4), cube, at(0.0, 0.0, -0.135))
    assert 0.0 < found.low <= 0.055 + 1e-6
    assert found.low <= found.high
