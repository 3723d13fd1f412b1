"""``plogic bench photos``: what is right, found, false, and neither."""

import numpy as np
import pytest

from benchmarks.photos.answers import Shown
from benchmarks.photos.bench import run
from benchmarks.photos.pictures import GREEN, RED, drawn
from benchmarks.photos.scenes import FIRST, photo_scene, photos
from benchmarks.photos.score import Counts, Posed, Told, asked, counted, overlap_of
from benchmarks.photos.table import Measure
from benchmarks.photos.told import EVERY, NAMED, POSED, Forecast, forecasts
from benchmarks.photos.told import bins as told_bins
from benchmarks.photos.told import claims as told_claims
from benchmarks.photos.told import rows as told_rows
from benchmarks.photos.without import in_place
from benchmarks.tabletop.patterns import printed_box
from benchmarks.tabletop.scene import bounds
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
    assert [one[:3] for one in deep[1]] == [
        (1, pytest.approx(0.05 / CUBE.diameter), pytest.approx((0.95 / 1.0) ** 2, abs=0.03))
    ]
    assert told([Posed(1, at(0.1, 0, 1))], [truth])[0] == Counts(1, 0, 0, 1, 0)
    assert told([], [truth]) == (Counts(1, 0, 0, 0, 0), [Told(1)])


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


def test_one_answer_does_not_stand_for_two():
    twins = [Posed(1, at(0, 0, 1)), Posed(1, at(0.2, 0, 1))]
    answer = Posed(1, at(0.195, 0, 1))
    counts, rows = told([answer], twins)
    assert counts == Counts(2, 1, 1, 1, 0)
    assert rows[0] == Told(1)
    assert rows[1].answer is answer


def test_overlap_is_of_outlines():
    one = Posed(1, at(0, 0, 1))
    assert overlap_of(one, one, SURFACE, CAMERA) == 1.0
    assert overlap_of(one, Posed(1, at(0.05, 0, 1)), SURFACE, CAMERA) == pytest.approx(1 / 3, abs=0.05)
    assert overlap_of(one, Posed(1, at(0.5, 0, 1)), SURFACE, CAMERA) == 0.0


def test_without_the_photos_it_says_where_they_should_be(monkeypatch, tmp_path):
    monkeypatch.setattr("benchmarks.photos.bench.FOLDER", tmp_path / "none")
    with pytest.raises(InputError, match="PLOGIC_PHOTOS"):
        run(seed=0, quick=True, as_json=False, say=print)


def test_who_stands_for_an_object_too_hidden_to_be_asked_for_does_not_count():
    truth, hidden = Posed(1, at(0, 0, 1)), Posed(1, at(0.3, 0, 1))
    near, far, other = Posed(1, at(0.01, 0, 1)), Posed(1, at(0.28, 0, 1)), Posed(2, at(0.3, 0, 1))
    assert asked([near, far, other], [truth], [hidden], {1: CUBE, 2: DIE}) == (near, other)
    assert asked([near], [truth], [], {1: CUBE}) == (near,)
    shown = Shown("1", np.zeros((240, 320, 3), np.uint8), CAMERA, (truth,), (hidden, Posed(2, at(0, 0.3, 1))))
    measure = Measure({1: CUBE, 2: DIE}, {1: SURFACE, 2: SURFACE}, {1: "cube", 2: "die"})
    assert measure.counted(shown, [near, far, other])[0] == Counts(1, 1, 1, 1, 0)
    assert measure.counted(shown, [near, far, other], {2})[0] == Counts(0, 0, 0, 0, 0)


def hypothesis(id_, type_, status="accepted", pose=None, **more):
    rows = (np.eye(4) if pose is None else pose).tolist()
    return {"id": id_, "type": type_, "status": status, "T_camera_object": rows, **more}


def test_claims_are_of_worlds_and_of_accepted_poses_of_what_is_there():
    document = {
        "hypotheses": [
            hypothesis("h1", "cube", pose=at(0.01, 0, 1), pose_probability=0.9),
            hypothesis("h2", "cube", "rival", at(0.2, 0, 1), pose_probability=0.4),
            hypothesis("h3", "t1", label="3 die", pose_probability=0.8),
            hypothesis("r1", "ghost", "rejected"),
        ],
        "worlds": [
            {"probability": 0.6, "present": ["h1", "h3"]},
            {"probability": 0.3, "present": ["h2"]},
            {"probability": 0.05, "present": []},
        ],
    }
    shown = Shown("1", np.zeros((240, 320, 3), np.uint8), CAMERA, (Posed(1, at(0, 0, 1)),), (), (4,))
    told = list(forecasts(document, {"cube": 1, "3 die": 3, "ghost": 4}, shown, {1: CUBE}))
    assert [tuple(one) for one in told] == [
        ("1", EVERY, pytest.approx(0.9), True),
        ("1", NAMED, pytest.approx(0.9), True),
        ("1", EVERY, 0.6, False),
        ("1", NAMED, 0.6, False),
        ("1", EVERY, 0.0, True),
        ("1", POSED, 0.9, True),
    ]
    far = Shown("1", shown.image, CAMERA, (Posed(1, at(0, 0, 2)),))
    assert not list(forecasts(document, {"cube": 1}, far, {1: CUBE}))[-1].true


