"""A body without print before clutter is found where it is; its views are kept."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from geometry.camera import centred_camera
from geometry.frames import compose, inverse, look_at, pose_error
from geometry.frames import from_rotation_translation as posed_at
from sensing.pixels.drawn import Paint
from sensing.pixels.photo import lab_of
from sensing.simulated.body import TexturedMesh
from sensing.views.kept import kept_views
from sensing.views.maps import LAB, PhotoMaps, lit
from sensing.views.search import Body, searched
from sensing.views.views import INSIDE, OUTLINE, OUTSIDE, views_of

CAMERA = centred_camera((320, 240), 300.0)
ORANGE = np.full((8, 8, 3), (40, 110, 220), np.uint8)


def a_chair():
    """A seat with a back, of boxes, one colour."""
    boxes = [((-0.05, -0.05, 0.0), (0.05, 0.05, 0.04)), ((-0.05, 0.02, 0.04), (0.05, 0.05, 0.12))]
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    vertices = np.concatenate([np.array(low) + corners * (np.array(high) - low) for low, high in boxes])
    return TexturedMesh(vertices, np.concatenate([triangles, triangles + 8]), np.full((16, 2), 0.5), ORANGE)


PAINT = Paint(a_chair())


@pytest.fixture(scope="module")
def views():
    return views_of(PAINT, 200)


def photographed(pose, seed):
    rng = np.random.default_rng(seed)
    image = cv2.resize(rng.integers(0, 255, (24, 32, 3)).astype(np.uint8), (320, 240), interpolation=cv2.INTER_CUBIC)
    drawn = PAINT.drawn(pose, CAMERA.K, (320, 240))
    light = 0.6 + 0.4 * np.abs(drawn.normal[..., 2:])
    image = np.where(drawn.mask[..., None], drawn.colour * light, image)
    return np.clip(image + rng.normal(0.0, 4.0, image.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_plain_body_in_clutter_is_among_the_first(views, seed):
    rng = np.random.default_rng(seed)
    away = look_at([0.3 * rng.normal(), -0.4, 0.3], PAINT.middle)
    pose = compose(posed_at(np.eye(3), [rng.uniform(-0.08, 0.08), 0.0, 0.0]), away)
    found, scores = searched(PhotoMaps(photographed(pose, seed)), CAMERA, Body(views, PAINT.middle, PAINT.diameter), 10)
    assert (np.diff(scores) <= 0.0).all()
    off = [pose_error(one, pose) for one in found]
    depth = [abs((one @ inverse(pose))[2, 3]) for one in found]
    assert len(depth) == len(found)
    assert any(angle < np.radians(25.0) and move < 0.15 * pose[2, 3] for angle, move in off)


def test_the_same_photo_gives_the_same_poses(views):
    photo = PhotoMaps(photographed(look_at([0.1, -0.4, 0.3], PAINT.middle), 4))
    body = Body(views, PAINT.middle, PAINT.diameter)
    first, second = (searched(photo, CAMERA, body, 5) for _ in range(2))
    assert len(first[0]) == 5
    assert all((a == b).all() for a, b in zip(first, second, strict=True))


def test_a_view_has_its_outline_around_its_inside(views):
    assert len(views.at) == 200
    for v in range(0, 200, 17):
        rim, inside, outside = (views.at[v][views.kind[v] == kind] for kind in (OUTLINE, INSIDE, OUTSIDE))
        hull = cv2.convexHull((rim * 1000).astype(np.float32))
        assert len(rim) > 20 < len(inside)
        assert all(cv2.pointPolygonTest(hull, (at * 1000).tolist(), measureDist=True) >= -10.0 for at in inside)
        assert np.linalg.norm(np.concatenate([rim, outside]), axis=1).max() < 0.65


def test_views_are_kept(tmp_path, monkeypatch):
    first = kept_views(PAINT, 20, tmp_path)
    assert len(first.at) == 20
    monkeypatch.setattr("sensing.views.kept.views_of", None)
    again = kept_views(PAINT, 20, tmp_path)
    assert all((a == b).all() for a, b in zip(first, again, strict=True))


def test_a_plate_seen_from_its_edge_has_views_all_the_same():
    corners = np.array([[-0.05, -0.05, 0.0], [0.05, -0.05, 0.0], [0.05, 0.05, 0.0], [-0.05, 0.05, 0.0]])
    plate = Paint(TexturedMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.full((4, 2), 0.5), ORANGE))
    seen = views_of(plate, 101)  # the middle one looks along it
    number = (seen.kind == OUTLINE).sum(axis=1)
    assert number[50] < 10 < np.median(number)


def test_a_photo_without_colours_is_asked_for_the_brightness_of_the_paint():
    """Orange before a camera without colours is grey, as bright as it was, and not what an orange photo shows."""
    lab = lab_of(ORANGE[:1, :1].astype(np.float32))
    grey, colour = (lit(lab[0, 0], grey=without).reshape(LAB[0]) for without in (True, False))
    middle = int(LAB[2] / LAB[1])
    neutral = np.s_[:, middle - 2 : middle + 3, middle - 2 : middle + 3]
    assert grey[neutral].sum() > 0.9
    assert colour[neutral].sum() < 0.1
    bright = np.arange(LAB[0][0])
    assert abs((bright * grey.sum(axis=(1, 2))).sum() - (bright * colour.sum(axis=(1, 2))).sum()) < 2.0
    assert PhotoMaps(np.full((8, 8, 3), 7, np.uint8)).grey
