"""Streams that are full, closed or narrow: no traceback whatever becomes of them, and lost results are told."""

from __future__ import annotations

import json
import os
import pty
import shlex
import subprocess
from pathlib import Path

import pytest
from console import BIN, SECONDS, good

EXAMPLES = Path(__file__).parents[3] / "examples"
COMMANDS = {
    "help": ["--help"],
    "completion": ["completion", "bash"],
    "schema": ["kb", "schema", "kb"],
    "query": ["query", "names.pl"],
    "json": ["query", "names.pl", "--json"],
    "program": ["program", "--kb", "first"],
    "batch": ["batch", EXAMPLES / "first_gamma.json", "--kb", "first", "--jobs", "1"],
    "shell": ["shell", "names.pl"],
}
LOST = "plogic: standard output: cannot be written: {}"
NAMES = "0.5::p('é☃').\n0.4::p('日本').\nquery(p(_)).\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a program of names that are not ASCII."""
    made = tmp_path_factory.mktemp("streams")
    (made / "names.pl").write_text(NAMES)
    return made


def run(folder, name, redirected="", **env):
    """The finished process of a command, as a shell starts it whose streams are redirected."""
    line = shlex.join([str(BIN / "plogic"), *map(str, COMMANDS[name])])
    done = subprocess.run(
        ["bash", "-c", f"{line} {redirected}"],
        cwd=folder,
        input=b"ask p(X)\n" * (name == "shell"),
        capture_output=True,
        timeout=SECONDS,
        check=False,
        env={key: value for key, value in os.environ.items() if key != "PLOGIC_TRACEBACK"} | env,
    )
    said = done.stderr.decode()
    assert not [word for word in ("Traceback", "internal error", "Exception ignored") if word in said], said
    return done


@pytest.fixture(scope="module")
def usual(folder):
    """What each command prints where nothing is wrong."""
    done = {name: run(folder, name) for name in COMMANDS}
    assert {name: one.returncode for name, one in done.items()} == dict.fromkeys(COMMANDS, 0)
    return {name: one.stdout for name, one in done.items()}


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize(
    ("redirected", "why"), [(">/dev/full", "No space left on device"), (">&-", "Bad file descriptor")], ids=str
)
def test_a_result_that_cannot_be_written_is_one_line_and_status_1(folder, name, redirected, why):
    done = run(folder, name, redirected)
    lines = done.stderr.decode().splitlines()
    assert (done.returncode, lines[-1]) == (1, LOST.format(why))
    assert lines[:-1] in ([], ["stopped"]), "batch tells that it stopped"


@pytest.mark.parametrize("name", COMMANDS)
def test_a_reader_that_is_gone_ends_it_silently(folder, name):
    done = run(folder, name, "| true; exit ${PIPESTATUS[0]}")
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("redirected", ["2>/dev/full", "2>&-"])
def test_a_result_does_not_depend_on_stderr(folder, name, redirected, usual):
    done = run(folder, name, redirected)
    assert (done.returncode, done.stdout) == (0, usual[name])


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "shell"])
def test_a_closed_stdin_is_one_in_which_nothing_is(folder, name, usual):
    done = run(folder, name, "<&-")
    assert (done.returncode, done.stdout) == (0, usual[name])


@pytest.mark.parametrize("redirected", [">/dev/full 2>&1", "<&- >&- 2>&-"])
def test_where_nothing_can_be_told_the_status_tells_it(folder, redirected):
    assert run(folder, "query", redirected).returncode == 1


NARROW = {
    "ascii": {"PYTHONIOENCODING": "ascii"},
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "latin-1": {"PYTHONIOENCODING": "latin-1"},
}


@pytest.mark.parametrize("locale", NARROW)
@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "batch"])
def test_what_a_locale_has_not_is_escaped_for_people_and_utf_8_for_programs(folder, name, locale, usual):
    done = run(folder, name, **NARROW[locale])
    assert done.returncode == 0
    if name in ("program", "completion", "schema"):
        assert done.stdout == usual[name]
    elif name == "json":
        assert json.loads(done.stdout) == json.loads(usual[name])
    else:
        assert len(done.stdout.splitlines()) == len(usual[name].splitlines())
    if name == "query":
        assert "☃".encode() in usual[name]
        assert b"\\u2603" in done.stdout
        assert b"\\u2500" not in done.stdout, "the rule under the head"


def test_an_output_in_a_file_that_may_not_grow_is_told_and_nothing_is_left(folder):
    out = folder / "small"
    out.mkdir()
    line = f"ulimit -f 4; exec {shlex.quote(str(BIN / 'plogic'))} kb show first --html small/page.html"
    done = subprocess.run(
        ["bash", "-c", line], cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "plogic: small/page.html: cannot be written: File too large\n"
    assert list(out.iterdir()) == []


def on_a_terminal(*args, **env):
    """What a command writes where stdout is a terminal."""
    ours, theirs = pty.openpty()
    variables = (
        {k: v for k, v in os.environ.items() if k != "NO_COLOR"} | {"TERM": "xterm-256color", "COLUMNS": "100"} | env
    )
    with subprocess.Popen([BIN / "plogic", *args], stdout=theirs, stdin=subprocess.DEVNULL, env=variables) as run:
        os.close(theirs)
        chunks = list(iter(lambda: _read(ours), b""))
    os.close(ours)
    assert run.returncode == 0
    return b"".join(chunks).decode()


def _read(terminal):
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""  # the other side is closed


def test_styles_only_on_a_terminal_and_not_with_no_color(demo):
    assert "\x1b[" in on_a_terminal("worlds", demo / "interpretation.json")
    plain = on_a_terminal("worlds", demo / "interpretation.json", NO_COLOR="1")
    assert "possible worlds" in plain
    assert "\x1b" not in plain
    assert "\x1b" not in good("worlds", demo / "interpretation.json")


def test_a_terminal_is_shown_worlds_and_a_pipe_the_interpretation(demo):
    asked = ("perceive", demo / "gamma.json", "--kb", "towers")
    shown = on_a_terminal(*asked, NO_COLOR="1")
    assert "possible worlds" in shown
    assert "the whole interpretation (JSON): -o FILE" in shown
    assert len(shown) < 5000
    assert on_a_terminal(*asked, "-o", "-").startswith("{")
    assert json.loads(good(*asked))["format"] == "interpretation/1"
