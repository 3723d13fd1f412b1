"""The gap between two bodies: by hand, against a search of all, symmetric, and from a place to a body."""

import numpy as np
import pytest
import trimesh
from geometry_bodies import at, bodies, box, posed, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.overlap import Solid, _followed, distance, gap, nearest_places
from geometry.frames import from_rotation_translation, transform_points

QUICK = settings(max_examples=40, deadline=None, derandomize=True)


def pair(seed):
    rng = np.random.default_rng(seed)
    x, y = (bodies()[k] for k in rng.integers(0, 3, 2))
    R, Q = random_rotations(rng, 2)
    return (x, from_rotation_translation(R, [0, 0, 5])), (
        y,
        from_rotation_translation(Q, np.add([0, 0, 5], rng.uniform(-2, 2, 3))),
    )


@pytest.mark.parametrize(
    ("shift", "expected"),
    [((1.5, 0, 0), 0.5), ((1, 0, 0), 0.0), ((0.5, 0, 0), 0.0), ((1.3, 1.4, 0), 0.5), ((0.1, 0, -3), 2.0)],
)
def test_of_two_cubes_by_hand(shift, expected):
    x, y = posed(box(), at(0, 0, 5)), posed(box(), at(*np.add(shift, [0, 0, 5])))
    solids = Solid(*box()), Solid(*box())
    assert gap(x, y, solids) == pytest.approx(expected, abs=1e-9)


@QUICK
@given(st.integers(0, 9999))
def test_the_gap_is_symmetric_and_following_finds_nearly_it(seed):
    """What is exact for few facets is the oracle of what is done with many."""
    (x, T_x), (y, T_y) = pair(seed)
    one, other, a, b = posed(x, T_x), posed(y, T_y), Solid(*x), Solid(*y)
    exact = gap(one, other, (a, b))
    assert gap(other, one, (b, a)) == pytest.approx(exact, abs=1e-6)
    if exact > 0.0:
        assert exact - 1e-6 <= _followed(one, other, one.object_from_camera @ other.camera_from_object) <= exact + 0.05


def test_balls_of_many_facets():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.5)
    x, y = (posed((ball.vertices, ball.faces), at(*place)) for place in ([0, 0, 3], [1.5, 0.2, 3]))
    solid = Solid(ball.vertices, ball.faces)
    assert gap(x, y, (solid, solid)) == pytest.approx(np.hypot(1.5, 0.2) - 1.0, abs=0.005)
    assert gap(x, y) == gap(x, y, (solid, solid))
    assert distance(x) == pytest.approx(2.5, abs=1e-3)


def test_sheets_that_are_no_solids_have_a_gap():
    sheet = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    assert gap(posed(sheet, at(0, 0, 3)), posed(sheet, at(0.3, 0.1, 3.7))) == pytest.approx(0.7, abs=1e-6)


def test_the_nearest_place_on_a_triangle_is_nearer_than_any_drawn_one():
    rng = np.random.default_rng(3)
    corners, places = rng.normal(size=(50, 3, 3)), rng.normal(size=(20, 3))
    shares = rng.dirichlet([1, 1, 1], 2000)
    assert len(places) == 20
    for place in places:
        found = np.linalg.norm(nearest_places(corners, place) - place, axis=1)
        drawn = np.linalg.norm(np.einsum("kc,tci->tki", shares, corners) - place, axis=2).min(axis=1)
        assert (found <= drawn + 1e-12).all()
        assert (drawn - found < 0.15).all()


def test_a_place_is_as_far_from_a_body_as_in_any_frame():
    T = from_rotation_translation(random_rotations(np.random.default_rng(1), 1)[0], [0.2, 0.1, 4])
    outside = transform_points(T, np.array([[0.0, 0.0, 1.75]]))[0]
    assert distance(posed(box(), T), outside) == pytest.approx(0.75)
