"""View cells: what a type looks like from all around (§6.3, convergence)."""

import numpy as np
import pytest
from synthetic import perceiver, towers

from geometry.camera import Camera
from geometry.frames import from_rotation_translation, transform_points
from kb.clouds.lobes import feature_in_lobe
from plogic.match.hand.view_cells import DISTANCE, fibonacci_sphere, looking_back, view_cells

NAMES = ("t1", "t2")


def cells_of(name):
    return perceiver().models[name].cells


@pytest.mark.parametrize("number", [2, 42, 162])
def test_directions_are_unit_and_cover_the_sphere(number):
    directions = fibonacci_sphere(number)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1.0)
    assert np.allclose(directions.mean(axis=0), 0.0, atol=1.0 / number)


def test_every_direction_has_a_cell_nearby():
    rng = np.random.default_rng(1)
    anywhere = rng.normal(size=(2000, 3))
    anywhere /= np.linalg.norm(anywhere, axis=1, keepdims=True)
    cells = cells_of("t1")
    nearest = cells.directions[cells.nearest(anywhere)]
    off = np.degrees(np.arccos((nearest * anywhere).sum(axis=1)))
    assert np.percentile(off, 90) < 9.0
    assert off.max() < 12.0


def test_a_cell_is_nearest_to_its_own_direction():
    cells = cells_of("t2")
    assert cells.nearest(cells.directions).tolist() == list(range(len(cells.directions)))


def test_cameras_look_back_at_the_centre_with_a_proper_rotation():
    directions = np.vstack([fibonacci_sphere(50), [[0, 0, 1], [0, 0, -1]]])
    rotations = looking_back(directions)
    assert np.allclose(np.einsum("cij,cj->ci", rotations, directions), [0, 0, -1])
    assert np.allclose(rotations @ np.swapaxes(rotations, 1, 2), np.eye(3))
    assert np.allclose(np.linalg.det(rotations), 1.0)
    upright = rotations[:50] @ np.array([0.0, 0.0, 1.0])
    assert (upright[:, 1] < 0).all(), "the object's z is up on the screen: y points down"


@pytest.mark.parametrize("name", NAMES)
def test_xy_is_the_picture_that_a_camera_takes_from_there(name):
    """An oracle by the project's own camera, whose focal length is the distance.

    Pixels are metres in the plane through the centre.
    """
    cells, kind = cells_of(name), towers().type(name)
    distance = DISTANCE * cells.diameter
    camera = Camera(100, 100, np.diag([distance, distance, 1.0]))
    for c in (0, 40, 80, 161):
        viewpoint = cells.centre + distance * cells.directions[c]
        rotation = cells.cell_from_object[c]
        pose = from_rotation_translation(rotation, -rotation @ viewpoint)
        assert np.allclose(
            camera.project(transform_points(pose, [f.at for f in kind.features])), cells.xy[c], atol=1e-9
        )


@pytest.mark.parametrize("name", NAMES)
def test_what_one_cell_shows_converges(name):
    """The lobes of the features that a cell shows contain one common viewpoint (§6.3)."""
    cells, kind = cells_of(name), towers().type(name)
    viewpoints = cells.centre + DISTANCE * cells.diameter * cells.directions
    assert cells.visible.any(axis=1).sum() > 100
    for seen, viewpoint in zip(cells.visible, viewpoints, strict=True):
        assert feature_in_lobe(kind.lobes, viewpoint)[:, seen].all()


@pytest.mark.parametrize("name", NAMES)
def test_opposite_walls_are_never_seen_together(name):
    kind, cells = towers().type(name), cells_of(name)
    normals = np.array(
        [f.rotation @ f.appearances[0].lobe.axis if f.type == "patch" else np.zeros(3) for f in kind.features]
    )
    opposite = normals @ normals.T < -0.99
    assert opposite.any()
    together = cells.visible.astype(int).T @ cells.visible.astype(int)
    assert not together[opposite].any()


def test_arms_point_along_edges_that_are_seen():
    """From above, every edge of t2's apex runs down the roof: four arms, and none from straight below."""
    cells = cells_of("t2")
    apex = next(i for i, f in enumerate(towers().type("t2").features) if f.type == "apex")
    above, below = int(cells.directions[:, 2].argmax()), int(cells.directions[:, 2].argmin())
    assert np.isfinite(cells.arms[above, apex]).sum() == 4
    assert not np.isfinite(cells.arms[below, apex]).any()


def test_fewer_cells_are_the_same_kind_of_table():
    cells = view_cells(towers().type("t1"), number=7)
    assert cells.directions.shape == (7, 3)
    assert cells.xy.shape == (7, 58, 2)
    assert cells.visible.shape == (7, 58)
