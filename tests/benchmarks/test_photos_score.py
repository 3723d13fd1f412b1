"""``plogic bench photos``: what is right, found, false, and neither."""

import numpy as np
import pytest

from benchmarks.photos.bench import run
from benchmarks.photos.pictures import GREEN, RED, drawn
from benchmarks.photos.score import Counts, Posed, counted, overlap_of
from geometry.camera import Camera
from geometry.visibility.rays import RayMesh
from plogic.base.errors import InputError
from plogic.run.bop.models import Model

CORNERS = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)])
FACES = [
    [0, 1, 2],
    [1, 3, 2],
    [4, 6, 5],
    [5, 6, 7],
    [0, 4, 1],
    [1, 4, 5],
    [2, 3, 6],
    [3, 7, 6],
    [0, 2, 4],
    [2, 6, 4],
    [1, 5, 3],
    [3, 5, 7],
]
CUBE = Model(CORNERS, 0.1 * 3**0.5, np.eye(4)[None])
DIE = Model(CORNERS, 0.1 * 3**0.5, np.stack([np.eye(4), np.diag([-1.0, -1.0, 1.0, 1.0])]))
SURFACE = RayMesh(CORNERS, FACES)
CAMERA = Camera(320, 240, [[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]])


def at(x, y, z, turn=0.0):
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    pose[:3, 3] = x, y, z
    return pose


def told(answers, truths, unposed=()):
    return counted(answers, truths, unposed, {1: CUBE, 2: DIE}, {1: SURFACE, 2: SURFACE}, CAMERA)


def test_right_found_and_wrong():
    truth = Posed(1, at(0, 0, 1))
    assert told([Posed(1, at(0.01, 0, 1))], [truth])[0] == Counts(1, 1, 1, 1, 0)
    deep = told([Posed(1, at(0, 0, 1.05))], [truth])
    assert deep[0] == Counts(1, 0, 1, 1, 0)
    assert deep[1] == [(1, pytest.approx(0.05 / CUBE.diameter), pytest.approx((0.95 / 1.0) ** 2, abs=0.03))]
    assert told([Posed(1, at(0.1, 0, 1))], [truth])[0] == Counts(1, 0, 0, 1, 0)
    assert told([], [truth]) == (Counts(1, 0, 0, 0, 0), [(1, None, None)])


def test_a_symmetric_type_may_be_turned():
    half = np.pi
    assert told([Posed(2, at(0, 0, 1, half))], [Posed(2, at(0, 0, 1))])[0].right == 1
    assert told([Posed(1, at(0, 0, 1, half))], [Posed(1, at(0, 0, 1))])[0].right == 0


def test_what_is_not_there_is_false_unless_it_is_there_without_a_pose():
    answers = [Posed(1, at(0, 0, 1)), Posed(2, at(0.1, 0, 1))]
    counts = told(answers, [Posed(1, at(0, 0, 1))])[0]
    assert counts == Counts(1, 1, 1, 1, 1)
    assert counts.precision == 0.5
    assert told(answers, [Posed(1, at(0, 0, 1))], [2])[0] == Counts(1, 1, 1, 1, 0)
    assert Counts().precision == 1.0
    assert counts + counts == Counts(2, 2, 2, 2, 2)


def test_overlap_is_of_outlines():
    one = Posed(1, at(0, 0, 1))
    assert overlap_of(one, one, SURFACE, CAMERA) == 1.0
    assert overlap_of(one, Posed(1, at(0.05, 0, 1)), SURFACE, CAMERA) == pytest.approx(1 / 3, abs=0.05)
    assert overlap_of(one, Posed(1, at(0.5, 0, 1)), SURFACE, CAMERA) == 0.0


def test_without_the_photos_it_says_where_they_should_be(monkeypatch, tmp_path):
    monkeypatch.setattr("benchmarks.photos.bench.FOLDER", tmp_path / "none")
    with pytest.raises(InputError, match="PLOGIC_PHOTOS"):
        run(seed=0, quick=True, as_json=False, say=print)


def test_a_picture_has_the_truth_dashed_and_answers_by_how_right_they_are():
    truths = [Posed(1, at(-0.2, 0, 1)), Posed(2, at(0.2, 0, 1))]
    answers = [Posed(1, at(-0.2, 0, 1)), Posed(2, at(0.2, 0.06, 1))]
    rows = told(answers, truths)[1]
    bare = np.full((240, 320, 3), 128, np.uint8)
    surfaces, names = {1: SURFACE, 2: SURFACE, 3: SURFACE}, {1: "cube", 2: "die", 3: "ghost"}
    picture = drawn(bare, CAMERA, [*answers, Posed(3, at(0, 0, 1.5))], truths, (), rows, surfaces, names)
    assert picture.shape == (480, 640, 3)
    assert (bare == 128).all()
    left, right = picture[:, :300], picture[:, 340:]
    green, red = ((side == colour).all(-1).sum() for side, colour in ((left, GREEN), (right, RED)))
    assert min(green, red) > 100
    assert not (left == RED).all(-1)[:, :200].any()
    missed = drawn(bare, CAMERA, [], truths, (), told([], truths)[1], surfaces, names)
    assert 100 < (missed == 255).all(-1).sum() < 5000
