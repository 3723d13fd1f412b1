"""Bad input: one clear line a mistake on stderr, exit 1, nothing on stdout, nothing written, no traceback.

Bad usage: exit 2.
"""

from __future__ import annotations

import json
import re
import shutil

import pytest
from console import bytes_in, good, plogic
from refusals import ONE, assert_lines, refused
from small_kb import KB, OBJECT, write_small

from kb.files.folder import shipped

BODY = "  - part: body\n    features: []\n"

KBS = {
    "a mixed part list": (
        {"object": OBJECT.replace(BODY, "  - {feature: stray, type: corner, at: [0, 0, 0]}\n")},
        ["A1: the parts of 'tent' must be all of one kind"],
    ),
    "a cycle (YAML alias)": (
        {"object": OBJECT.replace(BODY, "  - &me\n    part: body\n    parts: [*me]\n")},
        ["A2: an alias makes this a part of itself"],
    ),
    "a cycle through the list": (
        {"object": OBJECT.replace("parts:\n", "parts: &all\n", 1).replace(BODY, "  - part: body\n    parts: *all\n")},
        ["A2: an alias makes this a part of itself"],
    ),
    "a duplicate id": (
        {"object": OBJECT.replace("part: body", "part: roof")},
        ["object.yaml:25:5: parts.1: 'roof' is the name of another part"],
    ),
    "a NaN": ({"object": OBJECT.replace("[10 cm, 0, 50 cm]", "[.nan, 0, 50 cm]")}, ["at.0: must be finite, not .nan"]),
    "an unknown type": (
        {"object": OBJECT.replace("type: apex, lobe", "type: zork, lobe")},
        ["unknown appearance type 'zork'"],
    ),
    "a missing mesh": ({"mesh": None}, ["object.yaml:2:14: mesh.file: the mesh 'mesh.obj' is missing"]),
    "a mesh that is none": ({"mesh": "hello"}, ["mesh.obj holds no facets"]),
    "a mesh without units": ({"object": OBJECT.replace(", units: cm", "")}, ["no mesh format carries its unit"]),
    "an empty kb.yaml": ({"kb": ""}, ["kb.yaml:1:1: the file is empty"]),
    "an empty object.yaml": ({"object": ""}, ["object.yaml:1:1: the file is empty"]),
    "a key given twice": ({"kb": KB + "name: other\n"}, ["kb.yaml:10:1: name: this key was given before"]),
    "hostile rules": (
        {"rules": ":- use_module('x.py').\n"},
        ["rules.pl:1:4: directive use_module('x.py'): only use_module(library(L)) is allowed"],
    ),
    "rules that do not parse": ({"rules": "near(X) :- .\n"}, ["rules.pl:1:"]),
    "three mistakes": (
        {
            "mesh": None,
            "object": OBJECT.replace("[10 cm, 0, 50 cm]", "[.inf, 0, 50 cm]").replace("part: body", "part: roof"),
        },
        ["the mesh 'mesh.obj' is missing", "must be finite, not .inf", "'roof' is the name of another part"],
    ),
}


@pytest.mark.parametrize("kind", KBS)
def test_a_bad_kb(kind, tmp_path, gamma):
    changed, wanted = KBS[kind]
    write_small(tmp_path / "mykb", **changed)
    assert_lines(refused(tmp_path, "kb", "check", "mykb"), wanted)
    (tmp_path / "gamma.json").write_text(json.dumps({**gamma, "appearances": []}))
    assert_lines(
        refused(tmp_path, "perceive", "gamma.json", "--kb", "mykb", "-o", "out.json", "--report", "page.html"), wanted
    )


@pytest.mark.parametrize("command", [("show",), ("measures",), ("check", "--json")], ids=" ".join)
def test_a_bad_kb_in_the_other_commands(command, tmp_path):
    write_small(tmp_path / "mykb", mesh=None)
    assert_lines(refused(tmp_path, "kb", command[0], "mykb", *command[1:]), ["the mesh 'mesh.obj' is missing"])
    assert_lines(refused(tmp_path, "simulate", "--kb", "mykb", "-o", "scene"), ["the mesh 'mesh.obj' is missing"])


def test_a_kb_that_is_not_there(tmp_path, gamma):
    (tmp_path / "gamma.json").write_text(json.dumps(gamma))
    (tmp_path / "empty").mkdir()
    wanted = {
        "nowhere": "no knowledge base 'nowhere' comes with plogic; these do: first, lookalikes, paper, towers",
        "./nowhere": "nowhere: there is no such folder",
        "empty": "empty: the folder holds no kb.yaml",
        "gamma.json": "gamma.json: is a file, not a folder",
    }
    for name, line in wanted.items():
        assert_lines(refused(tmp_path, "perceive", "gamma.json", "--kb", name, "-o", "out.json"), [line])


