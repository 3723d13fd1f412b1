import time

import numpy as np
import pytest
from small_kb import KB, MESH, OBJECT, write_small

from kb.errors import KBError, KBErrors
from kb.files.folder import shipped
from kb.files.read import read_kb
from kb.files.yaml_text import load

OBJECT_FILE = "objects/tent/object.yaml"


def mistakes(folder):
    with pytest.raises(KBErrors) as caught:
        read_kb(folder)
    return str(caught.value).splitlines()


def spoilt(text, old, new):
    assert text.count(old) == 1, old
    return text.replace(old, new)


def test_a_good_kb_is_read(tmp_path):
    kb = read_kb(write_small(tmp_path, rules="near(X) :- present(X).\n"))
    (tent,) = kb.types
    assert (kb.name, kb.f_ref, kb.appearance_types, kb.rules) == (
        "small",
        600.0,
        ("apex", "corner"),
        "near(X) :- present(X).\n",
    )
    assert kb.rates.hit == {"apex": 0.9, "corner": 0.8}
    assert kb.rates.clutter == {"apex": 0.666667, "corner": 3.0}  # one feature of three is an apex: λ·P(dv) = 2 · 1/3
    assert (kb.rates.prior, kb.rates.sigma, kb.rates.match_tolerance) == ({"tent": 0.25}, 1.5, 5.0)
    assert [feature.name for feature in tent.features] == ["roof/apex", "roof/pair"]
    assert [feature.name for feature in tent.all_features] == ["roof/apex", "roof/pair", "roof/pair/left"]
    assert tent.opaque
    assert tent.symmetries.shape == (3, 4, 4)
    np.testing.assert_allclose(tent.symmetries[0], np.eye(4))


def test_places_and_arms_are_turned_into_the_objects_frame_and_units_into_metres(tmp_path):
    kb = read_kb(write_small(tmp_path))
    apex = kb.type("tent").features[0]
    np.testing.assert_allclose(apex.at, [0, 0.1, 1.0], atol=1e-12)
    np.testing.assert_allclose(apex.arms, [[0, 1, 0], [-1, 0, 0]], atol=1e-12)
    lobe = apex.appearances[0].lobe
    np.testing.assert_allclose(lobe.axis, [0, 0, 1])
    assert (lobe.half_angle, lobe.r_min, lobe.r_max) == pytest.approx((np.radians(100), 0.2, 30.0))
    assert kb.type("tent").surface.vertices[:, 2].max() == pytest.approx(1.0)


