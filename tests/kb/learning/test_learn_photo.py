"""A type from one photo: clicked points and their mistakes, the photo on the mesh, features on the shown faces."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from made_meshes import write_box

from benchmarks.tabletop.patterns import pattern
from cli import cli
from geometry.camera import centred_camera
from geometry.field_of_view import fov_across
from geometry.frames import inverse, look_at, transform_points
from kb.errors import IntakeError, KBErrors
from kb.files.read import read_kb
from kb.learning.again import INSIDE
from kb.learning.observations import STEEP
from kb.learning.photo import on_shown, painted, read_points, registered
from kb.surfaces.surface import surface_from_mesh
from plogic.face.authoring.kb_learn_photo import _registered
from plogic.face.shown.options import Photo
from plogic.run.cameras import GivenCamera
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import render

SIDES = np.array([0.12, 0.2, 0.08])
EYE, MIDDLE = (0.45, 0.62, 0.42), SIDES / 2
SIZE, F = (640, 480), 900.0
SHOWN = "the faces x = 0.12, y = 0.2 and z = 0.08"
BOX = Path(__file__).parents[3].parent / "shared" / "data" / "box"
CLICKS = Path(__file__).parents[2] / "scenes" / "box" / "photo_points.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """``box.obj``, its ``photo.png`` from EYE, and ``points.csv``, seven corners to half a pixel."""
    import cv2

    place = tmp_path_factory.mktemp("photo")
    write_box(place / "box.obj", SIDES)
    surface = surface_from_mesh(place / "box.obj")
    corners = surface.vertices[surface.triangles]
    axis = np.ptp(corners, axis=1).argmin(axis=1)
    flat = [np.delete(corner, a, axis=1) for corner, a in zip(corners, axis, strict=True)]
    uv = np.concatenate([(one / 0.2 + k) / 3.0 for one, k in zip(flat, axis, strict=True)])
    sheet = np.hstack([pattern("newsprint", np.random.default_rng(seed), 512) for seed in range(3)])
    sheet = np.vstack([np.zeros((1024, 1536, 3), np.uint8), sheet])
    mesh = TexturedMesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), uv % 1.0, sheet)
    camera = camera_at_eye()
    cv2.imwrite(str(place / "photo.png"), render([Body("box", mesh, np.eye(4))], camera).image)
    seen = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)][1:]) * SIDES
    pixels = camera.project(transform_points(camera.camera_from_world, seen)) + np.random.default_rng(0).normal(
        0, 0.3, (7, 2)
    )
    rows = [",".join(f"{value:.6g}" for value in (*pixel, *at)) for pixel, at in zip(pixels, seen, strict=True)]
    (place / "points.csv").write_text("u,v,x,y,z\n" + "\n".join(rows) + "\n")
    return place


def camera_at_eye():
    from dataclasses import replace

    return replace(centred_camera(SIZE, F), world_from_camera=inverse(look_at(EYE, MIDDLE)))


def run(*words):
    answer = CliRunner().invoke(cli, ["kb", *[str(word) for word in words]])
    return answer.exit_code, f"{answer.output}{answer.exception or ''}"


def on_faces(at, tolerance=2e-3):
    """(N, 3) bool: on the face x = 0.12, y = 0.2, z = 0.08."""
    return np.abs(at - SIDES) < tolerance


def in_this_process(done, jobs, _, then):
    """As ``growing``, where what is patched here counts."""
    left = list(jobs)
    while left:
        job = left.pop(0)
        left[:0] = then(job, done(job))


def test_command_learns_what_the_photo_shows(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("plogic.face.authoring.kb_learn_all.growing", in_this_process)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    learning = "kb.learning.observations", "plogic.face.authoring.kb_learn_look"
    for module in (*learning, "plogic.face.authoring.kb_learn_all"):
        monkeypatch.setattr(f"{module}.DIRECTIONS", 16)
    for module in (*learning, "kb.learning.features"):
        monkeypatch.setattr(f"{module}.PIXELS", (230.0, 160.0))
    kb = tmp_path / "kb"
    assert run("new", kb)[0] == 0
    code, said = run(
        "learn", "crate", "--kb", kb, "--photo", folder / "photo.png", "--points", folder / "points.csv",
        "--mesh", folder / "box.obj", "--units", "m", "--jobs", 1, "--json",
    )  # fmt: skip
    assert code == 0, said
    row = json.loads(next(line for line in said.splitlines() if line.startswith("{")))["types"][0]
    assert row["f px"] == pytest.approx(F, rel=0.05)
    assert 0.45 < row["shown"] <= 0.5
    cloud = read_kb(kb).type("crate").learned
    points = cloud.keypoints.at
    assert len(points) > 20
    assert on_faces(points).any(axis=1).all(), f"every keypoint is on {SHOWN}"
    check_sides(cloud, np.linalg.norm(SIDES) / 160.0)
    assert run("check", kb)[0] == 0


def check_sides(cloud, pixel):
    """Sides are on the plane of a face, nearly all to 0.02 pixels; ``pixel``: metres.

    To 0.9 are those next to a corner, where what is farther in is another face, and those that were also seen along the
    face. Where all see it along itself, the place is on the ray through the edge as deep as the cell INSIDE[0] pixels
    beside it, and that is how far off: to 1.8.
    """
    off = np.abs(cloud.at - SIDES)
    sides, off, face = np.unique(cloud.feature[cloud.sided]), off.min(axis=1) / pixel, off.argmin(axis=1)
    slope = np.take_along_axis(cloud.axis, face[cloud.feature][:, None], axis=1)[:, 0]
    faced = np.setdiff1d(sides, cloud.feature[slope < STEEP])
    assert 300 < len(faced) < len(sides)
    assert np.quantile(off[faced], 0.95) < 0.05
    assert off[faced].max() < 1.0
    assert off[sides].max() < INSIDE[0] + 0.4


def test_photo_paints_three_faces_and_leaves_three_grey(folder):
    surface = surface_from_mesh(folder / "box.obj")
    camera = camera_at_eye()
    photo = np.random.default_rng(0).integers(0, 255, (480, 640, 3)).astype(np.uint8)
    mesh = painted(surface, photo, camera, camera.camera_from_world)
    middle = mesh.vertices[mesh.triangles].mean(axis=1)
    assert np.array_equal(mesh.shown, on_faces(middle, 1e-9).any(axis=1))
    strip = mesh.uv[mesh.triangles[~mesh.shown]].reshape(-1, 2)
    assert (strip[:, 1] < 64 / (480 + 64)).all()
    at = mesh.uv[mesh.triangles[mesh.shown]].reshape(-1, 2)
    pixels = np.column_stack([at[:, 0] * 640 - 0.5, (1.0 - at[:, 1]) * (480 + 64) - 0.5])
    places = mesh.vertices[mesh.triangles[mesh.shown]].reshape(-1, 3)
    assert np.allclose(pixels, camera.project(transform_points(camera.camera_from_world, places)))


def test_observations_on_grey_or_beside_it_are_left_out(folder):
    from kb.learning.observations import Observations

    surface = surface_from_mesh(folder / "box.obj")
    camera = camera_at_eye()
    mesh = painted(surface, np.zeros((480, 640, 3), np.uint8), camera, camera.camera_from_world)
    at = np.array([[0.06, 0.1, 0.08], [0.119, 0.1, 0.0], [0.12, 0.1, 0.002], [0.12, 0.1, 0.04]])
    direction = np.tile(np.array([1.0, 0.0, -1.0]) / np.sqrt(2.0), (4, 1))
    direction[0] = (0.0, 0.0, 1.0)
    one = np.ones(4)
    described = np.zeros((4, 128), np.float32)
    seen = Observations(
        at, direction, direction, direction, 0.01 * one, one, np.array([0, 1, 1, 1]), np.zeros(4, int), one, described
    )
    assert np.allclose(on_shown(mesh, seen).at, at[[0, 3]])


def test_points_in_every_form_are_the_same(tmp_path):
    rows = [[10, 20, 1, 2, 3], [30.5, 40, 4, 5, 6]]
    (tmp_path / "a.json").write_text(json.dumps({"units": "cm", "points": rows}))
    (tmp_path / "b.yaml").write_text(
        "units: cm\npoints:\n" + "".join(f"  - {{pixel: {r[:2]}, at: {r[2:]}}}\n" for r in rows)
    )
    (tmp_path / "c.csv").write_text("u,v,x,y,z\n" + "\n".join(",".join(map(str, r)) for r in rows))
    found = [read_points(tmp_path / "a.json"), read_points(tmp_path / "b.yaml"), read_points(tmp_path / "c.csv", "cm")]
    for one in found:
        assert np.allclose(one.uv, [[10, 20], [30.5, 40]])
        assert np.allclose(one.at, [[0.01, 0.02, 0.03], [0.04, 0.05, 0.06]])
    assert found[1].places == ((3, 5), (4, 5))


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("p.yaml", "units: ell\npoints:\n  - [1, 2, 3, 4, 5]\n", "p.yaml:1:8: units: must be one of"),
        ("p.yaml", "points:\n  - [1, 2, 3, 4]\n", "p.yaml:2:5: points.0: must be five numbers"),
        ("p.yaml", "points:\n  - [1, 2, 3, .nan, 5]\n", "p.yaml:2:15: points.0.3: must be finite"),
        ("p.yaml", "points:\n  - {pixel: [1, 2], place: [3, 4, 5]}\n", "p.yaml:2:5: points.0: must be {pixel"),
        ("p.yaml", "points: 3\n", "p.yaml:1:9: points: must be a mapping"),
        ("p.yaml", "point: []\n", "must be a mapping with points"),
        ("p.csv", "u,v,x,y,z\n1,2,3,4,5\n1,2,x,4,5\n", "p.csv:3:5: must be a number, not 'x'"),
        ("p.csv", "1,2,3,4\n", "p.csv:1:1: must be five numbers u,v,x,y,z, not 4"),
        ("p.csv", "", "p.csv:1:1: holds no points"),
    ],
)
def test_mistakes_in_points_are_told_where_they_are(tmp_path, name, text, told):
    (tmp_path / name).write_text(text)
    with pytest.raises(KBErrors) as caught:
        read_points(tmp_path / name)
    assert told in str(caught.value)


def points_of(folder, tmp_path, change):
    lines = (folder / "points.csv").read_text().splitlines()
    (tmp_path / "points.csv").write_text("\n".join(change(lines)) + "\n")
    return read_points(tmp_path / "points.csv"), surface_from_mesh(folder / "box.obj")


def test_a_wrong_click_is_told_at_its_line(folder, tmp_path):
    def moved(lines):
        u, *rest = lines[4].split(",")
        return [*lines[:4], ",".join([str(float(u) + 40.0), *rest]), *lines[5:]]

    points, surface = points_of(folder, tmp_path, moved)
    with pytest.raises(KBErrors, match=r"points.csv:5:1: points.3: does not fit the others"):
        registered(points, SIZE, surface)


def test_points_in_other_units_outside_and_too_few(folder, tmp_path):
    points, surface = points_of(folder, tmp_path, lambda lines: [*lines[:3], "700,20,0,0,8"])
    with pytest.raises(IntakeError, match="has 3 points; 6 at least are needed without a camera"):
        registered(points, SIZE, surface)
    with pytest.raises(IntakeError, match="has 3 points; 4 at least are needed with a camera"):
        registered(points, SIZE, surface, camera_at_eye())
    points, surface = points_of(folder, tmp_path, lambda lines: [*lines, "700,20,0,0,8"])
    with pytest.raises(KBErrors) as caught:
        registered(points, SIZE, surface)
    assert "must lie in the photo of 640 x 480" in str(caught.value)
    assert "m from the mesh" in str(caught.value)


def test_a_photo_needs_its_points_and_one_name(folder, tmp_path):
    kb = tmp_path / "kb"
    assert run("new", kb)[0] == 0
    photo = ("--photo", folder / "photo.png")
    cases = {
        "--photo needs --points": ("learn", "crate", "--kb", kb, *photo),
        "--points: only with --photo": ("learn", "crate", "--kb", kb, "--points", folder / "points.csv"),
        "--fov-diagonal: only with --photo": ("learn", "crate", "--kb", kb, "--fov-diagonal", 60),
        "name the one type that it shows": ("learn", "--kb", kb, *photo, "--points", folder / "points.csv"),
        "no such object type; add it with plogic kb add": (
            "learn",
            "crate",
            "--kb",
            kb,
            *photo,
            "--points",
            folder / "points.csv",
        ),
    }
    for told, words in cases.items():
        code, said = run(*words)
        assert code != 0
        assert told in said
    assert not list((kb / "objects").iterdir())


@pytest.mark.skipif(not (BOX / "photo.jpg").is_file(), reason="../shared/data/box is not there")
def test_cookie_box_is_registered():
    import cv2

    photo = cv2.imread(str(BOX / "photo.jpg"))
    surface = surface_from_mesh(BOX / "box.ply", 0.01)
    found = registered(read_points(CLICKS), (photo.shape[1], photo.shape[0]), surface)
    assert found.rms < 2.0
    assert 3.0 * found.f_error < found.camera.f
    mesh = painted(surface, photo, found.camera, found.camera_from_object)
    faces = surface.vertices.max(axis=0)
    middle = mesh.vertices[mesh.triangles[mesh.shown]].mean(axis=1)
    share = [(np.abs(middle[:, k] - value) < 1e-6).mean() for k, value in ((0, 0.0), (1, 0.0), (2, faces[2]))]
    assert min(share) > 0.1
    assert sum(share) == pytest.approx(1.0)


def test_a_focal_length_that_is_given_is_taken(folder):
    kind = SimpleNamespace(name="crate", surface=surface_from_mesh(folder / "box.obj"))
    for given in (GivenCamera(focal=F), GivenCamera(fov=fov_across(SIZE[0], F))):
        found, _ = _registered(kind, Photo(folder / "photo.png", folder / "points.csv", given))
        assert (found.camera.f, found.f_error) == (pytest.approx(F), 0)
        assert found.rms < 1.0
