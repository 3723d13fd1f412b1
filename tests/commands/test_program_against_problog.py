"""``plogic program``, run by a stock problog, gives the numbers that ``worlds`` and ``query`` give, in both readings.

To its printed digits through its command line, to 1e-9 through its Python API.
"""

from __future__ import annotations

import json
import subprocess
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
GOALS = ("present(H)", "noise(A)", "partially_occludes(X, Y)", "nearer(X, Y)", "left_of(X, Y)", "object(H, T)", "ev(H, V)", "near(h1, h2, 9)")


def doubtful(interpretation):
    """The demo's posterior reading with a detector so poor that every world keeps a probability worth comparing."""
    clutter = {a["id"]: a["clutter"] for a in interpretation["appearances"]}
    for hypothesis in interpretation["hypotheses"]:
        for feature in hypothesis["features"]:
            feature["hit_rate"] = 0.1
            if feature["match"] is not None:
                feature["density"] = 11 * clutter[feature["match"]]
    return interpretation


@pytest.fixture(scope="module")
def folder(demo, tmp_path_factory):
    folder = tmp_path_factory.mktemp("readings")
    for name in ("interpretation.json", "posterior-interpretation.json"):
        (folder / name).write_bytes((demo / name).read_bytes())
    poor = doubtful(json.loads((demo / "posterior-interpretation.json").read_text()))
    (folder / "doubtful-interpretation.json").write_text(json.dumps(poor))
    return folder


@pytest.fixture(scope="module", params=CASES)
def case(request, folder):
    """(source, options, the program's text) of each reading of each file."""
    name, options = CASES[request.param]
    return folder / name, options, good("program", folder / name, *options)


def stock_api(text):
    results = get_evaluatable("ddnnf").create_from(PrologString(text)).evaluate()
    return {str(goal).replace(" ", ""): p for goal, p in results.items()}


def stock_command(text, tmp_path):
    """Goal → printed digits, as ``problog FILE`` prints them."""
    (tmp_path / "program.pl").write_text(text)
    run = subprocess.run([BIN / "problog", tmp_path / "program.pl"], capture_output=True, text=True, check=True, timeout=120)
    rows = [line.rpartition(":") for line in run.stdout.splitlines() if line.strip()]
    return {goal.strip().replace(" ", ""): digits.strip() for goal, _, digits in rows}


def printed(probability):
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
    """(ids, {name of the query: probability}) of all possible worlds, as ``worlds --json`` ranks them; 0 for one that is not listed."""
    found = document("worlds", source, *options, "-n", 1000, "--json")
    assert found["unlisted_mass"] == [0.0, 0.0]
    ids = sorted({h for world in found["worlds"] for h in world["present"]})
    listed = {tuple(sorted(w["present"])): w["probability"] for w in found["worlds"]}
    subsets = [tuple(h for h, bit in zip(ids, bits, strict=True) if bit) for bits in product((False, True), repeat=len(ids))]
    return ids, {f"world_{number}": listed.get(subset, 0.0) for number, subset in enumerate(subsets)}


def test_query_equals_the_stock_command_line_to_its_digits(case, tmp_path):
    source, options, text = case
    ours = answers(source, options)
    assert set(ours) == {"present(h1)", "present(h2)"}
    assert stock_command(text, tmp_path) == {goal: printed(p) for goal, p in ours.items()}


def test_query_equals_the_stock_api(case):
    source, options, text = case
    assert stock_api(text) == pytest.approx(answers(source, options), abs=1e-9)


def test_worlds_equal_the_stock_command_line_to_its_digits(case, tmp_path):
    source, options, text = case
    ids, ours = worlds(source, options)
    assert ids == ["h1", "h2"]
    theirs = stock_command(text + queries_of_worlds(ids), tmp_path)
    assert {name: float(theirs[name]) for name in ours} == pytest.approx({n: float(printed(p)) for n, p in ours.items()}, rel=2e-8, abs=1e-12)


def test_worlds_equal_the_stock_api_and_their_marginals_are_the_query(case):
    source, options, text = case
    ids, ours = worlds(source, options)
    theirs = stock_api(text + queries_of_worlds(ids))
    assert {name: theirs[name] for name in ours} == pytest.approx(ours, abs=1e-9)
    assert sum(ours.values()) == pytest.approx(1.0, abs=1e-9)
    marginals = {
        f"present({h})": sum(p for n, p in enumerate(ours.values()) if n >> (len(ids) - 1 - i) & 1) for i, h in enumerate(ids)
    }
    assert marginals == pytest.approx(answers(source, options), abs=1e-9)


def test_other_goals_equal_the_stock_api(case):
    """Those of the vocabulary that speak of no label with a slash, each asked in a run of its own."""
    source, options, text = case
    theirs = stock_api(text + "".join(f"query({goal}).\n" for goal in GOALS))
    for goal in GOALS:
        ours = answers(source, options, goal)
        functor = goal.partition("(")[0] + "("
        rest = {name: p for name, p in theirs.items() if name.startswith(functor)}
        assert {name: p for name, p in rest.items() if p > 0} == pytest.approx({name: p for name, p in ours.items() if p > 0}, abs=1e-9), goal
        assert ours or not any(rest.values())


@pytest.mark.parametrize("given", ["present(h1)", "\\+ present(h1)", "\\+ present(h2)"])
def test_given_equals_evidence_in_the_stock_program(folder, given):
    source = folder / "doubtful-interpretation.json"
    for options in (("--reading", "score"), ("--reading", "posterior")):
        text = good("program", source, *options) + f"evidence({given}).\n"
        ours = answers(source, options, "present(H)", "--given", given)
        assert {name: p for name, p in stock_api(text).items() if p > 0} == pytest.approx(ours, abs=1e-9)


def test_the_doubtful_reading_is_in_doubt(folder):
    _, ours = worlds(folder / "doubtful-interpretation.json", ())
    assert min(ours.values()) > 1e-3


def test_the_demos_own_program_files_are_what_the_command_prints(demo):
    for prefix in ("", "posterior-"):
        text = (demo / f"{prefix}program.pl").read_text()
        assert good("program", demo / f"{prefix}interpretation.json").startswith(text)
        assert "query(" not in text
