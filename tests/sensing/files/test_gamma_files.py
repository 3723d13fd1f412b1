"""gamma.json: what is written is what is read, and every mistake is reported at its place, all at once."""

from __future__ import annotations

import base64
import copy
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from in_process import standard_input

from geometry.camera import Camera
from sensing.appearance import MAX_APPEARANCES, Appearance, Gamma
from sensing.errors import GammaError, SensingError
from sensing.files.gamma_files import (
    appearance_to_dict,
    gamma_from_dict,
    gamma_from_text,
    gamma_to_dict,
    read_gamma,
    write_gamma,
)

CAMERA = Camera(640, 480, np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]]), np.zeros(0))
GOOD = {
    "format": "gamma/1",
    "camera": {"width": 640, "height": 480, "K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]], "dist": []},
    "appearances": [
        {
            "id": "a1",
            "type": "corner",
            "uv": [312.4, 201.9],
            "detector": "junction",
            "angle": 0.3,
            "scale": 4.0,
            "score": 0.93,
        },
        {"id": "a2", "type": "patch", "uv": [10, 20], "detector": "patch"},
    ],
}


def mistakes(change, vocabulary=None) -> list[str]:
    document = copy.deepcopy(GOOD)
    change(document)
    with pytest.raises(GammaError) as caught:
        gamma_from_dict(document, "gamma.json", vocabulary)
    assert str(caught.value) == "\n".join(caught.value.mistakes)
    return list(caught.value.mistakes)


def setting(key, value):
    return lambda document: document["appearances"][1].__setitem__(key, value)


def test_the_contract_s_example_is_read():
    gamma = gamma_from_dict(GOOD)
    assert gamma.appearances[0] == Appearance("a1", "corner", (312.4, 201.9), "junction", 0.3, 4.0, 0.93)
    assert gamma.uv.tolist() == [[312.4, 201.9], [10, 20]]
    assert (gamma.camera.width, gamma.camera.f) == (640, 600)


numbers = st.floats(-10, 10, allow_nan=False)
some = st.builds(
    Appearance, st.just(""), st.sampled_from(["patch", "l_junction", "ein Wort"]),
    st.tuples(st.floats(0, 639), st.floats(0, 479)), st.sampled_from(["junction", "patch"]), st.none() | numbers,
    st.none() | st.floats(0.01, 100), st.none() | st.floats(0, 1), st.lists(st.floats(0, 6.28), max_size=4).map(tuple),
    st.none() | st.binary(min_size=1, max_size=130),
)  # fmt: skip


@given(st.lists(some, max_size=6))
def test_what_is_written_is_what_is_read(found):
    named = tuple(replace(a, id=f"a{i}") for i, a in enumerate(found))
    again = gamma_from_text(json.dumps(gamma_to_dict(Gamma(CAMERA, named))))
    assert again.appearances == named
    assert np.array_equal(again.camera.K, CAMERA.K)


def test_depths_are_read_as_they_are_written(tmp_path):
    gamma = Gamma(CAMERA, (Appearance("a1", "corner", (12.0, 20.0), "junction", depth=1.25, depth_sigma=0.01),))
    write_gamma(gamma, tmp_path / "deep.json")
    assert read_gamma(tmp_path / "deep.json").appearances == gamma.appearances


def test_an_appearance_can_be_told_without_its_descriptor():
    a = Appearance("a1", "sift", (1.0, 2.0), "sift", 0.5, 3.0, 0.25, (0.1, 0.2), bytes(128))
    keys = ["id", "type", "uv", "detector", "angle", "scale", "score", "arms"]
    assert list(appearance_to_dict(a)) == [*keys, "descriptor"]
    assert list(appearance_to_dict(a, described=False)) == keys
    assert list(appearance_to_dict(Appearance("a1", "dot", (1.0, 2.0), "dots", scale=3.0))) == [
        "id",
        "type",
        "uv",
        "detector",
        "scale",
    ]


def test_a_file_round_trip_gives_the_same_bytes(tmp_path):
    gamma = gamma_from_dict(GOOD)
    write_gamma(gamma, tmp_path / "a.json")
    write_gamma(read_gamma(tmp_path / "a.json"), tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.json", "b.json"]


def test_a_dash_is_standard_input_and_output(capsys):
    write_gamma(gamma_from_dict(GOOD), "-")
    with standard_input(capsys.readouterr().out):
        assert len(read_gamma("-").appearances) == 2


def test_an_empty_gamma_and_a_gamma_of_one_are_read():
    for count in (0, 1):
        assert len(gamma_from_dict({**GOOD, "appearances": GOOD["appearances"][:count]}).appearances) == count


@pytest.mark.parametrize(
    ("key", "value", "place"),
    [
        ("uv", [1, 2, 3], "appearances.1.uv"),
        ("uv", [1], "appearances.1.uv"),
        ("uv", "here", "appearances.1.uv"),
        ("uv", [math.nan, 3], "appearances.1.uv.0"),
        ("uv", [3, math.inf], "appearances.1.uv.1"),
        ("uv", [3, True], "appearances.1.uv.1"),
        ("uv", ["3", 3], "appearances.1.uv.0"),
        ("uv", [640, 3], "appearances.1.uv"),
        ("uv", [3, -1], "appearances.1.uv"),
        ("id", "a1", "appearances.1.id"),
        ("id", "", "appearances.1.id"),
        ("id", 7, "appearances.1.id"),
        ("type", None, "appearances.1.type"),
        ("detector", ["x"], "appearances.1.detector"),
        ("angle", math.nan, "appearances.1.angle"),
        ("scale", 0, "appearances.1.scale"),
        ("score", "high", "appearances.1.score"),
        ("arms", [0.1, math.nan], "appearances.1.arms.1"),
        ("scael", 3, "appearances.1.scael"),
        ("descriptor", 3, "appearances.1.descriptor"),
        ("descriptor", "not base64!", "appearances.1.descriptor"),
        ("descriptor", "QUJ", "appearances.1.descriptor"),
        ("descriptor", "ä" * 4, "appearances.1.descriptor"),
        ("descriptor", "", "appearances.1.descriptor"),
        ("descriptor", "QUJD" * 400, "appearances.1.descriptor"),
    ],
)
def test_each_mistake_is_one_line_that_states_its_place(key, value, place):
    (line,) = mistakes(setting(key, value))
    assert line.startswith(f"gamma.json: {place}: ")
    assert "\n" not in line


@pytest.mark.parametrize(
    ("a_type", "size"),
    [
        ("sift", 128),
        ("sift", 138),
        ("sift_w0007", 128),
        ("sift_w0007", 138),
        ("sift", 5),
        ("sift_w0007", 5),
        ("orb", 32),
        ("orb_w0000", 32),
    ],
)
def test_a_keypoint_s_descriptor_has_its_detector_s_length(a_type, size):
    document = copy.deepcopy(GOOD)
    row = document["appearances"][1]
    row |= {"type": a_type, "descriptor": base64.b64encode(bytes(range(size))).decode()}
    assert gamma_from_dict(document).appearances[1].descriptor == bytes(range(size))
    assert gamma_to_dict(gamma_from_dict(document))["appearances"][1] == row
    row["descriptor"] = base64.b64encode(bytes(7)).decode()
    wanted = "32" if size == 32 else "128 or 138 or 5"
    assert mistakes(lambda d: d.update(document)) == [
        f"gamma.json: appearances.1.descriptor: has 7 bytes, and one of {a_type!r} has {wanted}"
    ]


def test_a_duplicate_id_names_both_places():
    assert mistakes(setting("id", "a1")) == ["gamma.json: appearances.1.id: 'a1' is already the id of appearances.0"]


def test_every_mistake_is_reported_at_once():
    def change(document):
        document["format"] = "gamma/2"
        document["appearances"][0]["uv"] = [math.nan, 1]
        document["appearances"][1]["id"] = "a1"
        del document["appearances"][1]["type"]
        document["camera"]["width"] = -3

    text = "\n".join(mistakes(change))
    for place in ("format", "appearances.0.uv.0", "appearances.1.id", "appearances.1.type", "camera"):
        assert f"gamma.json: {place}" in text


def test_a_type_that_the_kb_has_not_is_a_mistake():
    (line,) = mistakes(lambda _: None, {"patch"})
    assert line == "gamma.json: appearances.0.type: 'corner' is no appearance type of the KB (patch)"


def test_missing_parts_and_other_documents():
    for change, place in ((lambda d: d.pop("camera"), "camera"), (lambda d: d.pop("appearances"), "appearances")):
        assert [line.startswith(f"gamma.json: {place}: ") for line in mistakes(change)] == [True]
    for other in ([], 3, "x", None):
        with pytest.raises(GammaError):
            gamma_from_dict(other)


def test_too_many_appearances_are_refused():
    rows = [{"id": f"a{i}", "type": "p", "uv": [1, 1], "detector": "d"} for i in range(MAX_APPEARANCES + 1)]
    (line,) = mistakes(lambda d: d.__setitem__("appearances", rows))
    assert str(MAX_APPEARANCES) in line


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, '{"a": 1, "a": 2}', "\x00"])
def test_text_that_is_no_json_is_one_clear_line(text):
    with pytest.raises(GammaError) as caught:
        gamma_from_text(text, "g.json")
    assert len(caught.value.mistakes) == 1
    assert str(caught.value).startswith("g.json")


