"""The shell at a terminal: completion, history, Ctrl-C and Ctrl-D."""

from __future__ import annotations

from pathlib import Path

import pytest
from terminal import Terminal

from plogic.face.session.prompt import history_file

PROMPT = r"plogic>"


@pytest.fixture
def shell(tmp_path):
    """Starts shells whose history is in a folder of the test's own."""
    started = []

    def start(*args, **env):
        started.append(Terminal(*args, **{"XDG_STATE_HOME": str(tmp_path / "state"), **env}))
        return started[-1]

    yield start
    for terminal in started:
        terminal.kill()


def ends(terminal):
    """Whether Ctrl-D ends it well."""
    terminal.type("\x04")
    return terminal.end() == 0


def test_a_session_at_a_terminal(shell, rain):
    terminal = shell(rain)
    assert "rain.pl: 6 clauses of 4 predicates" in terminal.wait(r".*`help` lists the verbs.*")
    terminal.wait(PROMPT)
    terminal.type("wet(G).\r")
    terminal.wait(r"0\.650 +wet\(front\)")
    terminal.type("observe rain\r")
    terminal.wait(r"its probability was 0\.300")
    terminal.wait(r"plogic \(1 observed\)>")
    terminal.type("observe \\+ rain\r")
    terminal.wait(r"is impossible given rain[\s\S]*plogic")
    assert ends(terminal)


def test_tab_completes_verbs_predicates_and_names(shell, towers_file):
    terminal = shell(towers_file)
    terminal.wait(PROMPT)
    terminal.type("pre\t")
    assert "hypothesis H is in the world" in terminal.wait(r"predict[^\n]*\n[^\n]*present\(H\)[^\n]*")
    terminal.type("\x15observe pre\t")
    terminal.wait(r"pre\s*sent\(")  # what completion adds may be drawn by itself, after what was typed
    terminal.type("t2_\t")
    terminal.wait("distorted")
    terminal.type(")\r")
    terminal.wait(r"observed present\(t2_distorted\): its probability was 0\.010[\s\S]*plogic")
    terminal.type("quit\r")
    assert terminal.end() == 0


def test_the_history_is_there_in_the_next_session(shell, rain, tmp_path):
    first = shell(rain)
    first.wait(PROMPT)
    first.type("predict rain\r")
    first.wait(r"0\.300 +0\.300 +rain[\s\S]*plogic>")
    first.type("\x04")
    assert first.end() == 0
    assert "predict rain" in (tmp_path / "state" / "plogic" / "history").read_text()
    second = shell(rain)
    second.wait(PROMPT)
    second.type("\x1b[A")
    second.wait("predict rain")
    second.type("\r")
    second.wait(r"0\.300 +0\.300 +rain")


def test_a_history_that_cannot_be_kept_is_said_once(shell, rain, tmp_path):
    (tmp_path / "file").touch()
    terminal = shell(rain, XDG_STATE_HOME=str(tmp_path / "file"))
    terminal.wait("the history cannot be kept")
    terminal.wait(PROMPT)
    terminal.type("rain\r")
    terminal.wait(r"0\.300 +rain[\s\S]*plogic>")
    assert "history" not in terminal.screen
    assert ends(terminal)


def test_ctrl_c_stops_the_question_and_not_the_shell(shell, tmp_path):
    (tmp_path / "slow.pl").write_text(
        "0.3::rain.\nslow :- between(1, 300, X), between(1, 300, Y), between(1, 300, Z), X + Y + Z < 0.\n"
    )
    terminal = shell(tmp_path / "slow.pl")
    terminal.wait(PROMPT)
    terminal.type("observe rain\r")
    terminal.wait(r"plogic \(1 observed\)>")
    terminal.type("half a line\x03")
    terminal.wait(r"plogic \(1 observed\)>")
    terminal.type("slow\r")
    terminal.leave_alone(1)
    terminal.type("\x03")
    terminal.wait("interrupted; what was observed is as it was")
    terminal.wait(r"plogic \(1 observed\)>")
    terminal.type("predict rain\r")
    terminal.wait(r"1 +0\.300 +rain[\s\S]*plogic")
    assert ends(terminal)


def test_a_colour_that_is_pasted_is_no_mouse(shell, rain):
    terminal = shell(rain)
    terminal.wait(PROMPT)
    terminal.type("\x1b[31mrain\r")
    terminal.wait(r"0\.300 +rain[\s\S]*plogic>")
    assert "Traceback" not in terminal.screen
    assert ends(terminal)


def test_no_home_is_no_reason_to_end(monkeypatch):
    def nobody():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nobody)
    assert history_file() is None
