"""``plogic program``, run by a stock problog, gives the numbers that ``worlds`` and ``query`` give, in both readings.

To its printed digits through its command line, to 1e-9 through its Python API.
"""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from itertools import product

import pytest
from console import BIN, document, good
from problog import get_evaluatable
from problog.program import PrologString

CASES = {
    "score": ("interpretation.json", ()),
    "posterior": ("posterior-interpretation.json", ()),
    "score, read as posterior": ("interpretation.json", ("--reading", "posterior")),
    "posterior, read as score": ("posterior-interpretation.json", ("--reading", "score")),
    "score, in doubt": ("doubtful-interpretation.json", ("--reading", "score")),
    "posterior, in doubt": ("doubtful-interpretation.json", ()),
}
GOALS = ("noise(A)", "partially_occludes(X, Y)", "ev(H, V)")
POOR = 5
"""Density of a match over that of clutter at which a hit rate of 0.1 leaves the worlds in doubt."""


def doubtful(interpretation):
    """The demo's posterior reading with a detector so poor that every world keeps a probability worth comparing."""
    clutter = {a["id"]: a["clutter"] for a in interpretation["appearances"]}
    for hypothesis in interpretation["hypotheses"]:
        for feature in hypothesis["features"]:
            feature["hit_rate"] = 0.1
            if feature["match"] is not None:
                feature["density"] = POOR * clutter[feature["match"]]
    return interpretation


@pytest.fixture(scope="module")
def folder(demo, tmp_path_factory):
    folder = tmp_path_factory.mktemp("readings")
    for name in ("interpretation.json", "posterior-interpretation.json"):
        (folder / name).write_bytes((demo / name).read_bytes())
    poor = doubtful(json.loads((demo / "posterior-interpretation.json").read_text()))
    (folder / "doubtful-interpretation.json").write_text(json.dumps(poor))
    return folder


@dataclass(frozen=True)
class Case:
    """A reading of a file: the answers of ``query`` and ``worlds``, and those of stock problog for the program."""

    query: dict[str, float]
    ids: list[str]
    worlds: dict[str, float]
    printed: dict[str, str]
    api: dict[str, float]


def only(theirs, prefix):
    return {goal: value for goal, value in theirs.items() if goal.startswith(prefix)}


@pytest.fixture(scope="module", params=CASES)
def case(request, folder, tmp_path_factory):
    name, options = CASES[request.param]
    source = folder / name
    ids, ranked = worlds(source, options)
    text = good("program", source, *options) + queries_of_worlds(ids)
    printed = stock_command(text, tmp_path_factory.mktemp("program"))
    return Case(answers(source, options), ids, ranked, printed, stock_api(text))


def stock_api(text):
    results = get_evaluatable("ddnnf").create_from(PrologString(text)).evaluate()
    return {str(goal).replace(" ", ""): p for goal, p in results.items()}


def stock_command(text, tmp_path):
    """Goal → printed digits, as ``problog FILE`` prints them."""
    (tmp_path / "program.pl").write_text(text)
    run = subprocess.run(
        [BIN / "problog", tmp_path / "program.pl"], capture_output=True, text=True, check=True, timeout=120
    )
    rows = [line.rpartition(":") for line in run.stdout.splitlines() if line.strip()]
    return {goal.strip().replace(" ", ""): digits.strip() for goal, _, digits in rows}


def digits(probability):
    """As problog's command line writes it: eight significant digits."""
    return f"{probability:.8g}"


def answers(source, options, *arguments):
    rows = document("query", source, *arguments, *options, "--json")["answers"]
    assert all(row["interval"] == [row["probability"]] * 2 for row in rows)
    return {row["goal"].replace(" ", ""): row["probability"] for row in rows}


def queries_of_worlds(ids):
    """A query for the conjunction of each world; the empty program line where there is no hypothesis."""
    lines = []
    for number, bits in enumerate(product((False, True), repeat=len(ids))):
        body = ", ".join(f"present({h})" if bit else f"\\+ present({h})" for h, bit in zip(ids, bits, strict=True))
        lines += [f"world_{number} :- {body}.", f"query(world_{number})."]
    return "\n".join(lines)