def test_the_keys_that_are_given_twice_are_named_once_each():
    text = '{"a": 1, "c": [{"y": 1, "x": 2, "y": 3, "x": 4, "y": 5}], "b": 2, "a": 3}'
    with pytest.raises(GammaError) as caught:
        gamma_from_text(text)
    assert [line.split("'")[1] for line in caught.value.mistakes] == ["x", "y", "a"]


def test_a_file_that_is_not_there_or_not_text(tmp_path):
    with pytest.raises(GammaError, match="cannot be read"):
        read_gamma(tmp_path / "none.json")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(GammaError, match="no UTF-8"):
        read_gamma(tmp_path / "bytes.json")


def test_nothing_is_left_where_nothing_could_be_written(tmp_path):
    with pytest.raises(SensingError, match="cannot be written"):
        write_gamma(gamma_from_dict(GOOD), tmp_path / "no" / "gamma.json")
    (tmp_path / "folder").mkdir()
    with pytest.raises(SensingError, match="cannot be written"):
        write_gamma(gamma_from_dict(GOOD), tmp_path / "folder")
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]


@pytest.mark.parametrize("value", [1e18, -1e18, 1e308, -1e308, 10**18, 10**400, 1e6])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_place_that_far_out_is_outside_as_any_other(value, axis):
    uv = [1.0, 1.0]
    uv[axis] = value
    lines = mistakes(lambda d: d["appearances"][0].__setitem__("uv", uv))
    assert any("appearances.0.uv" in line for line in lines)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", [1e18, 1e308, -1e308, 10**30])
