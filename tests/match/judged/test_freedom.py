"""The share of all poses that fit matched places as well: against sampling of poses, and its laws."""

from __future__ import annotations

from math import log, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geometry.camera import Camera
from plogic.match.judged.evidence import DEPTHS, LOOSE, log_share

CAMERA = Camera(640, 480, np.array([[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1]]))
SQUARE = Camera(500, 500, np.array([[600.0, 0, 249.5], [0, 600.0, 249.5], [0, 0, 1]]))
NOTHING = 3 * log(2 * pi) + log(LOOSE[0]) + 3 * log(LOOSE[1]) - log(DEPTHS * 8 * pi**2)
"""Of no match: one appearance's freedom, as if it were anywhere in the image."""
SCENES = st.tuples(st.integers(0, 9999), st.integers(1, 30))


def places(seed, count, spread=0.2, distance=1.0):
    """(N, 3) places about a middle (3,), and precisions (N,)."""
    rng = np.random.default_rng(seed)
    centre = np.array([*rng.uniform(-0.3, 0.3, 2), distance])
    return centre + rng.uniform(-spread, spread, (count, 3)), rng.uniform(0.1, 10.0, count), centre


def moved(at, centre, step):
    """(S, N, 3) places after steps (S, 6): across, down, along the depth, by shares of it.

    Then turned about the middle.
    """
    turned = np.einsum("sij,nj->sni", Rotation.from_rotvec(step[:, 3:]).as_matrix(), at - centre)
    return turned + centre + centre[2] * step[:, None, :3]


def pixels(at, f):
    return f * at[..., :2] / at[..., 2:]


def sampled(at, precision, centre, camera, rng, count=40_000):
    """Logarithm of the share of poses.

    The mean of exp(−½ Σ precision · off²) over all of them, by importance sampling.
    """
    slopes, tiny = [], 1e-6
    for axis in range(6):
        two = np.zeros((2, 6))
        two[:, axis] = tiny, -tiny
        ahead, behind = pixels(moved(at, centre, two), camera.f)
        slopes.append((ahead - behind) / (2 * tiny))
    slopes = np.array(slopes)
    known = np.einsum("ani,bni,n->ab", slopes, slopes, precision)
    wide = np.linalg.cholesky(1.3**2 * np.linalg.inv(known))
    normal = rng.normal(size=(count, 6))
    step = normal @ wide.T
    off = pixels(moved(at, centre, step), camera.f) - pixels(at, camera.f)
    fits = -0.5 * np.einsum("n,sni->s", precision, off**2)
    drawn = -0.5 * (normal**2).sum(axis=1) - 3 * log(2 * pi) - np.log(np.diag(wide)).sum()
    volume = log(np.exp(fits - drawn).mean())
    return volume - log(camera.width * camera.height / camera.f**2 * DEPTHS * 8 * pi**2)


@pytest.mark.parametrize("seed", range(4))
def test_the_share_is_that_of_sampled_poses(seed):
    """Twenty places, pixels of noise, an object 40 cm wide a metre away.

    There Laplace's method is exact to a twentieth of a nat.
    """
    at, precision, centre = places(seed, 20)
    share = log_share(at, precision, centre, CAMERA)
    assert share == pytest.approx(sampled(at, precision, centre, CAMERA, np.random.default_rng(seed)), abs=0.05)
    assert share < -25.0


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SCENES, st.integers(0, 30), st.floats(1.0, 9.0))
def test_more_places_or_more_precise_ones_never_raise_it(how, fewer, factor):
    at, precision, centre = places(*how)
    share = log_share(at, precision, centre, CAMERA)
    assert share <= log_share(at[:fewer], precision[:fewer], centre, CAMERA) + 1e-9
    assert log_share(at, factor * precision, centre, CAMERA) <= share + 1e-9
    assert log_share(at, 0.0 * precision, centre, CAMERA) == pytest.approx(NOTHING)
    assert share <= 0.0


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SCENES, st.floats(-4, 4), st.permutations(range(30)))
def test_the_cameras_roll_and_the_order_of_places_change_nothing(how, roll, order):
    at, precision, centre = places(*how)
    turn = Rotation.from_euler("z", roll).as_matrix()
    share = log_share(at, precision, centre, SQUARE)
    assert log_share(at @ turn.T, precision, turn @ centre, SQUARE) == pytest.approx(share, abs=1e-8)
    order = [i for i in order if i < len(at)]
    assert log_share(at[order], precision[order], centre, SQUARE) == pytest.approx(share, abs=1e-8)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SCENES, st.floats(0.01, 100.0))
def test_metres_or_miles_are_the_same(how, scale):
    at, precision, centre = places(*how)
    assert log_share(scale * at, precision, scale * centre, CAMERA) == pytest.approx(
        log_share(at, precision, centre, CAMERA), abs=1e-7
    )


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SCENES, st.floats(0.2, 5.0))
def test_a_larger_picture_of_the_same_is_the_same(how, factor):
    """Twice the pixels and twice the noise."""
    at, precision, centre = places(*how)
    K = CAMERA.K * np.array([[factor], [factor], [1.0]])
    larger = Camera(round(640 * factor), round(480 * factor), K)
    shift = 2 * log(larger.width * larger.height / (640 * 480 * factor**2))
    assert log_share(at, precision / factor**2, centre, larger) == pytest.approx(
        log_share(at, precision, centre, CAMERA), abs=0.01 + abs(shift)
    )


@pytest.mark.parametrize("camera", [CAMERA, SQUARE])
def test_without_places_it_is_one_appearances_freedom_in_any_camera(camera):
    assert log_share(np.zeros((0, 3)), np.zeros(0), np.array([0.1, 0.2, 3.0]), camera) == pytest.approx(NOTHING)
    assert NOTHING < 0.0


def test_one_place_fixes_its_two_coordinates():
    """At the middle of the object and of the image: σ in each, and as free as ever in depth and rotation."""
    centre, sigma = np.array([0.0, 0.0, 2.0]), 0.5
    bounds = np.array([640.0, 480.0]) / 600.0
    known = (600.0 / sigma) ** 2 + bounds**-2.0
    expected = NOTHING - np.log(bounds).sum() - 0.5 * np.log(known).sum()
    assert log_share(centre[None], np.array([sigma**-2.0]), centre, CAMERA) == pytest.approx(expected)
