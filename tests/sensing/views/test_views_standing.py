"""A body without print that stands on a known plane is found there, and what is found there stands about."""

from __future__ import annotations

import numpy as np
import pytest
from test_views_search import CAMERA, PAINT, photographed

from geometry.bodies.resting import Plane, resting_faces
from geometry.bodies.standing import Area, Known, log_ratios, ways
from geometry.frames import compose, look_at, pose_error, turn_about
from geometry.frames import from_rotation_translation as posed_at
from sensing.views.maps import PhotoMaps, TypeMaps
from sensing.views.search import Body
from sensing.views.standing import BLOCK, everywhere_on, spread, stood
from sensing.views.views import views_of

FACES = resting_faces(PAINT.mesh.vertices)


@pytest.fixture(scope="module")
def views():
    return views_of(PAINT, 200)


def on_table(seed):
    """The chair on a table, and the table, camera frame."""
    rng = np.random.default_rng(seed)
    eye = look_at([0.2 * rng.normal(), -0.45, 0.35], [0.0, 0.0, 0.03])
    table = Plane(eye[:3, 2], float(-eye[:3, 2] @ eye[:3, 3]))
    place = posed_at(turn_about([0.0, 0.0, 1.0], rng.uniform(0, 6)), [*rng.uniform(-0.05, 0.05, 2), 0.0])
    return compose(eye, place), table


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_stands_on_a_plane_is_among_the_first_found_there(views, seed):
    pose, table = on_table(seed)
    body = Body(views, PAINT.middle, PAINT.diameter)
    found, scores = stood(
        TypeMaps(PhotoMaps(photographed(pose, seed)), views), CAMERA, body, Known(table, np.eye(3)), FACES, 10
    )
    assert (np.diff(scores) <= 0.0).all()
    off = [pose_error(one, pose) for one in found]
    assert any(angle < np.radians(25.0) and move < 0.15 * pose[2, 3] for angle, move in off)


def test_where_a_climb_ends_most_stand_about(views):
    pose, table = on_table(5)
    body = Body(views, PAINT.middle, PAINT.diameter)
    found, _ = stood(
        TypeMaps(PhotoMaps(photographed(pose, 5)), views), CAMERA, body, Known(table, np.eye(3)), FACES, 20
    )
    stands = [ways(0, FACES, one, PAINT.middle, 0.3, np.eye(3) * 0.04**2) for one in found]
    assert np.mean([len(some.face) > 0 and log_ratios(some, table).max() > 0.0 for some in stands]) > 0.5


def test_on_a_top_is_found_what_stands_there_and_nothing_elsewhere(views):
    pose, table = on_table(1)
    body = Body(views, PAINT.middle, PAINT.diameter)
    maps, foot = TypeMaps(PhotoMaps(photographed(pose, 1)), views), pose[:3, 3]
    known = Known(table, np.eye(3), area=Area(foot - table.height(foot) * table.up, 0.03))
    found, _ = stood(maps, CAMERA, body, known, FACES, 10)
    off = [pose_error(one, pose) for one in found]
    assert any(angle < np.radians(25.0) and move < 0.15 * pose[2, 3] for angle, move in off)
    laid, whole = (everywhere_on(maps, CAMERA, body, some, FACES) for some in (known, known._replace(area=None)))
    at = CAMERA.normalised(laid[:, 3:5])
    seen = np.column_stack([at, np.ones(len(at))]) * (CAMERA.f * body.diameter / laid[:, 2])[:, None]
    assert known.over(seen, 2.0 * BLOCK * seen[:, 2] / CAMERA.f).all()  # in a square of which something is over it
    assert 0 < len(laid) < len(whole)
    away = known._replace(area=Area(known.area.at + 5.0, 0.03))
    assert not len(stood(maps, CAMERA, body, away, FACES, 10)[0])


def test_no_plane_before_the_camera_gives_nothing(views):
    pose, _ = on_table(1)
    above = Plane(np.array([0.0, 0.0, 1.0]), 0.5)  # behind the camera
    found, _ = stood(
        PhotoMaps(photographed(pose, 1)),
        CAMERA,
        Body(views, PAINT.middle, PAINT.diameter),
        Known(above, np.eye(3)),
        FACES,
        10,
    )
    assert not len(found)


def test_faces_that_are_laid_down_are_apart():
    angles = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    rim = np.column_stack([np.cos(angles), np.sin(angles)])
    can = np.concatenate([np.column_stack([rim, np.full(60, z)]) for z in (-1.0, 1.0)]) * 0.04
    faces = resting_faces(can)
    some = spread(faces)
    assert 8 < len(some) < len(faces.reach)
