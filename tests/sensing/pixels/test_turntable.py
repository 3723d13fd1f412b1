"""Pictures of one body from all around: depth, mask and camera agree with the mesh, whatever its size."""

import numpy as np
import pytest
from painted_cube import SIDE, cube

from geometry.cones import even_directions
from geometry.frames import inverse, transform_points
from geometry.visibility.rays import RayMesh
from sensing.pixels.turntable import FINER, turned
from sensing.simulated.body import TexturedMesh
from sensing.simulated.camera import extent

PIXELS, MARGIN, AWAY = 90.0, 0.125, 5.0


def pictures(mesh, viewpoints):
    return list(turned(mesh, viewpoints, PIXELS, MARGIN, AWAY))


def tetrahedron(size=0.2):
    vertices = np.array([[0, 0, 0], [1, 0.1, 0], [0.2, 0.8, 0.1], [0.3, 0.2, 0.9]]) * size
    return TexturedMesh(vertices, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))


@pytest.mark.parametrize("mesh", [cube(), tetrahedron(), cube(middle=(3.0, -2.0, 7.0))])
def test_depth_is_where_rays_meet_the_mesh(mesh):
    diameter, rays = extent(mesh.vertices)[1], RayMesh(mesh.vertices, mesh.triangles)
    rng = np.random.default_rng(0)
    turns = list(pictures(mesh, even_directions(5)))
    assert len(turns) == 5
    for turn in turns:
        assert turn.pixels == FINER * PIXELS
        v, u = np.nonzero(turn.mask)
        some = rng.choice(len(u), 200, replace=False)
        place = np.column_stack([u[some], v[some]]).astype(float)
        there = np.column_stack([turn.camera.normalised(place), np.ones(200)]) * turn.depth[v[some], u[some]][:, None]
        at = transform_points(turn.camera.world_from_camera, there)
        viewpoint = turn.camera.world_from_camera[:3, 3]
        line = at - viewpoint
        distance = rays.first_hit(np.broadcast_to(viewpoint, at.shape), line)
        hit = np.isfinite(distance)
        assert hit.mean() > 0.97  # a pixel at the outline may miss
        off = np.abs(distance[hit] - np.linalg.norm(line[hit], axis=1)) / diameter
        assert np.quantile(off, 0.97) < 1e-3


def between(depth, uv):
    """Depth at places (N, 2) between pixels."""
    low = np.floor(uv).astype(int)
    (u, v), (a, b) = low.T, (uv - low).T
    return (depth[v, u] * (1 - a) + depth[v, u + 1] * a) * (1 - b) + (
        depth[v + 1, u] * (1 - a) + depth[v + 1, u + 1] * a
    ) * b


@pytest.mark.parametrize("mesh", [cube(), tetrahedron()])
def test_visible_points_of_the_mesh_project_to_their_own_depth(mesh):
    diameter, rays, checked = extent(mesh.vertices)[1], RayMesh(mesh.vertices, mesh.triangles), 0
    middle = mesh.corners.mean(axis=1)
    for turn in pictures(mesh, even_directions(6)):
        viewpoint = turn.camera.world_from_camera[:3, 3]
        towards = viewpoint - middle
        steep = (mesh.normals * towards).sum(axis=1) > 0.25 * np.linalg.norm(towards, axis=1)
        at = transform_points(
            inverse(turn.camera.world_from_camera), middle[steep & ~rays.blocks(viewpoint, middle, 1e-6 * diameter)]
        )
        assert np.abs(between(turn.depth, turn.camera.project(at)) - at[:, 2]).max() < 1e-3 * diameter
        checked += len(at)
    assert checked > 6


@pytest.mark.parametrize("margin", [0.0, 0.03, MARGIN, 1.25])
def test_the_body_and_its_margin_fill_the_picture_and_no_more(margin):
    seen = set()
    for turn in turned(cube(), even_directions(9), PIXELS, margin, AWAY):
        height, width = turn.mask.shape
        assert turn.image.shape == (height, width, 3)
        assert turn.depth.shape == (height, width)
        assert (turn.camera.width, turn.camera.height) == (width, height)
        v, u = np.nonzero(turn.mask)
        left = np.array([u.min(), v.min(), width - 1 - u.max(), height - 1 - v.max()])
        assert (left >= round(margin * turn.pixels)).all()
        assert (left <= round(margin * turn.pixels) + 2).all()  # a corner may have no pixel's centre in it
        assert max(np.ptp(u), np.ptp(v)) > 0.5 * turn.pixels
        distance = np.linalg.norm(turn.camera.world_from_camera[:3, 3])
        assert distance == pytest.approx(AWAY * SIDE * 3**0.5)
        seen.add((height, width))
    assert len(seen) > 3


@pytest.mark.parametrize("side", [0.01, 1.0, 50.0])
def test_dice_and_buildings_give_the_same_picture(side):
    viewpoints = [*even_directions(3), np.array([0.0, 0, 1]), np.array([0.0, 0, -1])]
    pairs = list(zip(pictures(cube(), viewpoints), pictures(cube(side), viewpoints), strict=True))
    assert len(pairs) == 5
    for one, other in pairs:
        assert (one.mask != other.mask).mean() < 1e-3
        assert np.abs(one.image.astype(int) - other.image).mean() < 0.1
        both = one.mask & other.mask
        np.testing.assert_allclose(other.depth[both] / side, one.depth[both] / SIDE, rtol=1e-3)
        np.testing.assert_allclose(other.camera.K, one.camera.K)


def test_faces_are_as_bright_as_their_paint():
    """No lamp: learning makes its own light."""
    grey = TexturedMesh(cube().vertices, cube().triangles, colour=(0.5, 0.5, 0.5))
    turn = pictures(grey, [np.array([0.6, 0.5, 0.62])])[0]
    own = turn.image[turn.mask]
    assert np.ptp(own) <= 2
    assert abs(float(own.mean()) - 127.5) < 8
