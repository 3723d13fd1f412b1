"""Ways to stand, the plane that several agree on, and what contact tells of a pose (formalism §9.9)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.resting import Plane, resting_faces
from geometry.bodies.standing import (
    NOISES,
    Area,
    Contact,
    Known,
    fitted,
    joined,
    log_free,
    log_ratios,
    noise_of,
    noisy,
    ways,
)
from geometry.frames import from_rotation_translation, look_at, turn_about
from sensing.pixels.refine import moved

BOX = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.04, 0.04) for z in (-0.03, 0.03)])
FACES = resting_faces(BOX)
EYE = look_at(np.array([0.5, 0.3, 0.6]), np.zeros(3))
"""camera_from_table: the table's plane is z = 0."""
TABLE = Plane(EYE[:3, 2], float(-EYE[:3, 2] @ EYE[:3, 3]))
TILT, SPREAD = 0.05, np.diag([0.01, 0.01, 0.01]) ** 2


def on_table(x, y, turn=0.0, height=0.0):
    """camera_from_box of a box on the table, its z up, ``height`` m above it."""
    return EYE @ from_rotation_translation(turn_about([0.0, 0.0, 1.0], turn), (x, y, 0.03 + height))


def stands(*poses):
    return joined([ways(k, FACES, pose, np.zeros(3), TILT, SPREAD) for k, pose in enumerate(poses)])


def test_a_camera_sees_from_above_half_of_the_faces_of_a_box_and_each_has_its_plane():
    found = stands(on_table(0.0, 0.0))
    assert len(found.face) == 3
    assert found.chance.sum() == pytest.approx(1.0)
    on = np.argmax(found.up @ TABLE.up)
    np.testing.assert_allclose(found.up[on], TABLE.up, atol=1e-9)
    np.testing.assert_allclose(TABLE.height(found.foot[on]), 0.0, atol=1e-9)
    np.testing.assert_allclose(found.foot[on], (EYE @ [0.0, 0.0, 0.0, 1.0])[:3], atol=1e-9)


@pytest.mark.parametrize("way", range(3))
def test_what_one_body_tells_of_a_plane_is_used_up_by_it(way):
    """The prior of its own plane, known as well as the body tells it, times ρ there is 1: alone it tells nothing."""
    found = stands(on_table(0.1, 0.0))
    plane = Plane(found.up[way], -float(found.up[way] @ found.foot[way]))
    known = fitted(found, np.eye(len(found.face))[way], plane)
    prior = log_free(known.plane.offset) + 1.5 * np.log(2.0 * np.pi) + 0.5 * np.linalg.slogdet(known.covariance)[1]
    assert prior + log_ratios(found, known.plane)[way] == pytest.approx(0.0, abs=0.02)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(1, 5))
def test_the_plane_of_all_is_found_from_one_that_is_near(seed, count):
    rng = np.random.default_rng(seed)
    found = stands(*(on_table(*rng.uniform(-0.2, 0.2, 2), rng.uniform(0, 6)) for _ in range(count)))
    share = (found.up @ TABLE.up > 0.999).astype(float)
    tilt = rng.normal(size=3) * 0.03
    up = TABLE.up + tilt
    known = Known(Plane(up / np.linalg.norm(up), TABLE.offset + 0.02 * rng.normal()), np.eye(3))
    for _ in range(4):
        known = fitted(found, share, known.plane)
    np.testing.assert_allclose(known.plane.up, TABLE.up, atol=2e-3)  # what is known of any plane pulls a little
    assert known.plane.offset == pytest.approx(TABLE.offset, abs=2e-3)
    assert (np.linalg.eigvalsh(known.covariance) > 0.0).all()


def test_what_is_above_or_tilted_is_less_likely_to_stand_there():
    low, high = (log_ratios(stands(on_table(0.0, 0.0, height=h)), TABLE).max() for h in (0.0, 0.05))
    assert low > 0.0 > high
    assert low - high == pytest.approx(0.5 * (0.05 / 0.01) ** 2, rel=1e-6)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_contact_is_the_slope_of_its_density(seed):
    rng = np.random.default_rng(seed)
    contact = Contact(Known(TABLE, np.diag([1e-4, 1e-4, 1e-6])), FACES)
    middle = np.array([0.01, -0.02, 0.005])
    pose = moved(on_table(0.05, 0.1, 1.0), middle, np.concatenate([rng.normal(0, 0.02, 3), rng.normal(0, 0.005, 3)]))
    told, slope = contact.normal(pose, middle)
    steps = 1e-5 * np.eye(6)
    by = [
        (contact.log_density(moved(pose, middle, s), middle) - contact.log_density(moved(pose, middle, -s), middle))
        / 2e-5
        for s in steps
    ]
    np.testing.assert_allclose(slope, by, rtol=0.05, atol=0.05 * np.abs(slope).max())
    np.testing.assert_allclose(told, told.T)
    step = np.linalg.solve(told + 1e-6 * np.eye(6), slope)
    assert contact.log_density(moved(pose, middle, step), middle) > -0.01


def test_what_lies_on_no_face_is_not_moved():
    contact = Contact(Known(TABLE, np.zeros((3, 3))), FACES)
    leaning = on_table(0.0, 0.0)
    leaning[:3, :3] = leaning[:3, :3] @ turn_about([1.0, 0.0, 0.0], np.radians(42.0))
    told, slope = contact.normal(leaning, np.zeros(3))
    assert not told.any()
    assert not slope.any()


def test_a_top_is_the_same_as_one_at_its_height_and_place_alone():
    at = -TABLE.offset * TABLE.up
    top = Known(TABLE, np.eye(3), area=Area(at, 0.1))
    along = np.cross(TABLE.up, [1.0, 0.0, 0.0])
    along /= np.linalg.norm(along)
    moved_by = [top._replace(area=Area(at + far * along, 0.1)) for far in (0.03, 0.07)]
    assert [top.same(other) for other in (top, *moved_by)] == [True, True, False]
    assert not top.same(top._replace(area=None))
    assert not top.same(top._replace(plane=Plane(TABLE.up, 0.9 * TABLE.offset)))
    places = at + np.outer([0.05, 0.15], along) + 0.3 * TABLE.up  # however far above
    assert list(top.over(places)) == [True, False]
    assert list(top.over(places, 0.06)) == [True, True]
    assert top._replace(area=None).over(places).all()


def test_bodies_are_off_by_one_of_several_noises_and_a_plane_tells_by_which():
    found = noisy(stands(on_table(0.0, 0.0), on_table(0.2, 0.1, 1.0)))
    assert found.chance.sum() == pytest.approx(2.0)
    assert len(found.body) == 6 * len(NOISES)
    for k, noise in enumerate(NOISES):
        of_it = found.noise == k
        assert found.tilt[of_it] == pytest.approx(np.hypot(TILT, noise.tilt))
        assert noise_of(found, of_it.astype(float)) == pytest.approx((noise.tilt, noise.level, 1.0))