OBJECT_MISTAKES = {
    "unknown key": ("object: tent", "object: tent\ncolour: red", "2:1: colour: unknown key"),
    "missing key": ("        type: apex\n", "", "9:9: parts.0.features.0.type: missing"),
    "mesh without units": (", units: cm", "", "2:7: mesh.units: missing; no mesh format carries its unit"),
    "unit unknown": ("units: cm", "units: ell", "2:31: mesh.units: must be one of m,"),
    "mesh in short": (
        "{file: mesh.obj, units: cm}",
        "mesh.obj",
        "2:7: mesh: must be a mapping of keys to values, as in 'mesh: {file: mesh.obj, units: m}'",
    ),
    "mesh missing": ("file: mesh.obj", "file: other.obj", "2:14: mesh.file: the mesh 'other.obj' is missing"),
    "mesh outside": (
        "file: mesh.obj",
        "file: ../../../x.obj",
        "2:14: mesh.file: the mesh '../../../x.obj' leads out of",
    ),
    "mesh outside, absolute": (
        "file: mesh.obj",
        "file: /etc/passwd",
        "2:14: mesh.file: the mesh '/etc/passwd' leads out of",
    ),
    "fold": ("fold: 3", "fold: 1", "3:38: symmetries.0.fold: must be a whole number from 2 to 360, not 1"),
    "symmetry of no axis": (
        "axis: [0, 0, 1], fold",
        "axis: [0, 0, 0], fold",
        "3:21: symmetries.0.axis: must be a direction",
    ),
    "symmetries that do not close": (
        "fold: 3}",
        "fold: 3}, {axis: [1, 0, 2], fold: 7}",
        "3:13: symmetries: these make more than 400 motions",
    ),
    "part at two numbers": ("at: [0, 0, 0.5 m]", "at: [0, 0.5 m]", "6:9: parts.0.at: must be a list of 3"),
    "wrong unit": ("0.5 m]", "0.5 deg]", "6:9: parts.0.at: must be a length in metres"),
    "NaN": ("0.5 m]", ".nan]", "6:16: parts.0.at.2: must be finite, not .nan"),
    "inf": ("0.5 m]", "-.inf]", "6:16: parts.0.at.2: must be finite, not -.inf"),
    "NaN in a text": ("0.5 m]", "nan m]", "6:9: parts.0.at: must be a length in metres"),
    "too large": ("0.5 m]", "1e999]", "6:9: parts.0.at: must be finite"),
    "two rotations": (
        "{euler_xyz:",
        "{quat_xyzw: [0, 0, 0, 1], euler_xyz:",
        "7:15: parts.0.rotation: must be either quat_xyzw or",
    ),
    "quaternion's length": (
        "{euler_xyz: [0, 0, 90 deg]}",
        "{quat_xyzw: [0, 0, 0, 2]}",
        "7:27: parts.0.rotation.quat_xyzw: must be of",
    ),
    "name with a slash": (
        "feature: apex",
        "feature: a/b",
        "9:18: parts.0.features.0.feature: must be a name without '/'",
    ),
    "name given twice": (
        "feature: pair",
        "feature: apex",
        "15:9: parts.0.features.1: 'apex' is the name of another feature",
    ),
    "arm of no direction": (
        "[2, 0, 0]",
        "[0, 0, 0]",
        "12:16: parts.0.features.0.arms.0: must be a direction, not the zero",
    ),
    "unknown appearance type": (
        "{type: apex,",
        "{type: spire,",
        "14:20: parts.0.features.0.appearances.0.type: unknown appearance type 'spire'",
    ),
    "zero axis": (
        "axis: [0, 0, 2]",
        "axis: [0, 0, 0]",
        "14:39: parts.0.features.0.appearances.0.lobe.axis: must be a direction, not the zero vector",
    ),
    "half-angle too wide": (
        "half_angle: 100 deg",
        "half_angle: 200 deg",
        "14:62: parts.0.features.0.appearances.0.lobe.half_angle: must be above 0 and at most 180 deg, not 200 deg",
    ),
    "half-angle zero": ("100 deg", "0", "14:62: parts.0.features.0.appearances.0.lobe.half_angle: must be above 0"),
    "range's order": (
        "[0.2 m, 30 m]",
        "[30 m, 0.2 m]",
        "14:78: parts.0.features.0.appearances.0.lobe.range: must be [nearest, farthest]",
    ),
    "negative range": (
        "[0.2 m, 30 m]",
        "[-1, 1]",
        "14:78: parts.0.features.0.appearances.0.lobe.range: must be [nearest,",
    ),
    "no lobe": (
        "\n                lobe: {axis: [1, 0, 0], half_angle: 60 deg, range: [0.2, 3]}",
        "",
        "23:17: parts.0.features.1.features.0.appearances.0: missing key 'lobe'",
    ),
    "mixed list, two keys (A1)": (
        "    features: []",
        "    features: [{feature: f, type: corner, at: [0, 0, 0]}]\n    parts: [{part: p}]",
        "25:5: parts.1: A1: the parts of 'body' must be all of one kind",
    ),
    "mixed list, one key (A1)": (
        "- part: body\n    features: []",
        "- {feature: f}",
        "1:1: A1: the parts of 'tent' must be all of one kind",
    ),
    "an alias that is its own part (A2)": (
        "- part: body\n    features: []",
        "- &me\n    part: body\n    parts: [*me]",
        "A2: an alias makes this a part of itself",
    ),
    "a key given twice": ("object: tent", "object: tent\nobject: tent", "2:1: object: this key was given before"),
    "tag": ("object: tent", "object: !!python/name:os.system tent", "1:9: object: the tag "),
    "no mapping": (
        "lobe: {axis: [1, 0, 0], half_angle: 60 deg, range: [0.2, 3]}",
        "lobe: wide",
        "24:23: parts.0.features.1.features.0",
    ),
    "no list": ("    features: []", "    features: {}", "26:15: parts.1.features: must be a list"),
    "opaque must be a truth value": (
        "object: tent",
        "object: tent\nopaque: maybe",
        "2:9: opaque: must be true or false, not 'maybe'",
    ),
    "no YAML": ("symmetries: [{axis", "symmetries: [[{axis", "no YAML: "),
}


