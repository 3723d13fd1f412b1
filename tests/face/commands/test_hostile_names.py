"""Names, ids, keys and files of strangers: none reaches the terminal raw, and no message is long because they are."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from console import plogic

from geometry.printable import LINES, LONGEST

ROOT = Path(__file__).parents[3]
HOSTILE = "x\x1b]0;pwn\x07\x1b[31m\r\b\u202e\u2066\u200f\u061c\u2028\x9b1m\x85\x7f"
LONG = "n" * 40_000
SPOILT = {
    "query": ["query", "atom.pl"],
    "worlds": ["worlds", "atom.pl"],
    "explain": ["explain", "atom.pl", "p(X)"],
    "undefined": ["query", "undefined.pl"],
    "unsafe": ["query", "unsafe.pl"],
    "idle": ["query", "idle.pl"],
    "file": ["query", "{name}.pl"],
    "goal": ["query", "atom.pl", "'{name}'(x)"],
    "given": ["query", "atom.pl", "p(X)", "--given", "'{name}'(x)"],
    "command": ["{name}"],
    "option": ["worlds", "--{name}"],
    "choice": ["schema", "{name}"],
    "no such kb": ["kb", "check", "{name}"],
    "no such type": ["kb", "show", "first", "{name}"],
    "id": ["perceive", "id.json", "--kb", "first"],
    "type": ["perceive", "type.json", "--kb", "first"],
    "key": ["perceive", "key.json", "--kb", "first"],
    "line": ["batch", "type.json", "--kb", "first", "--jobs", "1"],
    "kb's key": ["kb", "check", "mykb"],
}


def spoil(folder, name):
    """Files that hold a name wherever one may stand."""
    quoted = f"'{name}'"
    (folder / "atom.pl").write_text(f"0.5::p({quoted}).\nquery(p(_)).\n")
    (folder / "undefined.pl").write_text(f"a :- {quoted}(x).\nquery(a).\n")
    (folder / "unsafe.pl").write_text(f":- use_module({quoted}).\n")
    (folder / "idle.pl").write_text(f"0.5::{quoted}.\n:- {quoted}.\nquery({quoted}).\n")
    gamma = json.loads((ROOT / "examples/first_gamma.json").read_text())
    first, *others = gamma["appearances"]
    for key, changed in (("id", {"id": name}), ("type", {"type": name}), ("key", {name: 1})):
        (folder / f"{key}.json").write_text(json.dumps({**gamma, "appearances": [first | changed, *others]}))
    shutil.copytree(ROOT / "kb/first", folder / "mykb")
    with (folder / "mykb/kb.yaml").open("a") as kb:
        kb.write(f"{json.dumps(name)}: 1\n")


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    spoil(folder := tmp_path_factory.mktemp("hostile"), HOSTILE)
    return folder


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    spoil(folder := tmp_path_factory.mktemp("long"), LONG)
    return folder


def printed(folder, case, name):
    run = plogic(*(part.replace("{name}", name) for part in SPOILT[case]), cwd=folder)
    assert not [word for word in ("Traceback", "internal error") if word in run.stderr], run.stderr
    return run


@pytest.mark.parametrize("case", SPOILT)
def test_nothing_reaches_the_terminal_that_it_would_obey(case, hostile):
    run = printed(hostile, case, HOSTILE)
    both = run.stdout + run.stderr
    assert both.replace("\n", "").isprintable()
    assert "\\x1b]0;pwn" in both or "\\u001b]0;pwn" in both


@pytest.mark.parametrize("case", SPOILT)
def test_no_message_is_long(case, long):
    lines = printed(long, case, LONG).stderr.splitlines()
    assert len(lines) <= LINES
    assert max(map(len, lines), default=0) <= LONGEST
    assert sum(map(len, lines)) < 4 * LONGEST
