"""What a vertex looks like, and from where."""

from collections import Counter

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.author.junctions import arms, enclosing_cone, junction_kinds, junctions
from benchmarks.author.towers import t2
from geometry.cones import even_directions, spacing
from kb.surfaces.surface import Surface, welded


@pytest.fixture(scope="module")
def cuboid() -> Surface:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    return welded(np.array(box.vertices), np.array(box.faces))


def random_directions(count: int, seed: int = 3):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("vertex", range(8))
def test_a_cuboids_corner_has_one_y_three_arrows_three_ls(cuboid, vertex):
    found = junctions(cuboid, vertex)
    assert Counter(r.kind for r in found) == {"y_junction": 1, "arrow_junction": 3, "l_junction": 3}
    for region in found:
        assert region.share == pytest.approx(1 / 8, abs=0.003)
        assert np.degrees(region.half_angle) == pytest.approx(54.74, abs=1.5)
        assert np.abs(region.axis) == pytest.approx(np.full(3, 1 / np.sqrt(3)), abs=0.02)
    (y,) = (r for r in found if r.kind == "y_junction")
    assert y.axis == pytest.approx(np.sign(cuboid.vertices[vertex]) / np.sqrt(3), abs=0.02)


def test_a_cuboids_arms_are_its_edges_and_not_its_diagonals(cuboid):
    assert sorted(np.abs(arms(cuboid, 0)).argmax(axis=1)) == [0, 1, 2]
    assert np.abs(arms(cuboid, 0)).sum() == pytest.approx(3)


@pytest.mark.parametrize("vertex", [0, 4, 8])
def test_cones_enclose_their_kinds(vertex):
    surface, directions = t2().surface, random_directions(5000)
    regions, kinds = junctions(surface, vertex), junction_kinds(surface, vertex, directions)
    assert set(kinds) - {"", "t_junction"}
    for kind in set(kinds) - {"", "t_junction"}:
        inside = [directions @ r.axis >= np.cos(r.half_angle) for r in regions if r.kind == kind]
        assert np.any(inside, axis=0)[kinds == kind].all()


def test_an_apex_is_multi_from_above_and_an_arrow_from_the_side_below():
    surface = t2().surface
    assert arms(surface, 8).shape == (4, 3)
    kinds = junction_kinds(surface, 8, np.array([[0.1, 0.05, 1.0], [1, 0.9, -0.2], [1, 0.1, -0.5], [0, 0.1, -1]]))
    assert kinds.tolist() == ["multi_junction", "arrow_junction", "l_junction", ""]


def test_a_straight_gap_makes_a_t():
    """A corner between Y and arrow: its top is seen edge-on, so that the top's two edges lie in one line."""
    ground = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    box = np.vstack([np.column_stack([ground, np.full(4, z)]) for z in (0.0, 1.0)])
    block = trimesh.Trimesh(box, trimesh.convex.convex_hull(box).faces, process=False)
    surface = welded(np.array(block.vertices), np.array(block.faces))
    corner = int(np.linalg.norm(surface.vertices - 1, axis=1).argmin())
    edge_on = np.array([[1.0, 1.0, 1e-9]])
    assert junction_kinds(surface, corner, edge_on).tolist() == ["t_junction"]


@given(st.integers(1, 60), st.integers(0, 10_000), st.floats(0.05, 1.5))
@settings(max_examples=60, deadline=None)
def test_the_least_cone_encloses_and_no_nearby_axis_does_better(count, seed, reach):
    toward = random_directions(1, seed)[0]
    points = toward + np.tan(min(reach, 1.4)) * 0.5 * random_directions(count, seed + 1)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    axis, half_angle = enclosing_cone(points)
    assert np.linalg.norm(axis) == pytest.approx(1)
    assert (points @ axis >= np.cos(half_angle) - 1e-9).all()
    for nudge in random_directions(40, seed + 2):
        other = axis + 0.01 * nudge
        assert (points @ other / np.linalg.norm(other)).min() <= np.cos(half_angle) + 1e-9


def test_even_directions_are_even():
    for count in (1, 12, 80, 500):
        some = even_directions(count)
        np.testing.assert_allclose(np.linalg.norm(some, axis=1), 1.0)
        if count > 1:
            nearest = np.sort(np.arccos(np.clip(some @ some.T, -1, 1)), axis=1)[:, 1]
            assert nearest.min() > 0.6 * spacing(count)
            assert nearest.max() < 1.2 * spacing(count)
