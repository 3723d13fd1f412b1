"""The compiled loops against numpy, finite differences, and the ray caster of the simulated camera."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_cube import CAMERA, CORNER, cube, pose_towards

from geometry.frames import inverse, transform_points
from sensing.pixels.blocks import Blocks
from sensing.pixels.drawn import MANY, Paint
from sensing.pixels.loops import edge_off, motion, of_lines, of_print, print_off, squared
from sensing.pixels.refine import moved
from sensing.simulated.body import Body
from sensing.simulated.raycast import Caster

POSE = pose_towards(CORNER, 0.60, 0.3, (0.02, 0.01))
SEEDS = st.integers(0, 10**6)
laws = settings(derandomize=True, deadline=None, max_examples=40)


@pytest.mark.parametrize("many", [0, MANY])
def test_a_picture_shows_what_the_ray_caster_meets(many, monkeypatch):
    """Depth and facing to rounding, paint to half a grey level, for OpenCV looks colours up in whole ones."""
    monkeypatch.setattr("sensing.pixels.drawn.MANY", many)  # of 0 triangles more are found by rays
    mesh = cube()
    drawn = Paint(mesh).drawn(POSE, CAMERA.K, (CAMERA.width, CAMERA.height))
    v, u = np.nonzero(drawn.mask)
    rays = np.column_stack(
        [(u - CAMERA.K[0, 2]) / CAMERA.K[0, 0], (v - CAMERA.K[1, 2]) / CAMERA.K[1, 1], np.ones(len(u))]
    )
    caster = Caster([Body(None, mesh, np.eye(4))])
    found = caster.cast(inverse(POSE)[:3, 3], rays @ POSE[:3, :3])
    normal = found.normal @ POSE[:3, :3].T
    steep = np.abs((normal * rays).sum(axis=1)) / np.linalg.norm(rays, axis=1)
    assert (found.body == 0).all()
    assert drawn.depth[v, u] == pytest.approx(found.depth, rel=1e-12)
    assert drawn.normal[v, u] == pytest.approx(normal, abs=1e-6)
    assert np.abs(drawn.colour[v, u] - caster.colours(found, found.depth / CAMERA.K[0, 0], steep)).max() < 0.51


@laws
@given(SEEDS)
def test_a_step_moves_pixels_as_its_slopes_say(seed):
    """Oracle: finite differences of the projection of a moved place."""
    rng = np.random.default_rng(seed)
    pose, middle = POSE.copy(), rng.uniform(-0.02, 0.02, 3)
    place = rng.uniform(-0.05, 0.05, 3)
    K = np.array(CAMERA.K)

    def seen(step):
        x, y, z = transform_points(moved(pose, middle, step), place[None])[0]
        return np.array([x / z * K[0, 0] + K[0, 2], y / z * K[1, 1] + K[1, 2]])

    at, moves = seen(np.zeros(6)), np.empty((2, 6))
    depth, turning = transform_points(pose, place[None])[0, 2], transform_points(pose, middle[None])[0]
    motion(at[0], at[1], depth, K, turning, moves)
    small = 1e-6
    told = np.column_stack([(seen(small * step) - seen(-small * step)) / (2.0 * small) for step in np.eye(6)])
    assert moves == pytest.approx(told, rel=1e-4, abs=1e-3)


@laws
@given(SEEDS)
def test_lines_make_the_normal_equations_of_their_slopes(seed):
    rng = np.random.default_rng(seed)
    n, K, middle = 7, np.array(CAMERA.K), np.array([0.01, -0.02, 0.6])
    at, angle = rng.uniform(50.0, 200.0, (n, 2)), rng.uniform(0.0, 7.0, n)
    across, depth = np.column_stack([np.cos(angle), np.sin(angle)]), rng.uniform(0.5, 0.7, n)
    off, weight = rng.normal(0.0, 2.0, n), rng.uniform(0.0, 1.0, n)
    rows = np.zeros((n, 6))
    for k in range(n):
        moves = np.empty((2, 6))
        motion(at[k, 0], at[k, 1], depth[k], K, middle, moves)
        rows[k] = across[k] @ moves
    told, slope = of_lines(at, across, depth, K, middle, off, weight)
    assert told == pytest.approx(rows.T @ (weight[:, None] * rows))
    assert slope == pytest.approx(rows.T @ (weight * off))


@laws
@given(SEEDS, st.integers(3, 9))
def test_squares_sum_their_pixels_and_print_is_told_less_its_mean(seed, side):
    """Oracle: numpy, square by square."""
    rng = np.random.default_rng(seed)
    high, wide = 23, 31
    visible = rng.random((high, wide)) < 0.7
    photo, shown = rng.uniform(0.0, 100.0, (2, high, wide, 3)).astype(np.float32)
    which, count, sums = squared(visible, photo, shown, side)
    blocks = Blocks(which, np.maximum(count, 1), sums, np.zeros(3))
    slopes = rng.normal(0.0, 5.0, (2, high, wide, 3)).astype(np.float32)
    depth, K, middle = rng.uniform(0.5, 0.7, (high, wide)), np.array(CAMERA.K), np.array([0.0, 0.0, 0.6])
    gains = rng.uniform(0.5, 1.5, (len(count), 3))
    off = print_off(which, photo, shown, slopes, depth, (K, gains), middle)
    variance, odd = rng.uniform(2.0, 50.0, 3), 2.25
    told, slope = of_print(which, off, count, variance, odd)
    own, expected, pull = which[which >= 0], np.zeros((6, 6)), np.zeros(6)
    for square in np.unique(own):
        mine = visible & (which == square)
        assert count[square] == mine.sum()
        assert blocks.moments[0][square] == pytest.approx(photo[mine].astype(float).var(axis=0), rel=1e-6, abs=1e-6)
        rows = off[own == square] - off[own == square].mean(axis=0)
        trust = 1.0 / (variance * (1.0 + rows[:, :, 6] ** 2 / (variance * odd)) ** 2)
        expected += np.einsum("nk,nki,nkj->ij", trust, rows[:, :, :6], rows[:, :, :6])
        pull += np.einsum("nk,nki,nk->i", trust, rows[:, :, :6], rows[:, :, 6])
    assert told == pytest.approx(expected)
    assert slope == pytest.approx(pull)


@laws
@given(st.floats(-2.4, 2.4), st.floats(0.0, 2.0 * np.pi))
def test_an_edge_is_found_where_it_is(off, angle):
    """A ramp whose steepest place is a line: told to 0.15 pixels."""
    y, x = np.mgrid[0:41, 0:41].astype(float)
    c, s = np.cos(angle), np.sin(angle)
    far = (x - 20.0) * c + (y - 20.0) * s - off
    steep = 10.0 * np.exp(-0.5 * (far / 1.2) ** 2)
    gradient = np.stack([steep * c, steep * s], axis=2).astype(np.float32)
    at, across = np.array([[20.0, 20.0]]), np.array([[c, s]])
    assert edge_off(gradient, at, across, 4, 1.0)[0] == pytest.approx(off, abs=0.15)
    assert edge_off(gradient, at, np.array([[-s, c]]), 4, 1.0)[0] == 99.0
