"""Questions, programs and interpretations that are none: one clear line, exit 1, nothing written."""

from __future__ import annotations

import json

import pytest
from refusals import assert_lines, refused

ASKED = {
    ("worlds", "nowhere.json"): "nowhere.json: cannot be read: No such file",
    ("worlds", "folder.json"): "folder.json: cannot be read: Is a directory",
    ("worlds", "empty.json"): "empty.json:1:1: is no JSON",
    ("worlds", "cut.json"): "cut.json:1:5001: is no JSON",
    ("worlds", "image.png"): "image.png:1:1: is no JSON: byte 0 is no UTF-8",
    ("worlds", "camera.json"): "camera.json:1:1: format: should be 'interpretation/1'",
    ("program", "empty.json"): "empty.json:1:1: is no JSON",
    ("report", "empty.json", "-o", "page.html"): "empty.json:1:1: is no JSON",
    ("query", "interpretation.json", "present(h1"): "goal:1:8: Unmatched character '('",
    ("query", "interpretation.json", "zork(h1)"): "goal:1:1: no clauses for zork/1",
    ("query", "interpretation.json", "use_module('x.py')"): "goal:1:1: use_module/1 is not allowed",
    ("query", "interpretation.json", "consult('x.py')"): "goal:1:1: consult/1 is not allowed",
    ("query", "interpretation.json", "present(H)", "--given", "zork("): "given:1:5: Unmatched",
    ("query", "interpretation.json", "present(H)", "--given", "zork(h1)"): "given:1:1: no clauses for zork/1",
    (
        "query",
        "interpretation.json",
        "present(H)",
        "--given",
        "present(h1)",
        "--given",
        "\\+ present(h1)",
    ): "no world satisfies the evidence",
    ("query", "interpretation.json", "near(X, Y, D)"): "goal: near(X, Y, D) asks for a value of D, and finds none",
    ("worlds", "interpretation.json", "--given", "near(X, Y, D)"): "goal: near(X, Y, D) asks for a value of D",
    (
        "query",
        "interpretation.json",
        "present(H)",
        "--rules",
        "hostile.pl",
    ): "hostile.pl:1:4: directive use_module('x.py')",
    ("query", "interpretation.json", "present(H)", "--rules", "syntax.pl"): "syntax.pl:2:",
    ("query", "interpretation.json", "present(H)", "--rules", "nowhere.pl"): "nowhere.pl: cannot be read: No such file",
    ("query", "interpretation.json", "present(H)", "--rules", "folder.pl"): "folder.pl: cannot be read: Is a directory",
    ("query", "hostile.pl"): "hostile.pl:1:4: directive use_module('x.py')",
    ("query", "syntax.pl"): "syntax.pl:2:",
    ("query", "nowhere.pl"): "nowhere.pl: cannot be read: No such file",
    ("query", "folder.pl"): "folder.pl: cannot be read: Is a directory",
    ("explain", "interpretation.json", "present(h1"): "goal:1:8: Unmatched character '('",
    ("explain", "interpretation.json", "zork(h1)"): "goal:1:1: no clauses for zork/1",
    ("explain", "hostile.pl", "a"): "hostile.pl:1:4: directive use_module('x.py')",
}


@pytest.mark.parametrize("args", ASKED, ids=" ".join)
def test_a_bad_question(args, inputs):
    assert_lines(refused(inputs, *args), [ASKED[args]])


INTERPRETATIONS = {
    "no facts": (lambda d: d.pop("facts"), "facts: is missing"),
    "no such reading": (lambda d: d.update(reading="zork"), "reading: 'zork' should be one of score, posterior"),
    "no such mode": (
        lambda d: d.update(reconsider=["drop"]),
        "reconsider: ['drop'] should be one of to_B, drop, reassign",
    ),
    "a NaN": (lambda d: d["hypotheses"][0]["features"][0].update(dv=float("nan")), "is no JSON: NaN is no number"),
    "a negative density": (
        lambda d: d["hypotheses"][0]["features"][0].update(density=-1.0),
        "hypotheses.0.features.0.density: -1.0 is not a number from 0.0",
    ),
    "a duplicate id": (lambda d: d["hypotheses"].insert(0, d["hypotheses"][0]), "hypothesis 'h1' occurs twice"),
    "a world with a stranger": (
        lambda d: d["worlds"][0]["present"].append("h9"),
        "worlds.0.present: 'h9' should be a hypothesis that is not rejected",
    ),
    "no list": (lambda d: d.update(hypotheses="h1"), "hypotheses: 'h1' is no list"),
    "hostile rules": (lambda d: d.update(rules=":- use_module('x.py')."), "rules.pl:1:4: directive use_module('x.py')"),
}


@pytest.mark.parametrize("kind", INTERPRETATIONS)
def test_a_bad_interpretation(kind, inputs):
    spoil, wanted = INTERPRETATIONS[kind]
    spoilt = json.loads((inputs / "interpretation.json").read_text())
    spoil(spoilt)
    (inputs / "spoilt.json").write_text(json.dumps(spoilt))
    assert_lines(refused(inputs, "program", "spoilt.json"), [wanted])
    assert_lines(refused(inputs, "query", "-", "present(H)", stdin=json.dumps(spoilt)), [wanted])
