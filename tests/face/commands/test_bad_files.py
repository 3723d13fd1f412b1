"""Files that are none, names that no file can have, numbers that no float can hold, nesting without end.

One plain line each, nothing written.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from console import bytes_in, good, plogic
from made_meshes import obj_text, split_box, write_box
from small_kb import KB, OBJECT, write_small

from kb.files.read import read_kb
from plogic.face.authoring.kb_types import new_command

LONG = "n" * 300
TOO_LONG = "has a name that is too long for a file"
LOOP = "is a link that leads back to itself"
PIPE = "is no plain file, but a pipe or a device"
HUGE = "9" * 400
DEEP = "[" * 100_000 + "]" * 100_000


def the_line(folder, *args):
    """The one line on stderr of a command that must fail, and write nothing."""
    before = sorted(bytes_in(folder))
    run = plogic(*args, cwd=folder)
    assert (run.returncode, run.stdout, sorted(bytes_in(folder))) == (1, "", before)
    assert "internal error" not in run.stderr
    (line,) = run.stderr.splitlines()
    return line.removeprefix("plogic: ")


def loop(path):
    path.unlink(missing_ok=True)
    path.symlink_to(path)


NAMED = {
    "mesh": (OBJECT.replace("mesh.obj", f"{LONG}.obj"), KB, "objects/tent/object.yaml:2:14: mesh.file: the mesh 'nnn"),
    "textured": (
        OBJECT.replace("units: cm", f"units: cm, textured: {LONG}"),
        KB,
        "objects/tent/object.yaml:2:45: mesh.textured: the mesh 'nnn",
    ),
    "cloud": (f"{OBJECT}cloud: {{file: {LONG}}}\n", KB, "objects/tent/object.yaml:27:15: cloud.file: the file 'nnn"),
    "words": (OBJECT, f"{KB}words: {{file: {LONG}}}\n", "kb.yaml:10:15: words.file: the file 'nnn"),
}


@pytest.mark.parametrize("key", NAMED)
def test_a_kb_that_names_a_file_that_cannot_be(key, tmp_path):
    text, kb, place = NAMED[key]
    write_small(tmp_path / "mykb", object=text, kb=kb)
    lines = [line.removeprefix("plogic: ") for line in plogic("kb", "check", "mykb", cwd=tmp_path).stderr.splitlines()]
    assert any(line.startswith(place) and line.endswith(TOO_LONG) for line in lines), lines


SPOILT = {
    "kb.yaml": f"kb.yaml: the file {LOOP}",
    "objects/tent/object.yaml": f"objects/tent/object.yaml: the file {LOOP}",
    "objects/tent/mesh.obj": f"objects/tent/object.yaml:2:14: mesh.file: the mesh 'mesh.obj' {LOOP}",
    "rules.pl": f"rules.pl: the file {LOOP}",
    "objects/other": f"objects/other: must be a folder, but it {LOOP}",
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_kb_with_a_link_to_itself(name, tmp_path):
    write_small(tmp_path / "mykb")
    loop(tmp_path / "mykb" / name)
    assert the_line(tmp_path, "kb", "check", "mykb") == SPOILT[name]


def test_a_kb_whose_objects_are_no_folder(tmp_path):
    write_small(tmp_path / "mykb")
    (tmp_path / "mykb/objects").rename(tmp_path / "mykb/away")
    (tmp_path / "mykb/objects").touch()
    assert the_line(tmp_path, "kb", "check", "mykb") == "objects: must be a folder, but it is a file"


@pytest.mark.parametrize(("name", "fault"), [(LONG, TOO_LONG), ("a", LOOP)], ids=["long", "loop"])
def test_a_place_that_cannot_be(name, fault, tmp_path):
    loop(tmp_path / "a")
    write_box(tmp_path / "m.obj")
    assert fault in the_line(tmp_path, "kb", "check", f"./{name}")
    assert fault in the_line(
        tmp_path, "kb", "add", "x", "--mesh", tmp_path / name / "m.obj", "--units", "m", "--kb", tmp_path / "kb"
    )
    good("kb", "new", tmp_path / "kb")
    assert fault in the_line(tmp_path, "kb", "import", name, "--kb", "kb")
    assert fault in the_line(tmp_path, "bop", name, "--kb", "towers", "-o", "out.csv")
    assert the_line(tmp_path, "kb", "new", name, "--name", "k").startswith(f"{name}: ")


def test_what_is_named_beside_a_mesh_is_left_out_and_said(tmp_path):
    good("kb", "new", tmp_path / "kb")
    loop(tmp_path / "loop.png")
    os.mkfifo(tmp_path / "pipe.png")
    os.mkfifo(tmp_path / "pipe.mtl")
    vertices, triangles, uv = split_box()
    for i, name in enumerate([f"{LONG}.png", "loop.png", "pipe.png"]):
        (tmp_path / f"m{i}.mtl").write_text(f"newmtl paint\nmap_Kd {name}\n")
    for i, library in enumerate(["m0.mtl", "m1.mtl", "m2.mtl", "pipe.mtl", f"{LONG}.mtl"]):
        (tmp_path / f"{i}.obj").write_text(obj_text(vertices, triangles, uv, library))
        text = good("kb", "add", f"t{i}", "--mesh", tmp_path / f"{i}.obj", "--units", "m", "--kb", tmp_path / "kb")
        assert "going on without" in text


def shape(mesh):
    return f'<robot><link name="b"><visual><geometry>{mesh}</geometry></visual></link></robot>'


ROBOTS = {
    "long.urdf": (shape(f'<mesh filename="{LONG}.obj"/>'), "link 'b': the mesh 'nnn"),
    "package.urdf": (
        shape(f'<mesh filename="package://{LONG}/m.obj"/>'),
        "link 'b': the mesh 'package://nnn",
    ),
    "loop.urdf": (shape('<mesh filename="loop.obj"/>'), "link 'b': the mesh 'loop.obj'"),
    "deep.sdf": (
        "<sdf>" + "<model>" * 5000 + "</model>" * 5000 + "</sdf>",
        "its elements are nested deeper than 60 levels",
    ),
    "deep.urdf": (
        "<robot>" + "<link>" * 5000 + "</link>" * 5000 + "</robot>",
        "its elements are nested deeper than 60 levels",
    ),
    "large.urdf": (
        shape('<box size="1e308 1 1"/>'),
        "box: size: must be 3 finite numbers below 1e+09, not '1e308 1 1'",
    ),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_a_hostile_robot(name, tmp_path):
    new_command(tmp_path / "kb", None)
    loop(tmp_path / "loop.obj")
    (tmp_path / name).write_text(ROBOTS[name][0])
    line = the_line(tmp_path, "kb", "import", name, "--kb", "kb")
    assert line.startswith(f"{name}: ")
    assert ROBOTS[name][1] in line


def test_a_pipe_is_no_robot(tmp_path):
    new_command(tmp_path / "kb", None)
    os.mkfifo(tmp_path / "pipe.urdf")
    assert the_line(tmp_path, "kb", "import", "pipe.urdf", "--kb", "kb") == f"pipe.urdf: {PIPE}"


def axis(number):
    return f'{{"1": {{"symmetries_continuous": [{{"axis": [{number}, 0, 0]}}]}}}}'


INFOS = {
    "deep": (f'{{"1": {DEEP}}}', ": is nested too deeply"),
    "400 digits": (
        axis(HUGE),
        "models_info.json: obj_000001: symmetries_continuous: must be 3 finite numbers below 1e+09, not [999",
    ),
    "5000 digits": (axis("9" * 5000), "models_info.json:1:44: holds a whole number of more digits than can be read"),
    "a huge exponent": (axis("1e308"), "must be 3 finite numbers below 1e+09, not [1e+308"),
    "texts": (axis('"1"'), "must be 3 finite numbers below 1e+09, not ['1', 0, 0]"),
    "no UTF-8": (b'{"1": "\xff"}', "models_info.json:1:8: is no JSON: byte 7 is no UTF-8"),
    "cut off": ('{"1":\n {', "models_info.json:2:3: is no JSON: Expecting property name"),
    "a loop": (loop, f"models_info.json: {LOOP}"),
    "a pipe": (os.mkfifo, f"models_info.json: {PIPE}"),
    "a folder": (Path.mkdir, "models_info.json: is a folder, not a file"),
}


def put(path, content):
    """Write a text or bytes, or make what a function makes there."""
    path.unlink(missing_ok=True)
    if callable(content):
        content(path)
    else:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())


@pytest.mark.parametrize("case", INFOS)
def test_hostile_models(case, tmp_path):
    from bop_folders import models

    new_command(tmp_path / "kb", None)
    models(tmp_path / "models")
    put(tmp_path / "models/models_info.json", INFOS[case][0])
    line = the_line(tmp_path, "kb", "import", "models", "--kb", "kb")
    assert line.startswith("models/models_info.json")
    assert INFOS[case][1] in line


def test_rates_of_a_shipped_kb_are_nobodys_to_change(tmp_path):
    (tmp_path / "truth.json").write_text(json.dumps({}))
    assert (
        the_line(tmp_path, "kb", "learn-rates", ".", "--kb", "towers")
        == "towers: is shipped with plogic: copy its folder, and change the copy"
    )


HALVES = {
    "name": (KB.replace("name: small", 'name: "\\ud800x"'), OBJECT, "kb.yaml:1:7: name: holds half of a character"),
    "object": (
        KB.replace("tent", "other"),
        OBJECT.replace("object: tent", 'object: "\\udfff"'),
        "object.yaml:1:9: object: holds half of",
    ),
    "mesh": (KB, OBJECT.replace("mesh.obj", '"\\ud800.obj"'), "object.yaml:2:14: mesh.file: holds half of a character"),
    "key": (KB.replace("apex: 0.9", '"\\ud800": 0.9'), OBJECT, "kb.yaml:5:9: detector.hit: holds half of a character"),
}


@pytest.mark.parametrize("where", HALVES)
def test_half_of_a_character_can_be_told(where, tmp_path):
    kb, text, said = HALVES[where]
    write_small(tmp_path / "mykb", kb=kb, object=text)
    run = plogic("kb", "check", "mykb", cwd=tmp_path)
    assert (run.returncode, "internal error" in run.stderr) == (1, False)
    assert any(said in line for line in run.stderr.splitlines()), run.stderr


def test_two_halves_of_a_character_are_one(tmp_path):
    assert (
        read_kb(write_small(tmp_path / "mykb", kb=KB.replace("name: small", 'name: "\\ud83d\\ude00"'))).name
        == "\N{GRINNING FACE}"
    )