GAMMAS = {
    "a duplicate id": ({"appearances": [ONE, ONE]}, ["appearances.1.id: 'a1' is already the id of appearances.0"]),
    "a NaN": (
        {"appearances": [{**ONE, "uv": [float("nan"), 3]}]},
        ["appearances.0.uv.0: nan is not a number"],
    ),
    "an infinite angle": (
        {"appearances": [{**ONE, "angle": float("inf")}]},
        ["appearances.0.angle: inf is not a number"],
    ),
    "an unknown type": (
        {"appearances": [{**ONE, "type": "zork"}]},
        ["appearances.0.type: 'zork' is no appearance type of the KB"],
    ),
    "a place outside the image": (
        {"appearances": [{**ONE, "uv": [640.0, 3]}]},
        ["appearances.0.uv: [640.0, 3] is outside the image of 640x480"],
    ),
    "another format": ({"format": "gamma/9"}, ["gamma.json:1:12: format: 'gamma/9' should be 'gamma/1'"]),
    "no camera": ({"camera": None}, ["camera: "]),
    "a camera with a NaN": (
        {"camera": {"width": 640, "height": 480, "K": [[float("nan"), 0, 1], [0, 1, 1], [0, 0, 1]]}},
        ["camera.K: must be"],
    ),
    "two mistakes": (
        {"appearances": [{**ONE, "type": "zork"}, {**ONE, "uv": [1.0]}]},
        [
            "appearances.0.type: 'zork'",
            "appearances.1.uv: a list of 1, and not of 2",
            "appearances.1.id: 'a1' is already",
        ],
    ),
}


@pytest.mark.parametrize("kind", GAMMAS)
def test_a_bad_gamma(kind, tmp_path, gamma):
    changed, wanted = GAMMAS[kind]
    text = json.dumps({**gamma, "appearances": [ONE], **changed})
    (tmp_path / "gamma.json").write_text(text)
    lines = refused(tmp_path, "perceive", "gamma.json", "--kb", "towers", "-o", "out.json", "--report", "page.html")
    assert_lines(lines, wanted)
    assert all(re.match(r"gamma\.json:1:\d+: ", line) for line in lines)


def test_a_bad_gamma_on_stdin_is_called_so(tmp_path, gamma):
    text = json.dumps({**gamma, "appearances": [ONE, ONE]})
    assert_lines(
        refused(tmp_path, "perceive", "-", "--kb", "towers", "-o", "out.json", stdin=text),
        ["<stdin>:1:539: appearances.1.id"],
    )
    assert_lines(refused(tmp_path, "perceive", "-", "--kb", "towers"), ["<stdin>:1:1: is no JSON"])
    assert_lines(
        refused(tmp_path, "kb", "measures", "towers", "--gamma", "-", stdin=text), ["<stdin>:1:539: appearances.1.id"]
    )


IMAGES = {
    ("alone/image.png",): "alone/image.png: an image needs its camera: give --camera FILE",
    ("image.png", "--camera", "small.json"): "small.json: the camera is 320x480, but image.png is 640x480",
    ("image.png", "--camera", "nowhere.json"): "nowhere.json: cannot be read: No such file",
    ("image.png", "--camera", "empty.json"): "empty.json: must be a camera",
    (
        "image.png",
        "--camera",
        "folder.json",
    ): "folder.json: cannot be read: it is a folder without COLMAP's cameras.bin",
    ("image.png", "--camera", "image.png"): "image.png:1:1: is no camera: byte 0 is no UTF-8",
    ("nowhere.png", "--camera", "camera.json"): "nowhere.png: cannot be read: No such file",
    ("empty.png", "--camera", "camera.json"): "empty.png: is empty",
    ("text.png", "--camera", "camera.json"): "text.png: is not an image",
    ("cut.png", "--camera", "camera.json"): "cut.png: the PNG file is cut off after 5000 bytes",
    ("folder.png", "--camera", "camera.json"): "folder.png: cannot be read: Is a directory",
    ("nowhere.json",): "nowhere.json: cannot be read: No such file",
    ("empty.json",): "empty.json:1:1: is no JSON",
    ("folder.json",): "folder.json: cannot be read: Is a directory",
}


@pytest.mark.parametrize("args", IMAGES, ids=" ".join)
def test_a_bad_image_camera_or_file(args, inputs):
    assert_lines(
        refused(inputs, "perceive", *args, "--kb", "towers", "-o", "out.json", "--picture", "picture.png"),
        [IMAGES[args]],
    )


USAGES = [
    (),
    ("zork",),
    ("worlds",),
    ("worlds", "a.json", "-n", "0"),
    ("worlds", "a.json", "--reading", "zork"),
    ("perceive", "a.json"),
    ("perceive", "a.json", "--kb", "towers", "--deadline", "0"),
    ("perceive", "a.json", "--kb", "towers", "--deadline", "nan"),
    ("perceive", "a.json", "--kb", "towers", "--smoothing", "nan"),
    ("perceive", "a.json", "--kb", "towers", "--smoothing", "0.5"),
    ("perceive", "a.json", "--kb", "towers", "--reconsider", "zork"),
    ("explain", "a.json"),
    ("report", "a.json"),
    ("demo", "--seed", "x"),
    ("demo", "--seed", "-1"),
    ("demo", "--look-again", "--reading", "score"),
    ("bench", "towers", "--quick"),
    ("bench", "worlds", "--picture", "x.svg"),
    ("bench", "box", "--pictures", "folder"),
    ("simulate", "--kb", "towers", "--objects", "-1", "-o", "scene"),
    ("kb",),
    ("kb", "zork"),
    ("kb", "schema", "zork"),
]


@pytest.mark.parametrize("args", USAGES, ids=" ".join)
def test_bad_usage_exits_with_2(args, tmp_path):
    run = plogic(*args, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith("Usage: plogic")
    assert bytes_in(tmp_path) == {}


def test_a_copy_of_the_shipped_kb_is_good_and_one_without_its_mesh_is_not(tmp_path):
    shutil.copytree(shipped("towers"), tmp_path / "mine")
    assert good("kb", "check", tmp_path / "mine") == good("kb", "check", "towers")
    (tmp_path / "mine/objects/t1/mesh.obj").unlink()
    assert_lines(refused(tmp_path, "kb", "check", "mine"), ["objects/t1/object.yaml:"])