@pytest.mark.parametrize("kind", OBJECT_MISTAKES)
def test_a_mistake_of_an_object_is_said_with_its_place(kind, tmp_path):
    old, new, wanted = OBJECT_MISTAKES[kind]
    found = mistakes(write_small(tmp_path, object=spoilt(OBJECT, old, new)))
    assert any(wanted in line and line.startswith(f"{OBJECT_FILE}:") for line in found), found
    if wanted[0].isdigit():
        assert any(line.startswith(f"{OBJECT_FILE}:{wanted}") for line in found), found


KB_MISTAKES = {
    "unknown key": ("f_ref: 600", "fref: 600", "3:1: fref: unknown key"),
    "no vocabulary": ("appearance_types: [apex, corner]\n", "", "1:1: appearance_types: missing"),
    "a type listed twice": (
        "[apex, corner]",
        "[apex, corner, apex]",
        "2:34: appearance_types.2: 'apex' was listed before",
    ),
    "focal length": ("f_ref: 600", "f_ref: 0", "3:8: f_ref: must be from 1e-6 to 1e9, not 0"),
    "focal length NaN": ("f_ref: 600", "f_ref: .NaN", "3:8: f_ref: must be finite, not .NaN"),
    "unknown feature type": (
        "hit: {apex",
        "hit: {spire",
        "5:9: detector.hit.spire: unknown feature type 'spire'; known: apex, corner",
    ),
    "hit rate": (
        "apex: 0.9",
        "apex: 1.2",
        "5:15: detector.hit.apex: must be above 0 and below 1, by 1e-08 at least, not 1.2",
    ),
    "clutter of an unknown type": (
        "{corner: 3}",
        "{spire: 3}",
        "6:13: detector.clutter.spire: unknown appearance type 'spire'",
    ),
    "prior of an unknown type": ("tent: 0.25", "hut: 0.25", "9:10: priors.hut: unknown object type 'hut'; known: tent"),
    "prior": ("tent: 0.25", "tent: 0", "9:16: priors.tent: must be above 0 and below 1, by 1e-08 at least, not 0"),
    "rare prior": ("tent: 0.25", "tent: 1.0e-9", "9:16: priors.tent: must be above 0 and below 1, by 1e-08 at least"),
    "no name": ("name: small\n", "", "1:1: name: missing"),
}


@pytest.mark.parametrize("kind", KB_MISTAKES)
def test_a_mistake_of_kb_yaml_is_said_with_its_place(kind, tmp_path):
    old, new, wanted = KB_MISTAKES[kind]
    found = mistakes(write_small(tmp_path, kb=spoilt(KB, old, new)))
    assert any(line.startswith(f"kb.yaml:{wanted}") for line in found), found


def test_all_mistakes_of_all_files_are_said_in_order(tmp_path):
    text = spoilt(spoilt(OBJECT, "units: cm", "units: ell"), "half_angle: 100 deg", "half_angle: -1 deg")
    text = spoilt(spoilt(text, "feature: pair", "feature: apex"), "{type: apex,", "{type: spire,")
    found = mistakes(write_small(tmp_path, kb=spoilt(KB, "600", "-1"), object=text))
    assert [line.split(": ")[0] for line in found] == [
        "kb.yaml:3:8",
        f"{OBJECT_FILE}:2:31",
        f"{OBJECT_FILE}:14:20",
        f"{OBJECT_FILE}:14:63",
        f"{OBJECT_FILE}:15:9",
    ]


