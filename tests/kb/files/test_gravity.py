"""``gravity`` of kb.yaml: whether things rest on what is below."""

import pytest
from small_kb import KB, write_small
from written_kb import kb_text, write_kb

from kb.clouds.cloud import UNKNOWN_SUPPORT
from kb.errors import KBErrors
from kb.files.read import read_kb
from kb.files.schema import json_schema
from kb.intake.new_type import new_kb_files
from kb.shown.show import tree_document


def test_left_out_it_is_not_said_to_hold(tmp_path):
    kb = read_kb(write_small(tmp_path))
    assert kb.gravity is False
    assert "gravity" not in kb_text(kb)
    assert tree_document(kb)["gravity"] is False


def test_said_to_hold_it_is_read_and_written(tmp_path):
    kb = read_kb(write_small(tmp_path / "a", kb=KB + "gravity: true\n"))
    assert kb.gravity is True
    write_kb(kb, tmp_path / "b")
    assert read_kb(tmp_path / "b").gravity is True
    assert tree_document(kb)["gravity"] is True
    assert json_schema("kb")["properties"]["gravity"]["default"] is False


def test_what_is_not_known_of_support_and_the_ground_may_be_said(tmp_path):
    kb = read_kb(write_small(tmp_path / "a", kb=KB + "gravity: {unknown_support: 0.25, ground: 75 cm}\n"))
    assert (kb.gravity, kb.unknown_support, kb.ground) == (True, 0.25, 0.75)
    write_kb(kb, tmp_path / "b")
    again = read_kb(tmp_path / "b")
    assert (again.gravity, again.unknown_support, again.ground) == (True, 0.25, 0.75)
    plain = read_kb(write_small(tmp_path / "c", kb=KB + "gravity: {}\n"))
    assert (plain.gravity, plain.unknown_support, plain.ground) == (True, UNKNOWN_SUPPORT, None)
    assert "gravity: true\n" in kb_text(plain)


def told(folder, gravity):
    return read_kb(write_small(folder, kb=KB + f"gravity: {gravity}\n"))


@pytest.mark.parametrize(
    ("text", "rests"),
    [
        ("false", None),
        ("true", 0.9),
        ("{ground: 0}", 0.9),
        ("{rests: 0.75}", 0.75),
        ("{unknown_support: 0.25}", 0.75),
        ("maybe", 0.9),
        ("{rests: 0.8, unknown_support: 0.2}", 0.8),
        ("{rests: 0}", 0.0),
    ],
)
def test_the_chance_that_things_rest_is_one_less_the_unknown_support(text, rests, tmp_path):
    kb = told(tmp_path, text)
    assert kb.rests == pytest.approx(rests)
    assert rests is None or kb.unknown_support == pytest.approx(1.0 - rests)
    assert kb.gravity is (text not in ("false", "maybe"))
    assert tree_document(kb)["rests"] == kb.rests


def test_maybe_is_read_and_written_and_is_what_new_ones_say(tmp_path):
    kb = told(tmp_path / "a", "maybe")
    assert tree_document(kb)["gravity"] == "maybe"
    write_kb(kb, tmp_path / "b")
    assert read_kb(tmp_path / "b").maybe
    assert b"\ngravity: maybe\n" in new_kb_files("mine")["kb.yaml"]


def test_what_contradicts_itself_is_a_mistake(tmp_path):
    with pytest.raises(
        KBErrors, match=r"kb\.yaml:10:10: gravity: unknown_support is 1 - rests: 0\.2 and 0\.9 contradict"
    ):
        told(tmp_path, "{rests: 0.9, unknown_support: 0.2}")


@pytest.mark.parametrize(
    "text",
    [
        "{rests: 1}",
        "{rests: -0.1}",
        "Maybe",
        "9.81",
        "down",
        "[]",
        "{unknown_support: 0}",
        "{unknown_support: 1.1}",
        "{floor: 0}",
        "{ground: 0 kg}",
    ],
)
def test_anything_else_is_a_mistake(text, tmp_path):
    with pytest.raises(KBErrors, match="gravity"):
        read_kb(write_small(tmp_path, kb=KB + f"gravity: {text}\n"))
