"""``detector.sigma_angle`` of kb.yaml: how far a datum's angle may be off."""

import numpy as np
import pytest
from small_kb import KB, write_small
from written_kb import kb_text, write_kb

from kb.errors import KBErrors
from kb.files.read import read_kb
from kb.files.schema import json_schema
from kb.shown.show import tree_document


def with_angle(text):
    """The small KB with this value, at 9:16."""
    assert KB.count("  match_tolerance: 5\n") == 1
    return KB.replace("  match_tolerance: 5\n", f"  match_tolerance: 5\n  sigma_angle: {text}\n")


@pytest.mark.parametrize(
    ("text", "radians"),
    [("5 deg", np.radians(5.0)), ("0.1", 0.1), ("0.2 rad", 0.2), ("180 deg", np.pi), ("0.5 turn", np.pi)],
)
def test_it_is_read_in_radians(text, radians, tmp_path):
    assert read_kb(write_small(tmp_path, kb=with_angle(text))).rates.sigma_angle == pytest.approx(radians, abs=1e-12)


def test_left_out_there_is_none(tmp_path):
    kb = read_kb(write_small(tmp_path))
    assert kb.rates.sigma_angle is None
    assert "sigma_angle" not in kb_text(kb)
    assert tree_document(kb)["detector"]["sigma_angle"] is None


@pytest.mark.parametrize("text", ["0.1", "0.123456789012345", "5 deg", "180 deg", "12.3 deg"])
def test_what_is_written_is_read_back(text, tmp_path):
    """Radians of 15 digits, as all numbers.

    What is a plain number comes back exactly, and the second writing has the same bytes.
    """
    kb = read_kb(write_small(tmp_path / "a", kb=with_angle(text)))
    write_kb(kb, tmp_path / "b")
    again = read_kb(tmp_path / "b")
    assert again.rates.sigma_angle == pytest.approx(kb.rates.sigma_angle, abs=1e-14)
    assert again.rates == kb.rates or "deg" in text
    assert (tmp_path / "b/kb.yaml").read_text() == kb_text(kb) == kb_text(again)


MISTAKES = {
    "none": ("0 deg", "9:16: detector.sigma_angle: must be above 0 and at most 180 deg, not 0 deg"),
    "negative": ("-5 deg", "9:16: detector.sigma_angle: must be above 0 and at most 180 deg, not -5 deg"),
    "more than half a turn": (
        "200 deg",
        "9:16: detector.sigma_angle: must be above 0 and at most 180 deg, not 200 deg",
    ),
    "no angle": ("x", "9:16: detector.sigma_angle: must be an angle in radians, such as 1.2 or '70 deg', not 'x'"),
    "a length": ("5 cm", "9:16: detector.sigma_angle: must be an angle in radians"),
    "no number": (".nan", "9:16: detector.sigma_angle: must be finite, not .nan"),
    "a list": ("[1, 2]", "9:16: detector.sigma_angle: must be an angle in radians"),
    "a truth value": ("true", "9:16: detector.sigma_angle: must be an angle in radians"),
}


@pytest.mark.parametrize("kind", MISTAKES)
def test_a_mistake_is_said_with_its_place(kind, tmp_path):
    text, wanted = MISTAKES[kind]
    with pytest.raises(KBErrors) as caught:
        read_kb(write_small(tmp_path, kb=with_angle(text)))
    assert any(line.startswith(f"kb.yaml:{wanted}") for line in str(caught.value).splitlines())


def test_a_change_of_it_changes_the_kb(tmp_path):
    folders = [
        write_small(tmp_path / str(n), kb=text) for n, text in enumerate([KB, with_angle("5 deg"), with_angle("6 deg")])
    ]
    assert len({read_kb(folder).digest for folder in folders}) == 3


def test_the_schema_tells_of_it():
    row = json_schema("kb")["$defs"]["DetectorModel"]["properties"]["sigma_angle"]
    assert row["default"] is None
    assert "angle" in row["description"]
