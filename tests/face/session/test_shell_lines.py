"""``plogic shell X < session.txt``: deterministic output, mistakes told and survived, exit codes."""

from __future__ import annotations

import subprocess

import pytest
from console import BIN, good, plogic

SESSION = """% what the neighbour knows
wet(G)
observe wet('Back yard').
predict rain

observe \\+ rain
why wet('Back yard')
unobserve
predict rain
"""
SHOWN = """answers

 probability   goal
 ──────────────────────────────
       0.650   wet(front)
       0.440   wet('Back yard')

observed wet('Back yard'): its probability was 0.440 (1.18 bits of surprise)
answers given wet('Back yard')

 probability   before   goal
 ───────────────────────────
       0.682    0.300   rain

observed \\+ rain: its probability was 0.318 (1.65 bits of surprise)
"""


def ran(file, *lines):
    return plogic("shell", file, stdin="\n".join(lines) + "\n")


def test_a_session_from_a_file(rain):
    done = plogic("shell", rain, stdin=SESSION)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(SHOWN)
    assert done.stdout.rstrip().endswith("0.300    0.300   rain")
    assert plogic("shell", rain, stdin=SESSION).stdout == done.stdout


@pytest.mark.parametrize("goal", [[], ["wet(G)"], ["sprinkler(X), wet(X)"], ["rain"]])
def test_ask_prints_what_query_prints(rain, goal):
    assert good("shell", rain, stdin=" ".join(["ask", *goal]) + "\n").strip() == good("query", rain, *goal).strip()


def test_a_line_that_fails_is_told_with_its_number_and_does_not_end_the_session(rain):
    done = ran(
        rain,
        "observe rain",
        "observe \\+ rain",
        "obsrve rain",
        "wet(",
        "zork(X)",
        "worlds many",
        "why",
        "listing zork",
        "predict rain",
    )
    assert done.returncode == 1
    told = done.stderr.splitlines()
    assert [line.split(": ")[1] for line in told] == [f"line {i}" for i in range(2, 9)]
    for line, part in zip(
        told,
        [
            "is impossible given rain",
            "did you mean `observe`",
            "goal:1:4: ",
            "zork/1",
            "should be a number",
            "`why [N] GOAL`",
            "no such predicate",
        ],
        strict=True,
    ):
        assert part in line
    assert done.stdout.rstrip().endswith("1    0.300   rain")


def test_quit_ends_it(rain):
    done = ran(rain, "rain", "quit", "wet(", "wet(X)")
    assert (done.returncode, done.stderr) == (0, "")
    assert "wet" not in done.stdout


def test_no_lines_are_a_session_too(rain):
    assert good("shell", rain) == ""


def test_saved_and_replayed(rain, tmp_path):
    first = plogic("shell", rain, stdin=SESSION + "save s.txt\n", cwd=tmp_path)
    assert (first.returncode, first.stderr) == (0, "")
    again = plogic("shell", rain, stdin=(tmp_path / "s.txt").read_text(), cwd=tmp_path)
    assert first.stdout == again.stdout + "saved 7 lines to s.txt\n"
    assert plogic("shell", rain, stdin="load s.txt\n", cwd=tmp_path).stdout.split() == again.stdout.split()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["rain.pl", "s.txt"]


def test_save_does_not_overwrite_a_program(rain, tmp_path):
    before = rain.read_bytes()
    done = plogic("shell", rain, stdin="save rain.pl\nsave nowhere/x.txt\n", cwd=tmp_path)
    assert done.returncode == 1
    assert "is no saved session" in done.stderr.splitlines()[0]
    assert "nowhere/x.txt: cannot be written" in done.stderr.splitlines()[1]
    assert rain.read_bytes() == before


