"""``gravity`` of kb.yaml: whether things rest on what is below."""

import pytest
from small_kb import KB, write_small
from written_kb import kb_text, write_kb

from kb.clouds.cloud import UNKNOWN_SUPPORT
from kb.errors import KBErrors
from kb.files.read import read_kb
from kb.files.schema import json_schema
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


@pytest.mark.parametrize(
    "text", ["9.81", "down", "[]", "{unknown_support: 0}", "{unknown_support: 1.1}", "{floor: 0}", "{ground: 0 kg}"]
)
def test_anything_else_is_a_mistake(text, tmp_path):
    with pytest.raises(KBErrors, match="gravity"):
        read_kb(write_small(tmp_path, kb=KB + f"gravity: {text}\n"))
