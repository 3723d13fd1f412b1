"""Γ without pixels: by the rates of the KB, of what is in the image, in a lobe, and hidden by nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.frames import look_at
from geometry.visibility.rays import RayMesh
from plogic.base.errors import InputError
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of
from plogic.run.simulated_gamma import NOISE, Obstacle, Posed, simulated_gamma
from plogic.run.sources import kb_of

CAMERA = Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]])
AT = look_at(np.array([0.7, -1.4, 0.6]), np.array([0.0, 0.0, 0.08]))
EXACT = {"sigma": 1e-9, "hit": {"corner": 1.0, "sticker": 1.0}, "clutter": {"corner": 1e-9, "sticker": 1e-9}}
ALONE = (Posed("box", AT),)


def first(**rates):
    kb = kb_of("first")
    return replace(kb, rates=replace(kb.rates, **rates))


def reported(kb, objects=ALONE, seed=0, obstacles=()):
    return simulated_gamma(kb, objects, CAMERA, np.random.default_rng(seed), obstacles)


def expected(kb, pose=AT):
    one = pose_of(kb.type("box"), pose, data_of((), CAMERA), kb)
    return {
        f.name: uv for f, uv, there in zip(kb.type("box").seen_features, one.uv, one.expected(), strict=True) if there
    }


def test_a_perfect_detector_reports_what_is_expected_where_it_is():
    kb = first(**EXACT)
    found = reported(kb)
    by_name = {found.causes[a.id]: a for a in found.gamma.appearances}
    assert {name.removeprefix("0/") for name in by_name} == set(expected(kb))
    assert len(by_name) == 10  # of 13: three stickers are on sides that are seen, one corner is behind the box
    for name, uv in expected(kb).items():
        assert by_name[f"0/{name}"].uv == pytest.approx(uv, abs=1e-3)
        assert (by_name[f"0/{name}"].type == "corner") == name.startswith(("base", "top_"))
        assert by_name[f"0/{name}"].angle is None


def test_other_bodies_hide_what_is_behind_them():
    kb = first(**EXACT)
    before = np.array(AT)
    before[:3, 3] *= 0.6
    of_two = set(reported(kb, (Posed("box", AT), Posed("box", before))).causes.values())
    assert {cause.removeprefix("1/") for cause in of_two if cause.startswith("1/")} == set(expected(kb, before))
    behind = {cause.removeprefix("0/") for cause in of_two if cause.startswith("0/")}
    assert behind < set(expected(kb))
    surface = kb.type("box").surface
    decoy = Obstacle(RayMesh(surface.vertices, surface.triangles), before)
    assert {cause.removeprefix("0/") for cause in reported(kb, obstacles=(decoy,)).causes.values()} == behind


def test_out_of_a_lobe_s_range_nothing_is_reported():
    far = np.array(AT)
    far[:3, 3] *= 4.0  # 6.6 m; the lobes reach 5 m
    assert reported(first(**EXACT), (Posed("box", far),)).gamma.appearances == ()


def test_rates_are_those_of_the_kb():
    kb = first(hit={"corner": 0.7, "sticker": 0.4}, clutter={"corner": 3.0, "sticker": 1.0}, sigma=2.0)
    runs, there = [reported(kb, seed=seed) for seed in range(400)], expected(kb)
    hits, noise, off = {"corner": 0, "sticker": 0}, {"corner": 0, "sticker": 0}, []
    for run in runs:
        for a in run.gamma.appearances:
            cause = run.causes[a.id]
            (noise if cause == NOISE else hits)[a.type] += 1
            if cause != NOISE:
                off.append(np.subtract(a.uv, there[cause.removeprefix("0/")]))
    corners = sum(name.startswith(("base", "top_")) for name in there)
    assert hits["corner"] / (400 * corners) == pytest.approx(0.7, abs=0.03)
    assert hits["sticker"] / (400 * (len(there) - corners)) == pytest.approx(0.4, abs=0.05)
    assert noise["corner"] / 400 == pytest.approx(3.0, abs=0.3)
    assert noise["sticker"] / 400 == pytest.approx(1.0, abs=0.2)
    assert np.std(off) == pytest.approx(2.0, abs=0.1)


def test_angles_are_reported_where_their_noise_is_stated():
    found = reported(first(**EXACT, sigma_angle=1e-6))
    x_axis = AT[:3, :3] @ [1.0, 0.0, 0.0]
    for a in found.gamma.appearances:
        name = found.causes[a.id].removeprefix("0/")
        feature = next(f for f in kb_of("first").type("box").seen_features if f.name == name)
        ends = [AT[:3, :3] @ feature.at + AT[:3, 3] + step * x_axis for step in (0.0, 1e-4)]
        (u, v), (u2, v2) = (CAMERA.project(end) for end in ends)
        assert np.cos(a.angle - np.arctan2(v2 - v, u2 - u)) == pytest.approx(1.0, abs=1e-4)
    assert len(found.gamma.appearances) == 10


def test_arms_that_are_seen_are_reported():
    kb = kb_of("towers")
    pose = look_at(np.array([2.5, -4.0, 1.5]), np.array([0.0, 0.0, 0.7]))
    exact = replace(
        kb.rates,
        sigma=1e-9,
        sigmas={},
        hit=dict.fromkeys(kb.rates.hit, 1.0),
        clutter=dict.fromkeys(kb.rates.clutter, 1e-9),
    )
    found = simulated_gamma(replace(kb, rates=exact), [Posed("t1", pose)], CAMERA, np.random.default_rng(0))
    by_name = {found.causes[a.id]: a for a in found.gamma.appearances}
    near = by_name["0/body/base_se"]  # the corner towards the camera: all three edges are seen
    ends = [
        CAMERA.project(pose[:3, :3] @ np.add([0.4, -0.3, 0.0], step) + pose[:3, 3])
        for step in 1e-4 * np.array([[0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, 1]])
    ]
    angles = sorted(np.arctan2(*(end - ends[0])[::-1]) % (2 * np.pi) for end in ends[1:])
    assert near.arms == pytest.approx(angles, abs=1e-3)
    assert len(by_name["0/body/base_sw"].arms) == 2  # its edge to the north is behind the tower
    assert all(a.arms == () for name, a in by_name.items() if a.type == "patch")


def test_more_noise_than_a_gamma_holds_is_refused_before_it_is_made():
    with pytest.raises(InputError, match=r"clutter: 2\.14748e\+09 an image; a Γ holds 20,000 appearances at most"):
        reported(first(clutter={"corner": 2.0**31, "sticker": 1.0}))
