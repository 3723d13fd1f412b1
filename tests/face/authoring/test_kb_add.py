"""``kb new`` and ``kb add`` through the console script.

What they write, what they say, and that nothing is half-written.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from console import bytes_in, document, good, plogic
from made_meshes import box_triangles, obj_text, write_box, write_painted

from kb.files.folder import shipped
from kb.files.quantities import LENGTHS
from kb.files.read import read_kb
from kb.files.schema import json_schema
from plogic.face.authoring.kb_group import UNITS
from sensing.simulated.body import read_mesh

YCB = Path(__file__).parents[4] / "shared" / "data" / "ycb"


@pytest.fixture
def folder(tmp_path):
    """A new knowledge base."""
    good("kb", "new", tmp_path / "new" / "kb")
    return tmp_path / "new" / "kb"


def refused(folder, *args):
    """The one line on stderr of a ``kb add`` that must fail and write nothing."""
    before = bytes_in(folder)
    done = plogic("kb", "add", *args, "--kb", folder)
    assert (done.returncode, done.stdout) == (1, "")
    assert bytes_in(folder) == before
    (line,) = done.stderr.splitlines()
    return line


def test_what_its_reader_logs_is_not_printed(folder, tmp_path):
    corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    normal = "facet normal 0 0 up\nouter loop\n"
    (tmp_path / "x.stl").write_text(f"solid x\n{normal}{corners}endloop\nendfacet\nendsolid x\n")
    done = plogic("kb", "add", "x", "--mesh", tmp_path / "x.stl", "--units", "m", "--kb", folder)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_new_kb_is_read_and_told_what_it_lacks(folder):
    assert sorted(bytes_in(folder)) == ["kb.schema.json", "kb.yaml", "object.schema.json", "objects", "rules.pl"]
    assert (folder / "kb.yaml").read_text().startswith('# yaml-language-server: $schema=./kb.schema.json\nname: "kb"\n')
    assert json.loads((folder / "kb.schema.json").read_text()) == json_schema("kb")
    assert "note: there is no type" in good("kb", "check", folder)


def test_the_example_in_the_rules_is_a_rule(folder):
    rules = folder / "rules.pl"
    rules.write_text(rules.read_text().replace("%   ", ""))
    assert "no mistakes" in good("kb", "check", folder)


def test_a_new_kb_is_never_written_over_anything(folder):
    before = bytes_in(folder)
    done = plogic("kb", "new", folder)
    assert (done.returncode, done.stderr) == (1, f"plogic: {folder}: exists already and is not an empty folder\n")
    assert bytes_in(folder) == before


def test_a_name_of_its_own(tmp_path):
    good("kb", "new", tmp_path / "a b", "--name", "kitchen")
    assert read_kb(tmp_path / "a b").name == "kitchen"
    done = plogic("kb", "new", tmp_path / "c d")
    assert (done.returncode, (tmp_path / "c d").exists()) == (1, False)
    assert "give one with plogic kb new FOLDER --name NAME" in done.stderr


def test_an_example_to_start_from_is_found_in_its_own_scene(tmp_path):
    folder = tmp_path / "mine"
    assert "objects/box" in good("kb", "new", folder, "--example")
    kb, first = read_kb(folder), read_kb(shipped("first"))
    assert kb.name == "mine"
    assert (kb.rates, kb.appearance_types, kb.f_ref) == (first.rates, first.appearance_types, first.f_ref)
    assert good("kb", "check", folder).startswith("mine: 1 type, 2 appearance types, no mistakes")
    good("simulate", "--kb", folder, "--objects", "1", "--gamma", "-o", tmp_path / "scene")
    good("perceive", tmp_path / "scene" / "gamma.json", "--kb", folder, "-o", tmp_path / "out.json")
    assert "box h1" in good("worlds", tmp_path / "out.json")


def test_without_a_mesh_the_next_step_is_told_too(tmp_path):
    assert "object.yaml by hand, as plogic kb new FOLDER --example" in good("kb", "new", tmp_path / "kb")


def test_a_painted_mesh_is_kept_for_rendering_and_repaired_for_reasoning(tmp_path, folder):
    text = good("kb", "add", "crate", "--mesh", write_painted(tmp_path), "--units", "cm", "--kb", folder)
    assert "16 vertices welded" in text
    assert "closed, 0.001 m3" in text
    assert "texture: one picture, png, as it is" in text
    assert (
        (folder / "objects/crate/object.yaml")
        .read_text()
        .startswith("# yaml-language-server: $schema=../../object.schema.json\n")
    )
    (crate,) = read_kb(folder).types
    assert crate.surface.closed
    assert crate.surface.volume == pytest.approx(0.001)
    assert (crate.mesh_file.name, len(crate.symmetries)) == ("textured.obj", 1)
    painted = read_mesh(crate.mesh_file, crate.mesh_scale)
    assert painted.texture.shape == (4, 4, 3)
    assert np.ptp(painted.vertices, axis=0) == pytest.approx([0.1, 0.1, 0.1])
    assert "warning: crate: has no features, so it is never found: learn them: plogic kb learn crate" in good(
        "kb", "check", folder
    )


def test_the_proposed_symmetries_are_comments_that_can_be_uncommented(tmp_path, folder):
    good("kb", "add", "brick", "--mesh", write_box(tmp_path / "b.obj", (1, 2, 4)), "--units", "dm", "--kb", folder)
    path = folder / "objects/brick/object.yaml"
    lines = path.read_text().splitlines()
    start = lines.index("# symmetries:")
    path.write_text(
        "\n".join([*lines[:start], *(line.removeprefix("# ").replace("#   ", "  ") for line in lines[start:])]) + "\n"
    )
    (brick,) = read_kb(folder).types
    assert len(brick.symmetries) == 4
    assert "note: brick" not in good("kb", "check", folder)


def test_the_ways_to_stand_are_comments_that_can_be_uncommented(tmp_path, folder):
    good("kb", "add", "brick", "--mesh", write_box(tmp_path / "b.obj", (1, 2, 4)), "--units", "dm", "--kb", folder)
    path = folder / "objects/brick/object.yaml"
    text = path.read_text()
    assert text.count("#   - {down: ") == 6
    path.write_text(
        text.replace("# stands:", "stands:").replace(
            "#   - {down: [0, 0, -1], weight: 0.167}", "  - {down: [0, 0, -1]}"
        )
    )
    (brick,) = read_kb(folder).types
    assert brick.resting.down.tolist() == [[0, 0, -1]]


def test_without_a_texture_it_is_said_what_can_still_be_detected(tmp_path, folder):
    text = good("kb", "add", "plain", "--mesh", write_box(tmp_path / "b.obj"), "--units", "cm", "--kb", folder)
    assert "texture: none; what can still be detected: junctions" in text
    assert "not keypoints" in text
    assert sorted(path.name for path in (folder / "objects/plain").iterdir()) == ["mesh.ply", "object.yaml"]


def test_json(tmp_path, folder):
    mesh = write_box(tmp_path / "b.obj", (1, 2, 3))
    (row,) = (told := document("kb", "add", "b", "--mesh", mesh, "--units", "m", "--kb", folder, "--json"))["types"]
    assert told["format"] == "kb_add/1"
    assert (row["type"], row["closed"], row["triangles"], row["extent_m"]) == ("b", True, 12, [1, 2, 3])


def test_a_mesh_that_is_not_closed_is_taken_and_warned_of(tmp_path, folder):
    mesh = write_box(tmp_path / "b.obj", (1, 2, 3), box_triangles()[2:])
    text = good("kb", "add", "b", "--mesh", mesh, "--units", "m", "--kb", folder)
    assert "not closed (1 larger holes left open): 4 edges in one facet only" in text
    (warning, *_) = document("kb", "check", folder, "--json")["warnings"]
    assert warning.startswith("b: the mesh is not closed (4 edges in one facet only)")
    assert "refused as a solid: 1 hole is larger than 20% of it" in warning


@pytest.mark.parametrize(("size", "units"), [(10, "mm"), (50, "m"), (0.01, "m"), (1969, "in")])
def test_a_die_and_a_building(tmp_path, folder, size, units):
    good(
        "kb",
        "add",
        "cube",
        "--mesh",
        write_box(tmp_path / "c.obj", (size, size, size)),
        "--units",
        units,
        "--kb",
        folder,
    )
    (cube,) = read_kb(folder).types
    assert cube.surface.volume == pytest.approx((size * LENGTHS[units]) ** 3)


@pytest.mark.parametrize("suffix", ["ply", "stl", "glb", "off"])
def test_other_formats(tmp_path, folder, suffix):
    trimesh.creation.box(extents=(0.1, 0.2, 0.3)).export(tmp_path / f"box.{suffix}")
    good("kb", "add", "box", "--mesh", tmp_path / f"box.{suffix}", "--units", "m", "--kb", folder)
    (box,) = read_kb(folder).types
    assert box.surface.volume == pytest.approx(0.006, rel=1e-5)


@pytest.mark.parametrize(
    ("sides", "units", "doubt"),
    [
        ((190, 80, 60), "m", "the type is 190 m across; if the mesh is in millimetres: --units mm"),
        ((21, 16, 7), "m", "the type is 21 m across; if the mesh is in centimetres: --units cm"),
        ((0.2, 0.1, 0.1), "mm", "the type is 0.2 mm across; if the mesh is in metres: --units m"),
        (
            (0.002, 0.001, 0.001),
            "m",
            "the type is 2 mm across; in cm and mm it would be no likelier: was the mesh scaled?",
        ),
        ((0.2, 0.1, 0.1), "m", ""),
        ((6, 5, 5), "mm", ""),
        ((9, 3, 3), "m", ""),
    ],
)
def test_an_unusual_size_is_doubted_in_one_line(tmp_path, folder, sides, units, doubt):
    mesh = write_box(tmp_path / "b.obj", sides)
    text = good("kb", "add", "b", "--mesh", mesh, "--units", units, "--kb", folder)
    assert [line for line in text.splitlines() if line.startswith("note:")] == ([f"note: {doubt}"] if doubt else [])
    again = document("kb", "add", "c", "--mesh", mesh, "--units", units, "--kb", folder, "--json")
    assert again["types"][0]["notes"] == ([doubt] if doubt else [])


def test_units_are_required_and_the_likely_one_proposed(tmp_path, folder):
    line = refused(folder, "box", "--mesh", write_box(tmp_path / "b.obj", (18.9, 25.8, 7.5)))
    assert "--units is missing, and no mesh format carries its unit" in line
    assert "25.8 m in m, 0.258 m in cm, 25.8 mm in mm: probably --units cm" in line


BAD = {
    "no file": (None, "there is no such mesh file"),
    "no triangles": ("v 0 0 0\nv 1 0 0\n", "holds no triangles"),
    "no mesh": ("v 0 0 0\nv 1 0 0\nf 1 2 9\n", "no mesh that can be read"),
    "NaN": (obj_text([[0, 0, 0], [1, 0, 0], [0, float("nan"), 0]], [[0, 1, 2]]), "not finite"),
    "one place": (obj_text(np.zeros((3, 3)), [[0, 1, 2]]), "no extent"),
    "a line": (obj_text([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), "degenerate"),
    "too large": (obj_text([[0, 0, 0], [1e7, 0, 0], [0, 1, 0]], [[0, 1, 2]]), "would be 1e+07 m long in m"),
    "beyond numbers": (obj_text([[-1e308, 0, 0], [1e308, 0, 0], [0, 1, 0]], [[0, 1, 2]]), "too large"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_meshes_write_nothing(tmp_path, folder, case):
    content, said = BAD[case]
    mesh = tmp_path / "bad.obj"
    if content is not None:
        mesh.write_text(content)
    line = refused(folder, "bad", "--mesh", mesh, "--units", "m")
    assert line.startswith(f"plogic: {mesh}: ")
    assert said in line


def test_a_large_file_is_refused_before_it_is_read(tmp_path, folder):
    with (tmp_path / "large.obj").open("wb") as file:
        file.truncate(200_000_001)
    assert "more than the 200000000 that are read" in refused(
        folder, "x", "--mesh", tmp_path / "large.obj", "--units", "m"
    )


def test_a_name_that_is_taken_or_none(tmp_path, folder):
    mesh = write_box(tmp_path / "b.obj")
    good("kb", "add", "b", "--mesh", mesh, "--units", "m", "--kb", folder)
    assert "exists already" in refused(folder, "b", "--mesh", mesh, "--units", "m")
    (folder / "objects" / "b").rename(folder / "objects" / "elsewhere")
    assert "elsewhere: exists already" in refused(folder, "b", "--mesh", mesh, "--units", "m"), (
        "a type's name is in its object.yaml"
    )
    assert "is no name for a type" in refused(folder, "../b", "--mesh", mesh, "--units", "m")
    (tmp_path / "empty").mkdir()
    assert "holds no kb.yaml; make a knowledge base with" in refused(
        tmp_path / "empty", "b", "--mesh", mesh, "--units", "m"
    )


def test_a_missing_texture_is_noted(tmp_path, folder):
    text = good("kb", "add", "b", "--mesh", write_painted(tmp_path, picture=False), "--units", "cm", "--kb", folder)
    assert "note: the texture 'paint.png' is missing or no picture: going on without" in text


def test_the_units_of_the_command_are_those_of_the_schema():
    assert list(LENGTHS) == UNITS


@pytest.mark.skipif(not YCB.is_dir(), reason="../shared/data is absent")
def test_real_scans_become_closed_types(folder):
    meshes = sorted(YCB.glob("*/textured.obj"))[:3]
    for mesh in meshes:
        good("kb", "add", mesh.parent.name, "--mesh", mesh, "--units", "m", "--kb", folder)
    types = read_kb(folder).types
    assert [kind.name for kind in types] == [mesh.parent.name for mesh in meshes]
    assert all(kind.surface.closed and kind.mesh_file.name == "textured.obj" for kind in types)
