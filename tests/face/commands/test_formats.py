"""docs/formats.md and ``plogic schema``: examples are read, schemas fit what is written, wrong documents are told."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path

import numpy as np
import pytest
from console import good, plogic
from formats_page import tables
from jsonschema import Draft202012Validator
from spoilt_documents import spoilt

from geometry.errors import PlogicError
from geometry.files.camera_files import read_camera
from geometry.files.documents import parsed_json
from geometry.files.json_schema import name_of
from geometry.files.pose_files import read_moves, read_poses
from geometry.json_checks import check_of, mistakes
from geometry.json_shapes import parts_of
from plogic.base.errors import InputError
from plogic.face.commands.clicked import FORMATS
from plogic.face.commands.formats import formats, schema_command
from plogic.facts.interpretation import read_interpretation
from plogic.rates.scene_records import read_truth
from plogic.run.batch.log import read_lines
from plogic.sequence.constancy.panorama_reading import unknown_of
from plogic.sequence.next_view.reading import read_looked
from sensing.files.gamma_files import read_gamma
from sensing.files.stereo import read_stereo

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^## Format (\w+)\n.*?^```json\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))
WHOLE = {name: json.loads(text) for name, text in EXAMPLES.items()}
POSE = np.eye(4).tolist()
MIRROR = np.diag([1.0, 1.0, -1.0, 1.0]).tolist()


def held(path):
    """A document that is only written, against its shape."""
    found = parsed_json(path.read_text(encoding="utf-8"), str(path), "", InputError)
    wrong = list(check_of(formats()[path.stem].shape)(found.data))
    if wrong:
        raise InputError("\n".join(found.told(wrong)))
    return found.data


READERS = {
    "gamma": read_gamma,
    "camera": read_camera,
    "poses": read_poses,
    "moves": read_moves,
    "stereo": read_stereo,
    "truth": lambda path: read_truth(path, {"box"}),
    "interpretation": read_interpretation,
    "panorama": read_looked,
    "answers": held,
    "frame": held,
    "doctor": held,
}


def read(name, folder, text):
    path = folder / f"{name}.json"
    path.write_text(text, encoding="utf-8")
    return READERS[name](path)


def test_there_is_a_schema_and_an_example_of_every_format():
    assert tuple(formats()) == FORMATS == tuple(EXAMPLES) == tuple(READERS)


@pytest.mark.parametrize("name", FORMATS)
def test_the_example_in_the_docs_is_read(name, tmp_path):
    assert read(name, tmp_path, EXAMPLES[name])
    assert list(Draft202012Validator(json.loads(schema_command(name))).iter_errors(WHOLE[name])) == []


def test_the_examples_are_of_use(tmp_path):
    for name in ("interpretation", "panorama", "frame"):
        (tmp_path / f"{name}.json").write_text(EXAMPLES[name], encoding="utf-8")
    asked = json.loads(good("query", "interpretation.json", "present(h1)", "--json", cwd=tmp_path))
    assert asked["answers"] == [{"goal": "present(h1)", "probability": 1.0, "interval": [1.0, 1.0]}]
    assert len(unknown_of(str(tmp_path / "panorama.json"), "u1")) == 1
    (tmp_path / "lines.jsonl").write_text(json.dumps(WHOLE["frame"]) + "\n", encoding="utf-8")
    (line,), _ = read_lines(tmp_path / "lines.jsonl", "lines.jsonl")
    assert line.input == "shelf/7.json"


def test_the_message_in_the_docs_is_what_is_said(tmp_path):
    (told,) = re.findall(r"^```text\n(.*?)\n```$", PAGE, re.DOTALL | re.MULTILINE)
    with pytest.raises(PlogicError) as caught:
        read("gamma", tmp_path, EXAMPLES["gamma"].replace("[312.4, 201.9]", "[312.4]"))
    assert str(caught.value) == f"{tmp_path}/{told}"


@pytest.mark.parametrize("name", FORMATS)
def test_every_key_is_explained(name):
    of = [
        (table, key, shape) for table in tables(formats()[name].shape) for key, shape in table.__annotations__.items()
    ]
    silent = [
        f"{table.__name__}.{key}" for table, key, shape in of if not parts_of(shape).meaning and not is_one_text(shape)
    ]
    assert of
    assert silent == []


def is_one_text(shape):
    return len(getattr(parts_of(shape).of, "__args__", ())) == 1 and isinstance(parts_of(shape).of.__args__[0], str)


def test_no_two_tables_have_one_name():
    every = {table for one in formats().values() for table in tables(one.shape)}
    assert len(every) > 40
    assert len({name_of(table) for table in every}) == len(every)


def test_the_command_prints_the_schema():
    schema = json.loads(good("schema", "gamma"))
    Draft202012Validator.check_schema(schema)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["$defs"]["GammaAppearance"]["required"] == ["id", "type", "uv"]
    assert plogic("schema", "zork").returncode == 2


def validated(name, text):
    validator = Draft202012Validator(json.loads(schema_command(name)))
    lines = [json.loads(line) for line in (text.splitlines() if name == "frame" else [text])]
    assert lines
    assert [error.message for line in lines for error in validator.iter_errors(line)] == []


def test_the_schemas_fit_what_commands_write(demo, tmp_path):
    for name in ("gamma", "camera", "interpretation"):
        validated(name, (demo / f"{name}.json").read_text(encoding="utf-8"))
    scene = demo / "interpretation.json"
    validated("answers", good("query", scene, "object(X, T)", "--json"))
    validated("answers", good("query", ROOT / "examples" / "alarm.pl", "--json"))
    good("simulate", "--kb", "towers", "-o", tmp_path / "scene")
    (tmp_path / "moves.json").write_text(EXAMPLES["moves"])
    good("simulate", "--kb", "towers", "--robot", tmp_path / "moves.json", "-o", tmp_path / "tour")
    validated("poses", (tmp_path / "tour" / "poses.json").read_text(encoding="utf-8"))
    validated("truth", (tmp_path / "scene" / "truth.json").read_text(encoding="utf-8"))
    validated("camera", (tmp_path / "scene" / "camera.json").read_text(encoding="utf-8"))


def test_the_schema_of_lines_fits_what_batch_writes(tmp_path):
    (tmp_path / "a.json").write_text((ROOT / "examples" / "first_gamma.json").read_text())
    (tmp_path / "b.json").write_text("{")
    for options in ((), ("--full",)):
        run = plogic("batch", "a.json", "b.json", "--kb", "first", "--jobs", "1", *options, cwd=tmp_path)
        assert [json.loads(line)["status"] for line in run.stdout.splitlines()] == ["done", "error"]
        validated("frame", run.stdout)


def test_the_schema_of_panoramas_fits_what_perceive_writes(tmp_path):
    posed = json.loads((ROOT / "examples" / "first_gamma.json").read_text())
    posed["camera"]["T_world_camera"] = POSE
    for name in ("a.json", "b.json"):
        (tmp_path / name).write_text(json.dumps(posed))
    good("perceive", "a.json", "b.json", "--kb", "first", "-o", "p.json", cwd=tmp_path)
    validated("panorama", (tmp_path / "p.json").read_text(encoding="utf-8"))


def changed(*keys_and_value):
    *keys, last, value = keys_and_value

    def change(whole):
        at = whole
        for key in keys:
            at = at[key]
        if value is GONE:
            del at[last]
        else:
            at[last] = value

    return change


GONE = object()
KNOWN = "unknown key; known are "
WRONG = [
    ("gamma", changed("camera", GONE), "camera: is missing: should be an object"),
    ("gamma", changed("format", "gamma/9"), "format: 'gamma/9' should be 'gamma/1'"),
    ("gamma", changed("appearances", {}), "appearances: {} is no list"),
    ("gamma", changed("appearances", 0, "uv", [1.5]), "appearances.0.uv: a list of 1, and not of 2"),
    ("gamma", changed("appearances", 0, "uv", 1, "240"), "appearances.0.uv.1: '240' is not a number"),
    ("gamma", changed("appearances", 1, "id", 7), "appearances.1.id: 7 is no text"),
    ("gamma", changed("appearances", 1, "type", GONE), "appearances.1.type: is missing: should be a text"),
    ("gamma", changed("appearances", 1, "type", ""), "appearances.1.type: a text of 0 characters, and not of 1 to 200"),
    ("gamma", changed("appearances", 1, "angel", 0.3), f"appearances.1.angel: {KNOWN}id, type, uv, detector, angle"),
    ("gamma", changed("appearances", 1, "scale", -4), "appearances.1.scale: -4 is not a number above 0.0"),
    ("camera", changed("width", "640"), "width: '640' is not a whole number from 1 to 65536"),
    ("camera", changed("height", GONE), "height: is missing: should be a whole number from 1 to 65536"),
    ("camera", changed("K", 2, [0, 0, 2]), "K: must be [[fx, skew, cx], [0, fy, cy], [0, 0, 1]], not"),
    ("camera", changed("K", [600, 600, 320, 240]), "K: must be a 3x3 matrix of finite numbers, not"),
    ("camera", changed("dist", [0.1, 0.2]), "dist: must be a list of 0, 4, 5, 8, 12, 14 finite numbers"),
    ("camera", changed("fov", 60), f"fov: {KNOWN}width, height, K, dist, T_world_camera"),
    ("poses", changed("frames", []), "frames: a list of 0, and not of 1 to"),
    ("poses", changed("frames", 0, "frame", 7), "frames.0.frame: 7 is no text"),
    ("poses", changed("frames", 1, "T_world_camera", [1, 2, 3]), "frames.1.T_world_camera: should be a rigid 4x4 matrix"),
    ("poses", changed("frames", 1, "pose", POSE), f"frames.1.pose: {KNOWN}frame, T_world_camera"),
    ("moves", changed("moves", 0, "name", None), "moves.0.name: None is no text"),
    ("moves", changed("moves", 1, "T_world_camera", "here"), "moves.1.T_world_camera: should be a rigid 4x4 matrix"),
    ("stereo", changed("T_right_left", GONE), "T_right_left: is missing: should be a rigid 4x4 matrix"),
    ("stereo", changed("left", "height", 0), "left.height: 0 is not a whole number from 1 to 65536"),
    ("stereo", changed("rigth", {}), f"rigth: {KNOWN}format, T_right_left, left, right"),
    ("truth", changed("objects", 0, "label", GONE), "objects.0.label: is missing: should be a text or null"),
    ("truth", changed("objects", 0, "visible_fraction", 1.5), "visible_fraction: 1.5 is not a number from 0.0 to 1.0"),
    ("truth", changed("complete", "yes"), "complete: 'yes' is neither true nor false"),
    ("interpretation", changed("reading", "bayes"), "reading: 'bayes' should be one of score, posterior"),
    ("interpretation", changed("hypotheses", 0, "status", "found"), "hypotheses.0.status: 'found' should be one of accepted"),
    ("interpretation", changed("priors", "box", "half"), "priors.box: 'half' is not a number"),
    ("interpretation", changed("hypotheses", 0, "features", 1, "match", 3), "hypotheses.0.features.1.match: 3 is no text"),
    ("interpretation", changed("types", "box", "lobes", 0, [0, 0]), "types.box.lobes.0: [0, 0] is no list of 9"),
    ("panorama", changed("views", 0, "gone", "p1"), "views.0.gone: 'p1' is no list"),
    ("panorama", changed("unlisted_mass", [0.0]), "unlisted_mass: a list of 1, and not of 2"),
    ("answers", changed("answers", 0, "probability", 1.5), "answers.0.probability: 1.5 is not a number from"),
    ("frame", changed("status", "ok"), "status: 'ok' should be one of done, unfinished"),
    ("frame", changed("appearances", "13"), "appearances: '13' is not a whole number"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "spoil", "said"), WRONG, ids=[said for _, _, said in WRONG])
def test_a_wrong_document_is_refused_by_schema_and_reader_in_one_line(name, spoil, said, tmp_path):
    whole = copy.deepcopy(WHOLE[name])
    spoil(whole)
    assert not Draft202012Validator(json.loads(schema_command(name))).is_valid(whole)
    with pytest.raises(PlogicError) as caught:
        read(name, tmp_path, json.dumps(whole, indent=1))
    (line,) = str(caught.value).splitlines()
    found = re.fullmatch(rf"{re.escape(str(tmp_path))}/{name}\.json:(\d+):(\d+): (.*)", line)
    assert found, line
    assert said in found[3]


@pytest.mark.parametrize("name", FORMATS)
def test_schema_and_shape_come_to_the_same_verdict(name):
    """100 documents, each with one change anywhere: refused by both or by neither."""
    validator, rng, shape = (
        Draft202012Validator(json.loads(schema_command(name))),
        np.random.default_rng(5),
        formats()[name].shape,
    )
    spoiled = [spoilt(WHOLE[name], rng) for _ in range(100)]
    verdicts = [validator.is_valid(one) for one in spoiled]
    assert [mistakes(one, shape) == [] for one in spoiled] == verdicts
    assert 0 < sum(verdicts) < 60


BEYOND = [
    ("gamma", changed("appearances", 1, "id", "a1"), "5:10: appearances.1.id: 'a1' is already the id of appearances.0"),
    ("gamma", changed("appearances", 0, "uv", [640, 3]), "appearances.0.uv: [640, 3] is outside the image of 640x480"),
    ("gamma", changed("appearances", 2, "depth_sigma", GONE), "depth and depth_sigma (m) must be given together"),
    ("camera", changed("T_world_camera", MIRROR), "T_world_camera: should be a rigid 4x4 matrix"),
    ("poses", changed("frames", 0, "T_world_camera", MIRROR), "frames.0.T_world_camera: should be a rigid 4x4 matrix"),
    ("moves", changed("moves", 0, "T_world_camera", POSE), "moves.0: should be an object with one of"),
    ("stereo", changed("T_right_left", POSE), "must be a rotation and a translation that is not zero"),
    ("truth", changed("objects", 0, "label", "bix"), "objects.0.label: 'bix' is no type of the KB (box)"),
    ("interpretation", changed("hypotheses", 0, "features", 0, "match", "a9"), "feature front: match: 'a9' is unknown"),
    ("interpretation", changed("facts", [{"fact": "rival", "args": ["h1", "h9"]}]), "rivals: 'h9' is unknown"),
]


@pytest.mark.parametrize(("name", "spoil", "said"), BEYOND, ids=[said for _, _, said in BEYOND])
def test_what_no_schema_says_is_refused_with_its_place(name, spoil, said, tmp_path):
    whole = copy.deepcopy(WHOLE[name])
    spoil(whole)
    with pytest.raises(PlogicError) as caught:
        read(name, tmp_path, as_written(whole))
    (line,) = str(caught.value).splitlines()
    assert re.match(rf"{re.escape(str(tmp_path))}/{name}\.json:\d+:\d+: ", line), line
    assert said in line


def as_written(whole):
    """A Γ with a row a line, as in the docs."""
    if "appearances" not in whole or "hypotheses" in whole:
        return json.dumps(whole, indent=1)
    rows = ",\n  ".join(map(json.dumps, whole["appearances"]))
    head = json.dumps({key: value for key, value in whole.items() if key != "appearances"})
    return f'{head[:-1]},\n\n "appearances": [\n  {rows}\n ]}}\n'
