"""The likeliest plane in the picture: a grid that lies in it, and a foot of each object that stands there."""

import numpy as np
import pytest
import shapely

from geometry.camera import camera_from_dict
from plogic.face.shown.ground import EXACT, POINTS, draw_ground, ground_of, lines_in_picture
from plogic.face.shown.overlay import pencil_on

CAMERA = {"width": 640, "height": 480, "K": [[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1.0]], "dist": []}
UP = np.array([0.0, -0.8, -0.6])


def document(probability=0.9, **standing):
    return {
        "camera": CAMERA,
        "space": {"bodies": [{"id": "h1", "middle": [0.0, 0.1, 1.0]}, {"id": "h2", "middle": [0.2, 0.1, 1.1]}]},
        "hypotheses": [{"id": "h1", "status": "accepted"}, {"id": "h2", "status": "accepted"}],
        "support_planes": [
            {
                "name": "s1",
                "plane": {"normal": UP.tolist(), "offset": -0.75},
                "probability": probability,
                "standing": standing or {"h1": 0.95, "h2": 0.2},
            }
        ],
    }


def test_lines_and_feet_lie_in_the_plane_and_feet_below_what_stands():
    ground = ground_of(document())
    assert set(ground.feet) == {"h1"}
    assert ground.lines.shape[1:] == (POINTS, 3)
    np.testing.assert_allclose(ground.lines @ UP, -0.75, atol=1e-9)
    foot = ground.feet["h1"]
    assert foot @ UP == pytest.approx(-0.75)
    np.testing.assert_allclose(np.cross([0.0, 0.1, 1.0] - foot, UP), 0.0, atol=1e-9)


def test_an_unlikely_plane_and_one_on_which_nothing_stands_are_not_drawn():
    assert ground_of(document(0.3)) is None
    assert ground_of(document(h1=0.1)) is None
    assert ground_of({"camera": CAMERA}) is None


def test_the_picture_changes_where_the_grid_is_and_at_the_foot():
    pencil = pencil_on(CAMERA, None)
    before = pencil.picture.copy()
    ground = draw_ground(pencil, document(), {"h1": (0, 200, 0), "h2": (200, 0, 0)})
    changed = (pencil.picture != before).any(axis=2)
    foot = np.array([600.0, 600.0]) * ground.feet["h1"][:2] / ground.feet["h1"][2] + [319.5, 239.5]
    x, y = np.rint((foot + 0.5) * pencil.scale).astype(int)
    assert changed[y - 3 : y + 4, x - 3 : x + 4].any()
    assert 0.005 < changed.mean() < 0.5


def test_a_lens_bends_the_lines():
    ground = ground_of(document())
    for dist, most in (([], 2), ([-0.3, 0.1, 0.0, 0.0], POINTS)):
        camera = camera_from_dict(CAMERA | {"dist": dist})
        lines = lines_in_picture(ground, camera)
        assert len(lines) == len(ground.lines)
        assert max(map(len, lines)) <= most
        assert (max(map(len, lines)) > 2) == bool(dist)
        for line, points in zip(lines, ground.lines, strict=True):
            off = shapely.distance(shapely.linestrings(line), shapely.points(camera.project(points)))
            assert off.max() <= EXACT + 1e-9


def test_lines_that_reach_behind_the_camera_are_left_out():
    ground = ground_of(document())
    behind = ground._replace(lines=ground.lines - [0.0, 0.0, ground.lines[..., 2].min() + 0.1])
    assert 0 < len(lines_in_picture(behind, camera_from_dict(CAMERA))) < len(ground.lines)