def worlds(source, options):
    """(ids, {name of the query: probability}) of all possible worlds, as ``worlds --json`` ranks them.

    0 for one that is not listed.
    """
    found = document("worlds", source, *options, "-n", 1000, "--json")
    assert found["unlisted_mass"] == [0.0, 0.0]
    ids = sorted({h for world in found["worlds"] for h in world["present"]})
    listed = {tuple(sorted(w["present"])): w["probability"] for w in found["worlds"]}
    subsets = [
        tuple(h for h, bit in zip(ids, bits, strict=True) if bit) for bits in product((False, True), repeat=len(ids))
    ]
    return ids, {f"world_{number}": listed.get(subset, 0.0) for number, subset in enumerate(subsets)}


def test_query_equals_the_stock_command_line_to_its_digits(case):
    assert set(case.query) == {f"present({h})" for h in case.ids}
    assert len(case.query) == 2
    assert only(case.printed, "present(") == {goal: digits(p) for goal, p in case.query.items()}


def test_query_equals_the_stock_api(case):
    assert only(case.api, "present(") == pytest.approx(case.query, abs=1e-9)


def test_worlds_equal_the_stock_command_line_to_its_digits(case):
    """A world of 1e-25 is not held to its digits: its program's terms of 1 leave none of them."""
    ours = {name: p for name, p in case.worlds.items() if p > 1e-6}
    assert ours
    theirs = only(case.printed, "world_")
    assert len(theirs) == len(case.worlds)
    assert {name: theirs[name] for name in ours} == {name: digits(p) for name, p in ours.items()}


def test_worlds_equal_the_stock_api(case):
    assert only(case.api, "world_") == pytest.approx(case.worlds, abs=1e-9)
    assert sum(case.worlds.values()) == pytest.approx(1.0, abs=1e-9)


def test_the_marginals_of_the_worlds_are_the_query(case):
    last = len(case.ids) - 1
    marginals = {
        f"present({h})": sum(p for number, p in enumerate(case.worlds.values()) if number >> (last - i) & 1)
        for i, h in enumerate(case.ids)
    }
    assert marginals == pytest.approx(case.query, abs=1e-9)


@pytest.mark.parametrize("name", ["score", "posterior, in doubt"])
def test_other_goals_equal_the_stock_api(folder, name):
    """Some of the vocabulary that speak of no label with a slash, each asked in a run of its own."""
    file, options = CASES[name]
    source = folder / file
    text = good("program", source, *options)
    theirs = stock_api(text + "".join(f"query({goal}).\n" for goal in GOALS))
    for goal in GOALS:
        ours = answers(source, options, goal)
        functor = goal.partition("(")[0] + "("
        rest = {name: p for name, p in theirs.items() if name.startswith(functor)}
        assert {name: p for name, p in rest.items() if p > 0} == pytest.approx(
            {name: p for name, p in ours.items() if p > 0}, abs=1e-9
        ), goal
        assert ours or not any(rest.values())


@pytest.mark.parametrize("given", ["present(h1)", "\\+ present(h2)"])
def test_given_equals_evidence_in_the_stock_program(folder, given):
    source = folder / "doubtful-interpretation.json"
    for options in (("--reading", "score"), ("--reading", "posterior")):
        text = good("program", source, *options) + f"evidence({given}).\n"
        ours = answers(source, options, "present(H)", "--given", given)
        assert {name: p for name, p in stock_api(text).items() if p > 0} == pytest.approx(ours, abs=1e-9)


def test_the_doubtful_reading_is_in_doubt(folder):
    _, ours = worlds(folder / "doubtful-interpretation.json", ())
    assert sum(p > 1e-3 for p in ours.values()) >= 2


def test_the_demos_own_program_files_are_what_the_command_prints(demo):
    for prefix in ("", "posterior-"):
        assert good("program", demo / f"{prefix}interpretation.json") == (demo / f"{prefix}program.pl").read_text()
