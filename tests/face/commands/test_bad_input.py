"""Bad input: one clear line a mistake on stderr, exit 1, nothing on stdout, nothing written, no traceback; bad usage: exit 2."""

from __future__ import annotations

import json
import shutil

import pytest
from console import bytes_in, document, good, plogic
from small_kb import KB, OBJECT, write_small

from kb.files.shipped import shipped

ONE = {"id": "a1", "type": "l_junction", "uv": [10.0, 20.0], "detector": "junction"}
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


def refused(folder, *args, stdin=None):
    """The lines on stderr of a command that must fail on its input and leave its folder as it was."""
    before = bytes_in(folder)
    run = plogic(*args, cwd=folder, stdin=stdin)
    assert "Traceback" not in run.stderr
    assert "internal error" not in run.stderr
    assert (run.returncode, run.stdout) == (1, ""), run.stderr
    assert bytes_in(folder) == before
    lines = run.stderr.splitlines()
    assert all(line.startswith("plogic: ") for line in lines), run.stderr
    return [line.removeprefix("plogic: ") for line in lines]


def assert_lines(lines, wanted):
    """As many lines as mistakes, each mistake in one of them."""
    assert len(lines) == len(wanted), lines
    for part in wanted:
        assert sum(part in line for line in lines) == 1, lines


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
        "nowhere": "no knowledge base 'nowhere' comes with plogic; these do: first, lookalikes, towers",
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
        ["appearances.0.uv.0: input should be a finite number, not nan"],
    ),
    "an infinite angle": (
        {"appearances": [{**ONE, "angle": float("inf")}]},
        ["appearances.0.angle: input should be a finite number"],
    ),
    "an unknown type": (
        {"appearances": [{**ONE, "type": "zork"}]},
        ["appearances.0.type: 'zork' is no appearance type of the KB"],
    ),
    "a place outside the image": (
        {"appearances": [{**ONE, "uv": [640.0, 3]}]},
        ["appearances.0.uv: [640.0, 3] is outside the image of 640x480"],
    ),
    "another format": ({"format": "gamma/9"}, ["format: input should be 'gamma/1', not 'gamma/9'"]),
    "no camera": ({"camera": None}, ["camera: "]),
    "a camera with a NaN": (
        {"camera": {"width": 640, "height": 480, "K": [[float("nan"), 0, 1], [0, 1, 1], [0, 0, 1]]}},
        ["camera.K: must be"],
    ),
    "two mistakes": (
        {"appearances": [{**ONE, "type": "zork"}, {**ONE, "uv": [1.0]}]},
        [
            "appearances.0.type: 'zork'",
            "appearances.1.uv: list should have at least 2",
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
    assert all(line.startswith("gamma.json: ") for line in lines)


def test_a_bad_gamma_on_stdin_is_called_so(tmp_path, gamma):
    text = json.dumps({**gamma, "appearances": [ONE, ONE]})
    assert_lines(
        refused(tmp_path, "perceive", "-", "--kb", "towers", "-o", "out.json", stdin=text),
        ["<stdin>: appearances.1.id"],
    )
    assert_lines(refused(tmp_path, "perceive", "-", "--kb", "towers"), ["<stdin>:1:1: is not JSON"])
    assert_lines(
        refused(tmp_path, "kb", "measures", "towers", "--gamma", "-", stdin=text), ["<stdin>: appearances.1.id"]
    )


@pytest.fixture
def inputs(demo, tmp_path):
    """A folder with the demo's image, camera and interpretation, and several files that are none."""
    for name in ("image.png", "camera.json", "interpretation.json"):
        shutil.copy(demo / name, tmp_path)
    camera = json.loads((demo / "camera.json").read_text())
    (tmp_path / "small.json").write_text(json.dumps({**camera, "width": 320}))
    for name in ("empty.png", "empty.json"):
        (tmp_path / name).touch()
    (tmp_path / "text.png").write_text("this is no image " * 99)
    (tmp_path / "cut.png").write_bytes((demo / "image.png").read_bytes()[:5000])
    (tmp_path / "cut.json").write_bytes((demo / "interpretation.json").read_bytes()[:5000])
    for name in ("folder.png", "folder.json", "folder.pl"):
        (tmp_path / name).mkdir()
    (tmp_path / "hostile.pl").write_text(":- use_module('x.py').\n0.5::a.\nquery(a).\n")
    (tmp_path / "syntax.pl").write_text("0.5::a.\nb :- .\n")
    (tmp_path / "x.py").write_text("from pathlib import Path\nPath('pwned').touch()\n")
    return tmp_path


IMAGES = {
    ("image.png",): "image.png: an image needs its camera: give --camera FILE",
    ("image.png", "--camera", "small.json"): "small.json: the camera is 320x480, but image.png is 640x480",
    ("image.png", "--camera", "nowhere.json"): "nowhere.json: cannot be read: No such file",
    ("image.png", "--camera", "empty.json"): "empty.json: must be a camera",
    ("image.png", "--camera", "folder.json"): "folder.json: cannot be read: Is a directory",
    ("image.png", "--camera", "image.png"): "image.png: ",
    ("nowhere.png", "--camera", "camera.json"): "nowhere.png: cannot be read: No such file",
    ("empty.png", "--camera", "camera.json"): "empty.png: is empty",
    ("text.png", "--camera", "camera.json"): "text.png: is not an image",
    ("cut.png", "--camera", "camera.json"): "cut.png: the PNG file is cut off after 5000 bytes",
    ("folder.png", "--camera", "camera.json"): "folder.png: cannot be read: Is a directory",
    ("nowhere.json",): "nowhere.json: cannot be read: No such file",
    ("empty.json",): "empty.json:1:1: is not JSON",
    ("folder.json",): "folder.json: cannot be read: Is a directory",
}


@pytest.mark.parametrize("args", IMAGES, ids=" ".join)
def test_a_bad_image_camera_or_file(args, inputs):
    assert_lines(
        refused(inputs, "perceive", *args, "--kb", "towers", "-o", "out.json", "--picture", "picture.png"),
        [IMAGES[args]],
    )


ASKED = {
    ("worlds", "nowhere.json"): "nowhere.json: cannot be read: No such file",
    ("worlds", "folder.json"): "folder.json: cannot be read: Is a directory",
    ("worlds", "empty.json"): "empty.json:1:1: is no JSON",
    ("worlds", "cut.json"): "cut.json:1:5001: is no JSON",
    ("worlds", "image.png"): "image.png: is no JSON: byte 0 is no UTF-8",
    ("worlds", "camera.json"): "camera.json: format: should be 'interpretation/1'",
    ("program", "empty.json"): "empty.json:1:1: is no JSON",
    ("report", "empty.json", "-o", "page.html"): "empty.json:1:1: is no JSON",
    ("query", "interpretation.json", "present(h1"): "goal:1:8: Unmatched character '('",
    ("query", "interpretation.json", "zork(h1)"): "goal:1:1: no clauses for zork/1",
    ("query", "interpretation.json", "use_module('x.py')"): "goal:1:1: use_module/1 is not allowed",
    ("query", "interpretation.json", "consult('x.py')"): "goal:1:1: consult/1 is not allowed",
    ("query", "interpretation.json", "present(H)", "--given", "zork("): "given:1:5: Unmatched",
    ("query", "interpretation.json", "present(H)", "--given", "zork(h1)"): "given:1:1: no clauses for zork/1",
    (
        "query",
        "interpretation.json",
        "present(H)",
        "--given",
        "present(h1)",
        "--given",
        "\\+ present(h1)",
    ): "no world satisfies the evidence",
    (
        "query",
        "interpretation.json",
        "present(H)",
        "--rules",
        "hostile.pl",
    ): "hostile.pl:1:4: directive use_module('x.py')",
    ("query", "interpretation.json", "present(H)", "--rules", "syntax.pl"): "syntax.pl:2:",
    ("query", "interpretation.json", "present(H)", "--rules", "nowhere.pl"): "nowhere.pl: cannot be read: No such file",
    ("query", "interpretation.json", "present(H)", "--rules", "folder.pl"): "folder.pl: cannot be read: Is a directory",
    ("query", "hostile.pl"): "hostile.pl:1:4: directive use_module('x.py')",
    ("query", "syntax.pl"): "syntax.pl:2:",
    ("query", "nowhere.pl"): "nowhere.pl: cannot be read: No such file",
    ("query", "folder.pl"): "folder.pl: cannot be read: Is a directory",
    ("explain", "interpretation.json", "present(h1"): "goal:1:8: Unmatched character '('",
    ("explain", "interpretation.json", "zork(h1)"): "goal:1:1: no clauses for zork/1",
    ("explain", "hostile.pl", "a"): "hostile.pl:1:4: directive use_module('x.py')",
}


@pytest.mark.parametrize("args", ASKED, ids=" ".join)
def test_a_bad_question(args, inputs):
    assert_lines(refused(inputs, *args), [ASKED[args]])


INTERPRETATIONS = {
    "no facts": (lambda d: d.pop("facts"), "facts: is missing"),
    "no such reading": (lambda d: d.update(reading="zork"), "reading: 'zork' should be one of score, posterior"),
    "no such mode": (
        lambda d: d.update(reconsider=["drop"]),
        "reconsider: ['drop'] should be one of to_B, drop, reassign",
    ),
    "a NaN": (lambda d: d["hypotheses"][0]["features"][0].update(dv=float("nan")), "is no JSON: NaN is no number"),
    "a negative density": (
        lambda d: d["hypotheses"][0]["features"][0].update(density=-1.0),
        "hypotheses.0.features.0.density: -1.0 is not a number from 0.0",
    ),
    "a duplicate id": (lambda d: d["hypotheses"].insert(0, d["hypotheses"][0]), "hypothesis 'h1' occurs twice"),
    "no list": (lambda d: d.update(hypotheses="h1"), "hypotheses: 'h1' is no list"),
    "hostile rules": (lambda d: d.update(rules=":- use_module('x.py')."), "rules.pl:1:4: directive use_module('x.py')"),
}


@pytest.mark.parametrize("kind", INTERPRETATIONS)
def test_a_bad_interpretation(kind, inputs):
    spoil, wanted = INTERPRETATIONS[kind]
    spoilt = json.loads((inputs / "interpretation.json").read_text())
    spoil(spoilt)
    (inputs / "spoilt.json").write_text(json.dumps(spoilt))
    assert_lines(refused(inputs, "program", "spoilt.json"), [wanted])
    assert_lines(refused(inputs, "query", "-", "present(H)", stdin=json.dumps(spoilt)), [wanted])


OUTPUTS = {
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "no/out.json",
        "--report",
        "page.html",
    ): "no/out.json: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "out.json",
        "--report",
        "no/page.html",
    ): "no/page.html: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "out.json",
        "--timings",
        "no/t.json",
    ): "no/t.json: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "--picture",
        "no/p.png",
    ): "no/p.png: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "folder.json",
        "--report",
        "page.html",
    ): "folder.json: cannot be written: Is a directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "empty.png/x",
        "--report",
        "page.html",
    ): "empty.png/x: cannot be written: Not a directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "x.json",
        "--timings",
        "x.json",
    ): "x.json: is named for two outputs",
    ("report", "interpretation.json", "-o", "no/page.html"): "no/page.html: cannot be written: No such directory",
    ("report", "interpretation.json", "-o", "folder.json"): "folder.json: cannot be written: Is a directory",
    ("simulate", "--kb", "towers", "-o", "empty.png"): "empty.png: exists already and is not an empty folder",
    ("simulate", "--kb", "towers", "-o", "empty.png/x"): "empty.png/x: cannot be written",
    ("demo", "-o", "empty.png"): "empty.png: cannot be written: empty.png is no folder",
}


