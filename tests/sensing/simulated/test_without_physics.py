"""Where pybullet is not installed: pictures by rays against TinyRenderer's, bodies that stand, and what is said."""

import sys

import numpy as np
import pytest
from click.testing import CliRunner

from cli import cli
from geometry.camera import Camera
from geometry.frames import inverse, look_at
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.face.commands.simulate import shapes_of
from sensing.simulated.body import Body
from sensing.simulated.camera import render, visible_fractions
from sensing.simulated.physics import has_physics, physics_version, settle
from sensing.simulated.scene import box, random_scene

physics = pytest.mark.skipif(not has_physics(), reason="pybullet is not installed: there is nothing to compare with")


@pytest.fixture
def without(monkeypatch):
    """Take pybullet away: ``without()``."""
    return lambda: monkeypatch.setitem(sys.modules, "pybullet", None)


@pytest.fixture(scope="module")
def scene():
    return random_scene(shapes_of(read_kb(shipped("towers"))), 4, placement="hiding")


@physics
def test_rays_draw_what_tiny_renderer_draws(scene, without):
    by_pybullet, fractions = scene.photograph(), visible_fractions(scene.bodies, scene.camera)
    without()
    by_rays = scene.photograph()
    assert visible_fractions(scene.bodies, scene.camera) == pytest.approx(fractions, abs=2e-3)
    assert (by_rays.segmentation == by_pybullet.segmentation).mean() > 0.999
    same = (by_rays.segmentation == by_pybullet.segmentation) & (by_rays.segmentation >= 0)
    assert same.sum() > 5000
    assert np.abs(by_rays.depth - by_pybullet.depth)[same].max() < 1e-3
    assert np.abs(by_rays.image.astype(int) - by_pybullet.image)[same].mean() < 2.0


def test_a_body_across_the_camera_is_drawn_whole(without):
    without()
    wall = Body(None, box(np.array([20.0, 20.0, 1.0]), np.random.default_rng(0), painted=False), np.eye(4))
    camera = Camera(32, 24, np.array([[20.0, 0, 15.5], [0, 20.0, 11.5], [0, 0, 1]]), np.zeros(0))
    above = inverse(look_at(np.array([0.0, 0.0, 3.0]), np.zeros(3), (0.0, 1.0, 0.0)))
    seen = render([wall], Camera(32, 24, camera.K, camera.dist, above))
    assert (seen.segmentation == 0).all()
    assert seen.depth == pytest.approx(2.0, abs=1e-4)


def test_nothing_is_drawn_of_nothing(without):
    without()
    camera = Camera(8, 6, np.array([[8.0, 0, 3.5], [0, 8.0, 2.5], [0, 0, 1]]), np.zeros(0), np.eye(4))
    assert (render([], camera).segmentation == -1).all()
    assert visible_fractions([], camera) == ()


def test_a_body_stands_where_its_lowest_place_touches_the_floor(without):
    without()
    pose = np.eye(4)
    pose[:3, 3] = 1.0, 2.0, 3.0
    (rested,) = settle([Body(None, box(np.ones(3), np.random.default_rng(0), painted=False), pose)])
    assert rested.vertices_world[:, 2].min() == pytest.approx(0.0)
    assert rested.world_from_body[:2, 3].tolist() == [1.0, 2.0]


def test_versions_tell_whether_there_is_physics(without):
    assert bool(physics_version()) == has_physics()
    without()
    assert physics_version() == ""


def test_commands_say_what_they_do_without(without, tmp_path):
    without()
    made = CliRunner().invoke(
        cli, ["simulate", "--kb", "towers", "--objects", "1", "--seed", "3", "-o", str(tmp_path / "scene")]
    )
    assert made.exit_code == 0
    assert "drawn by rays" in made.stderr
    assert "pip install pybullet" in made.stderr