def test_claims_of_nothing_are_not_wrong():
    assert [(c.value, c.met) for c in told_claims("none", [], 0.03)] == [(0.0, True)] * 2
    assert told_rows("none", []) == []
    sure = [Forecast(str(i), NAMED, 1.0, i > 0) for i in range(4)]
    assert told_claims("some", sure, 0.3)[0].value == 0.25
    row = told_rows("some", sure)[0]
    assert (row["forecasts"], row["mean P"], row["true"], row["low"]) == (4, 1.0, 0.75, 0.0)
    assert [(b["from"], b["true"], b["forecasts"]) for b in told_bins("some", sure)] == [(1.0, 0.75, 4)]


def test_what_overlaps_a_removed_object_is_in_its_place_unless_its_own_stands_there():
    removed, own = Posed(1, at(0, 0, 1)), Posed(2, at(0.03, 0, 0.9))
    shown = Shown("1", np.zeros((240, 320, 3), np.uint8), CAMERA, (removed, own))
    measure = Measure({1: CUBE, 2: DIE}, {2: SURFACE, 1: SURFACE}, {1: "cube", 2: "die"})
    assert in_place((own, Posed(2, at(0.3, 0, 1))), [removed], shown, measure) == []
    [row] = in_place((Posed(2, at(-0.03, 0, 1)),), [removed], shown, measure)
    assert row == {"accepted": "die", "overlap": pytest.approx(0.54, abs=0.05)}


def test_simulated_pictures_are_troubled_and_one_in_six_is_empty():
    rng = np.random.default_rng(2)
    shapes = {1: printed_box(np.array([0.07, 0.06, 0.16]), rng), 11: printed_box(np.array([0.12, 0.1, 0.05]), rng)}
    scenes = [photo_scene([(str(n), mesh) for n, mesh in shapes.items()], FIRST + i, i) for i in range(6)]
    assert [sum(body.label is not None for body in scene.bodies) > 0 for scene in scenes] == [True] * 5 + [False]
    casts = np.array([scene.surroundings.sky_colour for scene in scenes])
    assert np.ptp(casts[:, 0]) > 0.2 < np.ptp(casts[:, 2])
    assert all(60 <= scene.sensor.jpeg < 96 for scene in scenes)
    assert len({scene.sensor.sharpening for scene in scenes}) == 6
    for scene in scenes[:5]:
        for body in scene.bodies:
            low, high = bounds(body, scene.camera)
            assert body.label is None or 40 <= (high - low).max() <= 400
    shown = next(photos(shapes, 1, 0))
    assert shown.camera.world_from_camera is None
    assert {one.obj_id for one in (*shown.truths, *shown.hidden)} <= {1, 11}


def test_a_picture_has_the_truth_dashed_and_answers_by_how_right_they_are():
    truths = [Posed(1, at(-0.2, 0, 1)), Posed(2, at(0.2, 0, 1))]
    answers = [Posed(1, at(-0.2, 0, 1)), Posed(2, at(0.2, 0.06, 1))]
    rows = told(answers, truths)[1]
    bare = np.full((240, 320, 3), 128, np.uint8)
    surfaces, names = {1: SURFACE, 2: SURFACE, 3: SURFACE}, {1: "cube", 2: "die", 3: "ghost"}
    shown = Shown("1/1", bare, CAMERA, tuple(truths))
    picture = drawn(shown, [*answers, Posed(3, at(0, 0, 1.5))], rows, surfaces, names)
    assert picture.shape == (480, 640, 3)
    assert (bare == 128).all()
    left, right = picture[:, :300], picture[:, 340:]
    green, red = ((side == colour).all(-1).sum() for side, colour in ((left, GREEN), (right, RED)))
    assert min(green, red) > 100
    assert not (left == RED).all(-1)[:, :200].any()
    missed = drawn(shown, [], told([], truths)[1], surfaces, names)
    assert 100 < (missed == 255).all(-1).sum() < 5000