@pytest.mark.parametrize("args", OUTPUTS, ids=" ".join)
def test_an_output_that_cannot_be_written(args, inputs, gamma):
    (inputs / "gamma.json").write_text(json.dumps({**gamma, "appearances": [ONE]}))
    assert_lines(refused(inputs, *args), [OUTPUTS[args]])


@pytest.mark.parametrize(("appearances", "reading"), [([], "score"), ([ONE], "score"), ([ONE], "posterior")])
def test_little_data_is_an_answer_the_empty_world(appearances, reading, tmp_path, gamma):
    text = json.dumps({**gamma, "appearances": appearances})
    interpretation = good("perceive", "-", "--kb", "towers", "--reading", reading, stdin=text)
    assert json.loads(interpretation)["worlds"] == [
        {"probability": 1.0, "present": [], "causes": {a["id"]: "noise" for a in appearances}}
    ]
    found = document("worlds", "-", "--json", stdin=interpretation)
    assert [(w["probability"], w["present"]) for w in found["worlds"]] == [(1.0, [])]
    assert found["unlisted_mass"] == [0.0, 0.0]
    assert document("query", "-", "present(H)", "--json", stdin=interpretation)["answers"] == []


def test_every_command_answers_on_the_empty_world(gamma):
    interpretation = good("perceive", "-", "--kb", "towers", stdin=json.dumps({**gamma, "appearances": []}))
    assert "nothing known" in good("worlds", "-", stdin=interpretation)
    assert document("query", "-", "present(h1)", "--json", stdin=interpretation)["answers"][0]["probability"] == 0.0
    assert good("report", "-", "-o", "-", stdin=interpretation).lstrip().lower().startswith("<!doctype html>")


def test_an_image_that_shows_nothing_is_an_answer(tmp_path, demo):
    import cv2
    import numpy as np

    cv2.imwrite(str(tmp_path / "grey.png"), np.full((480, 640, 3), 128, np.uint8))
    found = json.loads(good("perceive", tmp_path / "grey.png", "--camera", demo / "camera.json", "--kb", "towers"))
    assert [(w["probability"], w["present"]) for w in found["worlds"]] == [(1.0, [])]


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