def test_help_is_a_table_of_the_verbs_and_what_each_means(rain):
    text = good("shell", rain, stdin="help\nhelp observe\nhelp wet\n")
    for verb in (
        "ask",
        "observe",
        "unobserve",
        "predict",
        "worlds",
        "why",
        "whynot",
        "listing",
        "save",
        "load",
        "help",
        "quit",
    ):
        assert f"\n {verb}" in text
    assert "wet(_)" in text


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("bad.pl", "a :- b(.", "bad.pl:1:7: "),
        ("evil.pl", ":- use_module('x.py').\n", "evil.pl:1:4: "),
        ("no.json", "{}", "format: should be"),
        ("nowhere.pl", None, "cannot be read"),
    ],
)
def test_a_subject_that_cannot_be_used_is_told_at_once(tmp_path, name, text, told):
    if text is not None:
        (tmp_path / name).write_text(text)
    done = plogic("shell", tmp_path / name, stdin="ask a\n")
    assert (done.returncode, done.stdout) == (1, "")
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_the_subject_cannot_come_from_stdin():
    done = plogic("shell", "-", stdin="ask a\n")
    assert done.returncode == 1
    assert "stdin holds the lines of the session" in done.stderr


def test_a_scene(towers_file):
    lines = [
        "ask object(H, T)",
        "worlds 2",
        "observe \\+ present(t2)",
        "worlds",
        "predict present(t2_distorted)",
        "help present",
        "listing 3",
    ]
    done = ran(towers_file, *lines)
    assert (done.returncode, done.stderr) == (0, "")
    assert "0.961   object(t2, t2)" in done.stdout
    assert "1         0.961   t1 t1, t2 t2" in done.stdout
    assert "not listed" in done.stdout
    assert "possible worlds given \\+ present(t2)" in done.stdout
    assert "hypothesis H is in the world" in done.stdout
    assert "% The choices" in done.stdout


def test_lines_as_other_systems_write_them(rain):
    lines = b"\xef\xbb\xbfrain.\r\n\xff\xfe\r\nquit\r\n"
    run = subprocess.run(
        [str(BIN / "plogic"), "shell", rain], input=lines, capture_output=True, check=False, timeout=60
    )
    assert run.returncode == 1
    assert run.stderr.decode() == "plogic: line 2: is not UTF-8 text\n"
    assert "0.300   rain" in run.stdout.decode()


def test_trust_lets_a_program_of_ones_own_read_its_files(tmp_path):
    (tmp_path / "more.pl").write_text("0.25::a.\n")
    (tmp_path / "main.pl").write_text(":- consult('more.pl').\nb :- a.\nquery(b).\n")
    refused = plogic("shell", tmp_path / "main.pl", stdin="ask b\n")
    assert refused.returncode == 1
    assert "main.pl:1:4: " in refused.stderr
    trusted = plogic("shell", tmp_path / "main.pl", "--trust", stdin="ask b\nworlds\nlisting b\n")
    assert trusted.returncode == 0
    assert "0.250   b" in trusted.stdout
    assert [line[:8] for line in trusted.stderr.splitlines()] == ["--trust:"], "it says what it lifts"


def test_what_a_program_surely_does_not_mean_is_told_as_it_is_opened(tmp_path):
    (tmp_path / "main.pl").write_text("0.3::rain. 0.2::dry(mon). day(mon).\n:- rain.\n")
    run = plogic("shell", tmp_path / "main.pl", stdin="ask rain\nask \\+ dry(X), day(X)\n")
    assert run.stderr.splitlines()[0].partition(": ")[::2] == (
        f"{tmp_path / 'main.pl'}:2:4",
        "a clause without a head excludes no world: write excluded :- rain. evidence(\\+ excluded).",
    )
    assert "goal:1:1: \\+ dry(X) is asked before X has a value" in run.stdout


def test_a_number_of_any_length_is_told_as_a_wrong_one(rain):
    done = ran(rain, f"worlds {'9' * 5000}", f"show {'9' * 5000}", "predict rain")
    assert "plogic: line 1: worlds 999" in done.stderr
    assert "should be a number of worlds, such as worlds" in done.stderr
    assert "internal error" not in done.stderr
    assert "rain" in done.stdout
