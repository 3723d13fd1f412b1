"""One module prints, and escapes."""

from __future__ import annotations

import ast
import io
import sys
from pathlib import Path

import pytest

from plogic.face.shown.printed import Screen, emit, hand_over, say

ROOT = Path(__file__).parents[3]
PRINTS = ROOT / "plogic/face/shown/printed.py"
MODULES = [ROOT / "cli.py", *sorted((ROOT / "plogic/face").rglob("*.py"))]
FORBIDDEN = {"print", "echo", "secho", "pprint", "write", "writelines"}


def printing(tree):
    """The lines that print: ``print``, click's ``echo``, or a ``write`` of a standard stream or its buffer."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func)
        name = called.rsplit(".", 1)[-1]
        if name not in FORBIDDEN:
            continue
        if called in ("print", "pprint") or called.startswith(("click.", "pprint.", "sys.")):
            yield node.lineno


@pytest.mark.parametrize(
    "text", ["print(1)", "click.echo(1)", "sys.stdout.write('a')", "sys.stderr.buffer.write(b'a')"]
)
def test_what_prints_is_found(text):
    assert list(printing(ast.parse(text))) == [1]


def test_no_other_module_of_the_command_line_prints():
    assert PRINTS in MODULES
    others = [path for path in MODULES if path != PRINTS]
    assert len(others) > 50
    assert [f"{path}:{line}" for path in others for line in printing(ast.parse(path.read_text()))] == []


def stream(encoding):
    """A stream of that encoding, which keeps what is written."""
    return io.TextIOWrapper(io.BytesIO(), encoding=encoding)


HOSTILE = "q('\x1b[2J\u202eé\u9b6f─')"


@pytest.mark.parametrize(
    ("encoding", "bytes_"),
    [
        ("utf-8", b"q('\\x1b[2J\\u202e\xc3\xa9\xe9\xad\xaf\xe2\x94\x80')\n"),
        ("latin-1", b"q('\\x1b[2J\\u202e\xe9\\u9b6f-')\n"),
        ("ascii", b"q('\\x1b[2J\\u202e\\u00e9\\u9b6f-')\n"),
    ],
)
def test_what_people_read_is_escaped_and_in_their_encoding(encoding, bytes_, monkeypatch):
    monkeypatch.setattr(sys, "stdout", out := stream(encoding))
    monkeypatch.setattr(sys, "stderr", err := stream(encoding))
    emit(HOSTILE)
    say(HOSTILE)
    assert (out.buffer.getvalue(), err.buffer.getvalue()) == (bytes_, bytes_)


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_what_is_read_again_is_handed_over_as_it_is(encoding, monkeypatch):
    monkeypatch.setattr(sys, "stdout", out := stream(encoding))
    hand_over(HOSTILE)
    assert out.buffer.getvalue() == f"{HOSTILE}\n".encode()


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_what_others_print_is_escaped_too(encoding):
    screen = Screen(stream(encoding), 1)
    print(HOSTILE, file=screen)
    written = screen.buffer.getvalue()
    assert written.startswith(b"q('\\x1b[2J\\u202e")
    assert b"\x1b" not in written
    assert written.endswith(b"\n")


def test_on_a_terminal_our_own_emphasis_stays_and_no_other_sequence(monkeypatch):
    class Terminal(io.TextIOWrapper):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stdout", out := Terminal(io.BytesIO(), encoding="utf-8"))
    emit("\x1b[1;3mtitle\x1b[0m \x1b[31m\x1b[8m\x1b]0;x\x07")
    assert out.buffer.getvalue() == b"\x1b[1;3mtitle\x1b[0m \\x1b[31m\\x1b[8m\\x1b]0;x\\x07\n"
