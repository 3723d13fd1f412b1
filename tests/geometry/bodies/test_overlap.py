import numpy as np
import pytest
from geometry_bodies import at, bodies, box, bracket, random_rotations, wedge
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.overlap import Solid, solid_overlap
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, inverse, transform_points
from geometry.visibility.rays import RayMesh

CUBE = Solid(*box())
shifts = st.floats(-1.5, 1.5)


@settings(max_examples=50, deadline=None)
@given(shifts, shifts, shifts, st.integers(0, 99))
def test_two_cubes_share_the_box_computed_by_hand(x, y, z, seed):
    world_from_a = from_rotation_translation(random_rotations(np.random.default_rng(seed), 1)[0], [3, -2, 7])
    expected = float(np.prod(np.maximum(0, 1 - np.abs([x, y, z]))))
    assert solid_overlap(CUBE, world_from_a, CUBE, world_from_a @ at(x, y, z)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("shift", [(1, 0, 0), (0, -1, 0.3), (0.2, 0.4, 1), (1, 1, 0), (1, 1, 1)])
@pytest.mark.parametrize("seed", range(4))
def test_touching_bodies_share_nothing(shift, seed):
    world_from_a = from_rotation_translation(random_rotations(np.random.default_rng(seed), 1)[0], [3, -2, 7])
    assert solid_overlap(CUBE, world_from_a, CUBE, world_from_a @ at(*shift)) == 0.0


def test_sharing_is_symmetric_and_bounded_by_the_smaller_volume():
    rng = np.random.default_rng(1)
    solids = [Solid(*body) for body in bodies()]
    turns = random_rotations(rng, 60)
    volumes = []
    for k, R in enumerate(turns):
        a, b, T = solids[k % 3], solids[k // 3 % 3], from_rotation_translation(R, rng.uniform(-0.6, 0.6, 3))
        ab, ba = solid_overlap(a, np.eye(4), b, T), solid_overlap(b, T, a, np.eye(4))
        volumes.append(ab)
        assert ab == pytest.approx(ba, rel=1e-6, abs=1e-9)
        assert 0 <= ab <= min(a.volume, b.volume) * (1 + 1e-9)
    assert sum(volume > 0 for volume in volumes) > 20
    assert solids[1].volume == pytest.approx(0.8 * 0.6 * 1.3)


def test_shared_volume_equals_a_count_of_points():
    """Oracle: points drawn in a's box, inside both by the parity of a ray's first hits from within."""
    rng = np.random.default_rng(2)
    T = from_rotation_translation(random_rotations(rng, 1)[0], [0.1, 0.0, 0.4])
    a, b = box(0.8, 0.6, 1.2), wedge()
    points = rng.uniform([-0.4, -0.3, 0], [0.4, 0.3, 1.2], (40_000, 3))
    within = inside_convex(b, transform_points(inverse(T), points))
    expected = within.mean() * 0.8 * 0.6 * 1.2
    assert 0.05 < within.mean() < 0.95
    assert solid_overlap(Solid(*a), np.eye(4), Solid(*b), T) == pytest.approx(expected, abs=0.01)


def inside_convex(body, points):
    """Within a convex body each of two opposite rays meets it."""
    mesh = RayMesh(*body)
    up = np.broadcast_to([0.01, 0.02, 1.0], points.shape)
    return np.isfinite(mesh.first_hit(points, up)) & np.isfinite(mesh.first_hit(points, -up))


def test_a_body_in_the_hollow_of_another_shares_nothing():
    u, block = Solid(*bracket()), Solid(*box(1.0, 0.5, 0.8))
    assert solid_overlap(u, np.eye(4), block, at(0, 0.3, 0)) == 0.0
    assert solid_overlap(u, np.eye(4), block, at(0, 0, 0)) > 0.0


def test_surfaces_that_are_no_solids_are_named():
    vertices, triangles = box()
    with pytest.raises(GeometryError, match="closed and manifold"):
        Solid(vertices, triangles[1:])
    with pytest.raises(GeometryError, match="facets outward"):
        Solid(vertices, triangles[:, ::-1])
