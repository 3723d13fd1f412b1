"""How surely a pose is right: laws of the share, and photos in which the truth is known."""

from __future__ import annotations

from dataclasses import replace
from math import erf

import numpy as np
import pytest
from painted_cube import CAMERA, CORNER, cube, picture, pose_towards

from sensing.pixels.crop import crop_of
from sensing.pixels.drawn import Paint
from sensing.pixels.energy import fit_of
from sensing.pixels.photo import Photo
from sensing.pixels.refine import FINE, moved
from sensing.pixels.sureness import Alternative, alternatives, share_of, sureness

TRUE = pose_towards(CORNER, 0.60, 0.0, (0.0, 0.0))
ITSELF = np.eye(4)[None]


@pytest.fixture(scope="module")
def paint():
    return Paint(cube())


@pytest.fixture(scope="module")
def photo():
    return Photo(picture([TRUE], seed=3), CAMERA)


def at(pose, score=0.0, known=1e9, inexact=0.0):
    """An alternative that is known so well: 1/rad², 1/m²."""
    return Alternative(pose, score, np.eye(6), known * np.eye(6), inexact)


def farther(share):
    pose = TRUE.copy()
    pose[:3, 3] *= 1.0 + share
    return pose


def test_the_true_pose_is_sure_and_one_that_is_off_is_not(paint, photo):
    assert sureness(photo, paint, TRUE, ITSELF) > 0.9
    assert sureness(photo, paint, farther(0.25), ITSELF) < 0.1


def test_where_nothing_is_seen_nothing_is_said(paint, photo):
    beside = TRUE.copy()
    beside[0, 3] += 5.0
    assert sureness(photo, paint, beside, ITSELF) is None


def test_the_same_photo_gives_the_same_number(paint, photo):
    assert sureness(photo, paint, TRUE, ITSELF) == sureness(photo, paint, TRUE, ITSELF)
    assert np.array_equal(alternatives(photo, paint, TRUE)[0].pose, TRUE)


def test_one_that_is_known_for_sure_has_all_of_it_and_a_far_one_its_weight(paint):
    assert share_of([at(TRUE)], paint, TRUE, ITSELF) == 1.0
    assert share_of([at(farther(0.5))], paint, TRUE, ITSELF) == 0.0
    for score in (-2.0, 0.0, 3.0):
        both = [at(TRUE), at(farther(0.5), score)]
        assert share_of(both, paint, TRUE, ITSELF) == pytest.approx(1.0 / (1.0 + np.exp(score)))


def test_what_is_known_less_is_less_sure(paint):
    shares = [share_of([at(TRUE, known=known)], paint, TRUE, ITSELF) for known in (1e1, 1e4, 1e5, 1e9)]
    assert shares == sorted(shares)
    assert shares[0] < 0.2


def test_what_is_not_quite_the_mesh_is_less_sure_the_farther_it_is(paint):
    """Oracle: the share of a normal distance that is within a tenth of the diameter."""
    shares = [share_of([at(TRUE, inexact=share)], paint, TRUE, ITSELF) for share in (0.0, 0.005, 0.02, 0.05)]
    assert shares == sorted(shares, reverse=True)
    near = paint.diameter / 10.0 / (0.05 * np.linalg.norm(TRUE[:3, :3] @ paint.middle + TRUE[:3, 3]))
    assert shares[-1] == pytest.approx(erf(near / np.sqrt(2.0)), abs=0.03)


def test_an_outline_that_fits_is_exact(paint, photo):
    """Beside a cube that is longer by a sixteenth."""
    longer = cube()
    longer = replace(longer, vertices=longer.vertices * [1.0, 1.0, 1.06])
    crop = crop_of(photo, paint, TRUE, FINE)
    assert fit_of(crop, paint, TRUE).inexact < 0.01 < fit_of(crop, Paint(longer), TRUE).inexact


def test_a_turn_that_changes_nothing_makes_no_pose_wrong(paint):
    turn = moved(np.eye(4), paint.middle, np.array([0.0, 0.0, np.pi, 0.0, 0.0, 0.0]))
    twin = [at(TRUE @ turn)]
    assert share_of(twin, paint, TRUE, ITSELF) == 0.0
    assert share_of(twin, paint, TRUE, np.stack([np.eye(4), turn])) == 1.0