def test_a_mesh_that_is_not_closed_is_usable_and_no_solid(tmp_path):
    (tent,) = read_kb(write_small(tmp_path, mesh=spoilt(MESH, "f 3 1 4\n", ""))).types
    assert not tent.surface.closed
    assert tent.surface.faults == "3 edges in one facet only"
    assert tent.surface.solid is None
    assert "1 hole is larger" in tent.surface.mended.refused


def test_the_textured_mesh_is_what_is_rendered_and_part_of_the_digest(tmp_path):
    plain = read_kb(write_small(tmp_path))
    (tmp_path / "objects/tent/painted.obj").write_text("mtllib painted.mtl\n" + MESH)
    (tmp_path / "objects/tent/painted.mtl").write_text("newmtl paint\nmap_Kd texture.png\n")
    text = spoilt(OBJECT, "units: cm}", "units: cm, textured: painted.obj}")
    painted = read_kb(write_small(tmp_path, object=text))
    assert (plain.types[0].mesh_file.name, painted.types[0].mesh_file.name) == ("mesh.obj", "painted.obj")
    assert painted.types[0].mesh_scale == 0.01
    (tmp_path / "objects/tent/texture.png").write_bytes(b"other paint")
    assert len({plain.digest, painted.digest, read_kb(tmp_path).digest}) == 3


def test_a_textured_mesh_that_is_missing(tmp_path):
    (line,) = mistakes(write_small(tmp_path, object=spoilt(OBJECT, "units: cm}", "units: cm, textured: gone.obj}")))
    assert line == f"{OBJECT_FILE}:2:45: mesh.textured: the mesh 'gone.obj' is missing"


def test_a_file_that_is_no_mesh(tmp_path):
    (line,) = mistakes(write_small(tmp_path, mesh=b"\x00\xff not a mesh"))
    assert line.startswith(f"{OBJECT_FILE}:2:14: mesh.file: ")


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    folder = write_small(tmp_path / "kb", mesh=None)
    (tmp_path / "mesh.obj").write_text(MESH)
    (folder / "objects/tent/mesh.obj").symlink_to(tmp_path / "mesh.obj")
    (line,) = mistakes(folder)
    assert "leads out of the knowledge base's folder" in line


def test_no_folder_and_no_kb_yaml(tmp_path):
    (line,) = mistakes(tmp_path / "nowhere")
    assert line == f"{tmp_path / 'nowhere'}: there is no such folder; a knowledge base is a folder with a kb.yaml in it"
    (line,) = mistakes(tmp_path)
    assert line.startswith(f"{tmp_path}: the folder holds no kb.yaml")


def test_an_object_folder_without_object_yaml(tmp_path):
    folder = write_small(tmp_path)
    (folder / "objects/hut").mkdir()
    assert mistakes(folder) == ["objects/hut/object.yaml: the file is missing"]


def test_an_object_of_a_name_that_another_has(tmp_path):
    folder = write_small(tmp_path)
    (folder / "objects/tent2").mkdir()
    (folder / "objects/tent2/object.yaml").write_text("object: tent\n")
    assert mistakes(folder) == [
        "objects/tent2/object.yaml:1:9: object: 'tent' is also the object of objects/tent/object.yaml"
    ]


@pytest.mark.parametrize("text", ["", "# nothing\n"])
def test_an_empty_file(text, tmp_path):
    assert mistakes(write_small(tmp_path, kb=text, object=None)) == [
        "kb.yaml:1:1: the file is empty",
        "objects/tent/object.yaml: the file is missing",
    ]


@pytest.mark.parametrize("name", ["[]", "{a: 1}", "3", "true", "null", "2020-01-01: x"])
def test_an_object_whose_name_is_no_text(name, tmp_path):
    found = mistakes(write_small(tmp_path, object=spoilt(OBJECT, "object: tent", f"object: {name}")))
    assert any(line.startswith(f"{OBJECT_FILE}:1:") for line in found)