@pytest.mark.parametrize(
    ("key", "made"),
    [
        ("dist", lambda v: [0.0, 0.0, 0.0, 0.0, v]),
        ("dist", lambda v: [v, 0.0, 0.0, 0.0]),
        ("K", lambda v: [[600, v, 320], [0, 600, 240], [0, 0, 1]]),
        ("K", lambda v: [[600, 0, 320], [0, 600, v], [0, 0, 1]]),
        ("K", lambda v: [[1 / abs(v), 0, 320], [0, 600, 240], [0, 0, 1]]),
        ("T_world_camera", lambda v: [[1, 0, 0, v], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    ],
)
def test_a_number_that_no_camera_has_is_a_mistake(value, key, made):
    (line,) = mistakes(lambda d: d["camera"].__setitem__(key, made(value)))
    assert line.startswith(f"gamma.json: camera.{key}: ")


def test_of_a_hundred_thousand_mistakes_a_hundred_are_told():
    rows = [{"id": "a", "type": "zork", "uv": [-5, 3], "detector": 1} for _ in range(MAX_APPEARANCES)]
    with pytest.raises(GammaError) as caught:
        gamma_from_dict({**GOOD, "appearances": rows}, vocabulary=["p"])
    lines = str(caught.value).splitlines()
    assert (len(lines), lines[-1]) == (101, f"and {len(caught.value.mistakes) - 100} more")
    camera = {**GOOD["camera"], **{f"k{i}": 0 for i in range(1000)}}
    with pytest.raises(GammaError) as caught:
        gamma_from_dict({**GOOD, "camera": camera})
    assert len(caught.value.mistakes) == 1000
    assert str(caught.value).endswith("\nand 900 more")
