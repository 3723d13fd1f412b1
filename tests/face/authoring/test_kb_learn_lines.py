"""An entry put into YAML that somebody wrote: it is there afterwards, and nothing else has changed.

Or the user is told what to write.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kb.files.yaml_text import load
from plogic.base.errors import InputError
from plogic.face.authoring.kb_types import with_entry

FILE = Path("object.yaml")
KEYS = ("object", "mesh", "cloud", "opaque")
VALUES = (
    "tower",
    "{file: a.ply, units: m}",
    "\n  file: a.ply  # a comment\n  units: m",
    "",
    "null",
    "[1,\n  2]",
    '"ä: # no comment"',
    "\n  - {a: 1}\n  - b",
)
ends = st.sampled_from(["", "\n", "\n\n", "  # end", "\n# the end\n", "\n...\n"])
texts = st.builds(
    lambda head, keys, values, between, end: (
        head + between.join(f"{key}: {value}" for key, value in zip(keys, values, strict=False)) + end
    ),
    st.sampled_from(["", "\ufeff", "# first\n", "---\n"]),
    st.permutations(KEYS).flatmap(lambda keys: st.integers(1, 4).map(lambda n: keys[:n])),
    st.lists(st.sampled_from(VALUES), min_size=4, max_size=4),
    st.sampled_from(["\n", "\n\n# between\n", "\r\n"]),
    ends,
)
names = st.dictionaries(
    st.sampled_from(["file", "units", "textured"]),
    st.text(st.characters(codec="utf-8", exclude_categories=["C"])),
    min_size=1,
)


@settings(max_examples=300, derandomize=True)
@given(texts, st.sampled_from(KEYS), names)
def test_the_entry_is_there_and_all_else_is_as_it_was(text, key, value):
    before = load("object.yaml", text.encode())
    if before.mistakes or not isinstance(before.data, dict):
        return
    if text.endswith("...\n") and key not in before.data:
        with pytest.raises(InputError, match=f"write this into it, and try again: {key}: "):
            with_entry(FILE, text.encode(), key, value)
        return
    changed = with_entry(FILE, text.encode(), key, value)
    after = load("object.yaml", changed)
    assert after.mistakes == ()
    assert after.data == before.data | {key: value}
    assert with_entry(FILE, changed, key, value) == changed
    assert all(comment in changed.decode() for comment in ("# first", "# between", "# the end") if comment in text)


def test_a_list_of_entries_is_one_line_with_the_comments_kept():
    text = "object: a  # mine\n# symmetries:\n#   - {axis: [0, 0, 1], fold: 2}\n"
    value = [{"axis": [0.0, 0.0, 1.0], "fold": 4, "at": [0.1, 0.0, 0.0]}, {"axis": [1.0, 0.0, 0.0], "continuous": True}]
    changed = with_entry(FILE, text.encode(), "symmetries", value)
    lines = "symmetries: [{axis: [0.0, 0.0, 1.0], fold: 4, at: [0.1, 0.0, 0.0]}, {axis: [1.0, 0.0, 0.0], continuous: true}]\n"
    assert changed.decode() == text + lines
    assert with_entry(FILE, changed, "symmetries", value) == changed


@pytest.mark.parametrize(
    "text",
    ["{object: a, opaque: true}\n", "mesh: &m {file: a}\nother: *m\n", "object: a\n...\n"],
    ids=["one flow", "an anchor", "an end"],
)
def test_what_cannot_be_changed_is_said_with_what_to_write(text):
    key = "mesh" if "mesh" in text else "cloud"
    with pytest.raises(InputError, match=f'write this into it, and try again: {key}: {{file: "b.npz"}}'):
        with_entry(FILE, text.encode(), key, {"file": "b.npz"})