@pytest.mark.parametrize("pure", [True, False])
def test_plain_values_mean_the_same_with_and_without_libyaml(pure, monkeypatch):
    monkeypatch.setattr("kb.files.yaml_text._may_be_deep", lambda _: pure)
    text = b"[yes, 010, 1e3, .5, 12:30:00, 2020-01-01, 0x10, 1_000, ~, '1', \"a\", -3, null, True, <<, no]"
    expected = [
        "yes",
        10,
        1000.0,
        0.5,
        "12:30:00",
        "2020-01-01",
        "0x10",
        "1_000",
        None,
        "1",
        "a",
        -3,
        None,
        True,
        "<<",
        "no",
    ]
    document = load("x.yaml", text)
    assert document.mistakes == ()
    assert [(type(value), value) for value in document.data] == [(type(value), value) for value in expected]


@pytest.mark.parametrize("text", ["[1, 2]", "just words"])
def test_a_document_of_another_shape(text, tmp_path):
    assert mistakes(write_small(tmp_path, object=text))[0] == f"{OBJECT_FILE}:1:1: must be a mapping of keys to values"


def test_bytes_that_are_no_text(tmp_path):
    found = mistakes(write_small(tmp_path, kb=b"name: a\nf_ref: \xff\n", rules=b"a.\n\xff"))
    assert "kb.yaml:2:1: must be UTF-8: invalid start byte" in found
    assert "rules.pl:2:1: must be UTF-8: invalid start byte" in found


def test_rules_of_more_than_the_limit(tmp_path):
    assert mistakes(write_small(tmp_path, rules="% \n" * 400_000)) == [
        "rules.pl: the file has 1200000 bytes, more than the 200000 that are read"
    ]


def test_a_bomb_of_aliases_ends_in_a_mistake(tmp_path):
    bomb = ["a: &a [x, x, x, x, x, x, x, x, x]"]
    bomb += [f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]" for a, b in zip("abcdefgh", "bcdefghi", strict=True)]
    start = time.perf_counter()
    found = mistakes(write_small(tmp_path, kb="\n".join(bomb)))
    assert any("more than 500000 values, those of aliases counted each time" in line for line in found)
    assert time.perf_counter() - start < 20


@pytest.mark.parametrize("text", ["[" * 20_000, "- " * 10_000, "a: " + "[" * 70 + "]" * 70, "{a: " * 10_000])
def test_deep_nesting_ends_in_a_mistake(text, tmp_path):
    found = mistakes(write_small(tmp_path, kb=text))
    assert any(line.startswith("kb.yaml:") for line in found)


def test_the_digest_is_of_contents(tmp_path):
    first = read_kb(write_small(tmp_path / "a")).digest
    assert first == read_kb(write_small(tmp_path / "b")).digest
    assert first != read_kb(write_small(tmp_path / "c", object=OBJECT + "# a remark\n")).digest
    assert first != read_kb(write_small(tmp_path / "d", rules="a.\n")).digest
    assert first != read_kb(write_small(tmp_path / "e", mesh=MESH + "# a remark\n")).digest


def test_a_kb_without_types_is_read(tmp_path):
    (tmp_path / "kb.yaml").write_text("name: bare\nappearance_types: []\n")
    assert read_kb(tmp_path).types == ()


def test_the_shipped_kb_is_named():
    assert (shipped("towers") / "kb.yaml").is_file()
    with pytest.raises(
        KBError, match="no knowledge base 'castles' comes with plogic; these do: first, lookalikes, paper, towers"
    ):
        shipped("castles")


def test_the_towers_are_read():
    kb = read_kb(shipped("towers"))
    assert {kind.name: len(kind.features) for kind in kb.types} == {"t1": 58, "t2": 54}
    assert [len(kind.symmetries) for kind in kb.types] == [1, 4]
