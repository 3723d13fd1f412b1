"""Every command that answers from an unfinished interpretation says so, in one line of text and in a key of JSON.

Of a finished one none does.
"""

from __future__ import annotations

import json
from functools import cache

import pytest
from console import document, good, plogic

from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.situation import SEARCH, WORLDS
from plogic.scene.readings.unfinished import marked, notice
from plogic.scene.worlds.ranked_worlds import ranked_worlds

GOAL = "present(h1)"
ASKED = {
    "worlds": lambda file: ("worlds", file),
    "worlds given": lambda file: ("worlds", file, "--given", GOAL),
    "worlds by the text": lambda file: ("worlds", file, "--given", "pick(h1, F)"),
    "query": lambda file: ("query", file, GOAL),
    "query of two": lambda file: ("query", file, "present(h1), present(h2)"),
    "query by a deadline": lambda file: ("query", file, GOAL, "--deadline", 600),
    "query by the text": lambda file: ("query", file, "pick(h1, F)"),
    "explain": lambda file: ("explain", file, GOAL, "-n", 1),
    "program": lambda file: ("program", file),
    "next-view": lambda file: ("next-view", file, "-n", 1),
}


@cache
def text_and_document(*command):
    """What a command prints, as text and with ``--json``; the same command about the same file runs once."""
    return good(*command), document(*command, "--json")


@pytest.fixture(scope="module")
def files(demo, tmp_path_factory):
    """The demo's interpretation, finished; and as it would be had the deadline come in the search, or after it."""
    folder, whole = tmp_path_factory.mktemp("unfinished"), json.loads((demo / "interpretation.json").read_text())
    ranking = ranked_worlds(situation_of(whole), 100)
    found = {"": demo / "interpretation.json"}
    for stopped in (SEARCH, WORLDS):
        found[stopped] = folder / f"{stopped}.json"
        found[stopped].write_text(text_of(marked(whole, ranking, stopped)))
    return found


@pytest.fixture(scope="module")
def at_once(demo, tmp_path_factory):
    """What ``plogic perceive`` with no time at all writes, and what it says."""
    out = tmp_path_factory.mktemp("at_once") / "d.json"
    run = plogic("perceive", demo / "gamma.json", "--kb", "towers", "--deadline", "0.000001", "-o", out)
    assert run.returncode == 3
    return out, run.stderr


@pytest.mark.parametrize("stopped", [SEARCH, WORLDS])
@pytest.mark.parametrize("name", ASKED)
def test_every_command_says_so(files, name, stopped):
    command = ASKED[name](files[stopped])
    text, told = text_and_document(*command)
    line = f"% {notice(stopped)}." if name == "program" else notice(stopped, anew=name != "next-view")
    assert [told for told in text.splitlines() if "unfinished" in told] == [line]
    assert (told["unfinished"], told["stopped"]) == (True, stopped)


@pytest.mark.parametrize("name", ASKED)
def test_of_a_finished_one_none_does(files, name):
    text, told = text_and_document(*ASKED[name](files[""]))
    assert "unfinished" not in text
    assert not {"unfinished", "stopped"} & set(told)


@pytest.mark.parametrize("name", [name for name in ASKED if name.startswith(("worlds", "query"))])
def test_answers_are_as_before_with_intervals_that_are_open(files, name):
    rows = {}
    for stopped in ("", SEARCH, WORLDS):
        told = text_and_document(*ASKED[name](files[stopped]))[1]
        rows[stopped] = told.get("worlds") or told["answers"]
        assert told.get("unlisted_mass", [0.0, 1.0]) == [0.0, 1.0] or stopped != SEARCH
    assert rows[SEARCH]
    for finished, searched, weighed in zip(*rows.values(), strict=True):
        assert searched["probability"] == weighed["probability"] == finished["probability"]
        assert searched["interval"] == [0.0, 1.0]
        assert weighed["interval"] == [finished["probability"]] * 2


@pytest.mark.parametrize("command", ["worlds", "query"])
def test_the_table_has_probability_and_interval(files, command):
    lines = [line.split() for line in good(command, files[SEARCH], "-n1" if command == "worlds" else GOAL).splitlines()]
    head, row = next((lines[i], lines[i + 2]) for i in range(len(lines)) if "probability" in lines[i])
    assert row[head.index("probability")] not in ("0", "1")
    assert row[head.index("probability") + 1] == "0..1"
    assert head[head.index("probability") + 1] == "interval"
    assert "interval" not in good(command, files[""], "-n1" if command == "worlds" else GOAL)


def test_the_shell_says_so_below_every_answer(files):
    lines = f"ask {GOAL}\npredict {GOAL}\nobserve {GOAL}\nworlds 2\nwhy {GOAL}\nwhynot {GOAL}\n"
    text = good("shell", files[SEARCH], stdin=lines)
    assert text.count(notice(SEARCH)) == 6
    assert good("shell", files[WORLDS], stdin=lines).count(notice(WORLDS)) == 6
    assert "unfinished" not in good("shell", files[""], stdin=lines)


def test_perceive_says_so_in_its_line_and_nothing_known_is_not_sure(at_once):
    out, said = at_once
    assert "no known object; unfinished: the deadline came before the search was over" in said
    text, told = good("worlds", out), document("worlds", out, "--json")
    assert next(line for line in text.splitlines() if "nothing known" in line).split()[1:3] == ["1", "0..1"]
    assert text.rstrip().endswith(notice(SEARCH))
    assert (told["worlds"][0]["interval"], told["unlisted_mass"], told["unfinished"]) == ([0.0, 1.0], [0.0, 1.0], True)
    assert document("query", out, "--json") == {
        "format": "answers/1",
        "answers": [],
        "unfinished": True,
        "stopped": "search",
    }


def test_one_that_does_not_say_what_was_stopped_may_lack_anything(files, tmp_path):
    old = json.loads(files[WORLDS].read_text())
    del old["stopped"]
    (tmp_path / "old.json").write_text(text_of(old))
    assert document("query", tmp_path / "old.json", GOAL, "--json")["answers"][0]["interval"] == [0.0, 1.0]


def test_what_was_stopped_has_to_be_known(files, tmp_path):
    text = text_of(json.loads(files[SEARCH].read_text()) | {"stopped": ["x"]})
    (tmp_path / "bad.json").write_text(text)
    column = text.index('["x"]') + 1
    run = plogic("worlds", tmp_path / "bad.json")
    assert (run.returncode, run.stderr) == (
        1,
        f"plogic: {tmp_path}/bad.json:1:{column}: stopped: ['x'] should be one of search, worlds\n",
    )
