"""``gravity`` of kb.yaml: whether things rest on what is below."""

import pytest
from small_kb import KB, write_small

from kb.errors import KBErrors
from kb.read import read_kb
from kb.schema import json_schema
from kb.show import tree_document
from kb.write import kb_text, write_kb


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


@pytest.mark.parametrize("text", ["9.81", "down", "[]"])
def test_it_is_yes_or_no(text, tmp_path):
    with pytest.raises(KBErrors, match="gravity"):
        read_kb(write_small(tmp_path, kb=KB + f"gravity: {text}\n"))
