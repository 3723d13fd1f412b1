import numpy as np
import pytest
from geometry_bodies import at, box, bracket, random_rotations, wedge
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.overlap import Solid, least_width, reach, reaches, solid_overlap
from geometry.frames import from_rotation_translation

CUBE, BRICK, WEDGE = Solid(*box()), Solid(*box(0.8, 0.6, 1.3)), Solid(*wedge())


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.floats(0.001, 0.2), st.integers(0, 2), st.booleans(), st.integers(0, 99))
def test_a_cube_pushed_into_another_comes_out_the_way_it_came(deep, axis, back, seed):
    """Of two unit cubes that share a slab the depth is its thickness, whatever the common frame."""
    world_from_a = from_rotation_translation(random_rotations(np.random.default_rng(seed), 1)[0], [3, -2, 7])
    way = np.eye(3)[axis] * (-1.0 if back else 1.0)
    aside = 0.3 * np.roll(np.eye(3)[axis], 1)
    found = reach(CUBE, world_from_a, CUBE, world_from_a @ at(*((1.0 - deep) * way + aside)))
    assert found.depth == pytest.approx(deep, rel=1e-6)
    assert np.allclose(found.way, world_from_a[:3, :3] @ way, atol=1e-6)


@pytest.mark.parametrize("shift", [(1, 0, 0), (0.2, 0.4, 1), (1, 1, 1), (5, 0, 0)])
def test_what_only_touches_or_stands_apart_reaches_nowhere(shift):
    assert reach(CUBE, np.eye(4), CUBE, at(*shift)) is None


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 999))
def test_moved_out_by_the_depth_a_convex_body_shares_next_to_nothing(seed):
    """Whichever is moved; and asked the other way round, the depth is the same and the way the opposite."""
    rng = np.random.default_rng(seed)
    a, b = (CUBE, BRICK, WEDGE)[seed % 3], (CUBE, BRICK, WEDGE)[seed // 3 % 3]
    T_a, T_b = (from_rotation_translation(R, rng.uniform(-0.5, 0.5, 3)) for R in random_rotations(rng, 2))
    while solid_overlap(a, T_a, b, T_b) > 0.01 * min(a.volume, b.volume):  # until little is shared
        T_b[:3, 3] += 0.01 * (T_b[:3, 3] - T_a[:3, 3]) / np.linalg.norm(T_b[:3, 3] - T_a[:3, 3])
    found, back = reach(a, T_a, b, T_b), reach(b, T_b, a, T_a)
    if found is None:
        assert back is None
        return
    assert back.depth == pytest.approx(found.depth, rel=1e-6, abs=1e-9)
    assert abs(back.way @ found.way) == pytest.approx(1.0, abs=1e-6)
    before, moved = solid_overlap(a, T_a, b, T_b), T_b.copy()
    moved[:3, 3] += found.depth * found.way
    assert solid_overlap(a, T_a, b, moved) < 0.1 * before


def test_the_least_width_of_a_brick_is_its_thickness():
    """By hand; turned, the same; and points in a plane have none."""
    corners = np.array([[x, y, z] for x in (0, 3) for y in (0, 2) for z in (0, 0.5)], float)
    for R in [np.eye(3), *random_rotations(np.random.default_rng(3), 5)]:
        width, way = least_width(corners @ R.T)
        assert width == pytest.approx(0.5)
        assert abs(way @ R[:, 2]) == pytest.approx(1.0)
    assert least_width(corners * [1, 1, 0]) is None
    assert least_width(corners[:2]) is None


def test_two_that_interlock_reach_into_each_other_piece_by_piece():
    """A block too wide for the U by 1 mm on either side: two slabs of 1 mm, where their common hull is a metre wide."""
    you, block = Solid(*bracket()), Solid(*box(1.202, 0.5, 0.8))
    found = reaches(you, np.eye(4), block, at(0, 0.3, 0))
    assert [one.depth for one in found] == pytest.approx([0.001, 0.001], abs=1e-7)
    assert {round(one.at[0], 3) for one in found} == {-0.6, 0.6}
    assert reach(you, np.eye(4), block, at(0, 0.3, 0)).depth == pytest.approx(0.001, abs=1e-7)
