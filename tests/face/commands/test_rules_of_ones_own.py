"""A knowledge base whose rules choose, observe and constrain, end to end: from a Γ to worlds and explanations."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from console import document, good, plogic
from stock_worlds import stock

from kb.files.folder import shipped

RULES = Path(__file__).parents[3] / "examples" / "rules.pl"


@pytest.fixture(scope="module")
def folder(demo, tmp_path_factory):
    """The towers with the example's rules, and what is perceived with them."""
    folder = tmp_path_factory.mktemp("authored")
    shutil.copytree(shipped("towers"), folder / "kb")
    shutil.copy(RULES, folder / "kb" / "rules.pl")
    good("perceive", demo / "gamma.json", "--kb", folder / "kb", "--out", folder / "scene.json")
    return folder


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_perceived_with_rules_asked_and_explained(folder, reading):
    scene, options = folder / "scene.json", ("--reading", reading)
    worlds = document("worlds", scene, *options, "--json")["worlds"]
    answers = document("query", scene, "present(H)", *options, "--json")["answers"]
    chances = {a["goal"]: a["probability"] for a in answers}
    goals = ("present(H)", "wet", "constraint(N)")
    asked = "".join(f"query({goal}).\n" for goal in goals)
    theirs = stock(f"{good('program', scene, *options)}\n{asked}")
    for goal in goals:
        found = document("query", scene, goal, *options, "--json")["answers"]
        assert found
        assert all(a["probability"] == pytest.approx(theirs[a["goal"].replace(", ", ",")], abs=1e-9) for a in found)
    for name in ("h1", "h2"):
        total = sum(w["probability"] for w in worlds if name in w["present"])
        assert total == pytest.approx(chances[f"present({name})"], abs=1e-9)
    text = good("explain", scene, "present(h1)", *options)
    assert "violates constraint(crowded(h1, h2)), which may fail, with probability" in text


def test_the_program_with_rules_beside_is_what_they_are_asked_by(folder, demo, tmp_path):
    rules = tmp_path / "own.pl"
    rules.write_text("0.3::heavy(X) :- object(X, t1).\nconstraint(no(X)) :- heavy(X), object(X, t1).\n")
    theirs = stock(f"{good('program', folder / 'scene.json', '--rules', rules)}\nquery(heavy(_)). query(wet).\n")
    for goal in ("present(H)", "wet", "heavy(H)"):
        for a in document("query", folder / "scene.json", goal, "--rules", rules, "--json")["answers"]:
            assert a["probability"] == pytest.approx(theirs[a["goal"].replace(", ", ",")], abs=1e-9)
    rules.write_text("wet :- fail.\n")
    refused = plogic("program", folder / "scene.json", "--rules", rules).stderr
    assert "own.pl:1:1: wet/0 is defined by the program and cannot be added to" in refused


def test_what_is_perceived_lists_the_worlds_that_are_asked_for(folder, demo):
    interpretation = json.loads((folder / "scene.json").read_text())
    asked = document("worlds", folder / "scene.json", "--json")["worlds"]
    beside = document("worlds", demo / "interpretation.json", "--rules", RULES, "--json")["worlds"]
    for rows in (asked, beside):
        assert [(w["present"], pytest.approx(w["probability"])) for w in rows] == [
            (w["present"], w["probability"]) for w in interpretation["worlds"]
        ]


def test_a_choice_is_explained_with_its_probability(folder):
    text = good("explain", folder / "scene.json", "wet")
    assert "before it]\n  wet  [choice]" in text
    assert "0.1 before it" in text


def changed(folder, tmp_path, rules):
    """The knowledge base with other rules."""
    shutil.copytree(folder / "kb", tmp_path / "kb")
    (tmp_path / "kb" / "rules.pl").write_text(rules)
    return tmp_path / "kb"


def test_contradictory_rules_are_told_in_one_line(folder, demo, tmp_path):
    rules = "constraint(some) :- object(_, t1).\nconstraint(none) :- \\+ object(_, t1).\n0.1::wet.\nevidence(wet).\n"
    kb = changed(folder, tmp_path, rules)
    told = "plogic: no world satisfies rules.pl:1:1: constraint(some) and rules.pl:2:1: constraint(none)\n"
    for command in (
        ("perceive", demo / "gamma.json", "--kb", kb, "--out", tmp_path / "scene.json"),
        ("worlds", demo / "interpretation.json", "--rules", kb / "rules.pl"),
        ("query", demo / "interpretation.json", "present(H)", "--rules", kb / "rules.pl"),
    ):
        done = plogic(*command)
        assert done.returncode == 1
        assert done.stderr.endswith(
            told.replace("rules.pl", str(kb / "rules.pl") if "--rules" in command else "rules.pl")
        )
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "scene.json").exists()
    assert "no mistakes" in good("kb", "check", kb)  # a scene without hypotheses would not tell


def test_what_constraints_exclude_is_told_and_nothing_is_smoothed(folder, demo, tmp_path):
    kb = changed(folder, tmp_path, "constraint(nothing) :- object(_, _).\n")
    done = plogic("perceive", demo / "gamma.json", "--kb", kb, "--out", tmp_path / "scene.json")
    assert done.returncode == 0, done.stderr
    scene = json.loads((tmp_path / "scene.json").read_text())
    assert scene["smoothing"] == 0.0
    assert [(w["present"], w["probability"]) for w in scene["worlds"]] == [([], 1.0)]
    assert done.stderr.count("no possible world holds it: its probability is 0") == 2
    text = good("explain", tmp_path / "scene.json", "object(X, t1)")
    assert "note: no world holds it, because of rules.pl:1:1: constraint(nothing)" in text


@pytest.mark.parametrize(("rules", "told"), [
    ("0.1::wet.\n:- wet.\nevidence(dry).\n", "the closest that is known: dr/2; also rules.pl:2:4: a clause without a head"),
    (
        "0.1::wet.\nconstraint(dry) :- wet.\nevidence(wet).\n",
        "no world satisfies rules.pl:2:1: constraint(dry) and rules.pl:3:1: evidence(wet), whatever is seen",
    ),
])  # fmt: skip
def test_a_mistake_that_no_scene_is_needed_for_is_found_by_kb_check(folder, tmp_path, rules, told):
    done = plogic("kb", "check", changed(folder, tmp_path, rules))
    assert done.returncode == 1
    assert told in done.stderr


def test_several_views_count_who_is_present_and_a_batch_tells_what_leaves_no_world(folder, demo, tmp_path):
    kb = changed(folder, tmp_path, "constraint(a) :- object(_, t1).\n")
    done = plogic("perceive", demo / "gamma.json", demo / "gamma.json", "--kb", kb, "--out", tmp_path / "views.json")
    assert done.returncode == 0, done.stderr
    assert "rules.pl: over several views it counts who is present" in done.stderr
    assert {found["type"] for found in json.loads((tmp_path / "views.json").read_text())["objects"]} == {"t2"}
    (kb / "rules.pl").write_text("constraint(a) :- object(_, t1).\nconstraint(b) :- \\+ object(_, t1).\n")
    done = plogic("batch", demo / "gamma.json", "--kb", kb, "--out", tmp_path / "frames.jsonl")
    assert done.returncode == 1
    (line,) = (tmp_path / "frames.jsonl").read_text().splitlines()
    assert json.loads(line)["error"] == "no world satisfies rules.pl:1:1: constraint(a) and rules.pl:2:1: constraint(b)"
