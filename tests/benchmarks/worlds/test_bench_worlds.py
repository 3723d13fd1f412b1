"""``plogic bench worlds``: all sides agree, claims are computed from measurements, and times are not judged."""

import json
from dataclasses import replace

import pytest

from benchmarks.families.bench import clusters, grid
from benchmarks.worlds import bench as worlds
from benchmarks.worlds import ours as worlds_ours
from benchmarks.worlds import stock as worlds_stock
from benchmarks.worlds.bench import SIZES, Case, Measured, measure
from benchmarks.worlds.ours import OurRun
from benchmarks.worlds.stock import StockRun
from benchmarks.worlds.table import claims, ratio, row, text_ratio

LIMIT = 60.0
USED = {"> 60": 54.0}
"""Seconds that a way of ProbLog's which ran out of time had compiled for."""
FAST = OurRun(build=0.002, infer=0.001, few=0.0005, many=0.01, listed=0.05, text=0.5, least=0.003, answers={"h1": 0.5})


@pytest.fixture(autouse=True)
def _run_once(monkeypatch):
    """What is measured is not judged here, so that nothing is run a second time."""
    monkeypatch.setattr(worlds_stock, "SHORT", 0.0)
    monkeypatch.setattr(worlds_ours, "ENOUGH", 0.0)


@pytest.fixture
def _in_this_process(monkeypatch):
    """The code of the child process without a child for each run, whose imports take longer than the run itself.

    ``test_bench_worlds_stock`` is about the child.
    ``test_a_way_that_failed_is_not_tried_at_larger_sizes`` starts it.
    """

    def run(text, knowledge, _seconds):
        return StockRun(knowledge, **worlds_stock._run(text, knowledge, lambda _: None))

    monkeypatch.setattr(worlds_stock, "stock", run)


def measured(family="clusters", number=20, *, ours=FAST, stock=(1.0, 2.0), columns=0, differences=None):
    runs = tuple(
        StockRun(k, 0.1, 0.2, seconds, {"present(h1)": 0.5})
        if isinstance(seconds, float)
        else StockRun(k, infer=USED.get(seconds, 0.0), why=seconds)
        for k, seconds in zip(("ddnnf", "sdd"), stock, strict=True)
    )
    return Measured(
        Case(family, number, clusters(5, 0), columns),
        runs,
        ours,
        differences or {"ddnnf": 1e-13, "enumeration": 1e-15},
        LIMIT,
    )


def all_good():
    scenes = measured("simulated", 40, stock=("> 60", "> 60"))
    largest = measured("clusters", 200)
    return [measured(), measured(number=80, stock=(3.0, "> 60")), measured("grid", 361, columns=19), scenes, largest]


def unmet(rows):
    return [claim.claim for claim in claims(rows) if not claim.met]


def test_the_ratio_is_to_the_faster_way():
    assert ratio(measured(stock=(1.2, 0.6))) == pytest.approx(200)
    assert text_ratio(measured(stock=(1.2, 0.6))) == pytest.approx(0.9 / 0.5)


def test_where_all_ran_out_of_time_the_ratio_is_a_lower_bound():
    assert ratio(measured(stock=("> 60", "> 60"))) == pytest.approx(54.0 / 0.003)
    assert row(measured(stock=("> 60", "DSharpError")))["ratio"] == "> 18000"


@pytest.mark.parametrize("why", [("skipped", "skipped"), ("DSharpError", "out of memory")])
def test_where_nothing_was_timed_there_is_no_ratio(why):
    assert ratio(measured(stock=why)) is None
    assert row(measured(stock=why))["ratio"] == ""


def test_all_claims_can_be_met():
    assert unmet(all_good()) == []
    assert len(claims(all_good())) == 9


@pytest.mark.parametrize(
    ("place", "worse", "said"),
    [
        (0, {"stock": (0.29, "> 60")}, "K = 20"),
        (1, {"number": 80, "stock": (0.89, "> 60")}, "K = 80: all marginals"),
        (1, {"number": 80, "ours": replace(FAST, text=2.0)}, "from the program text"),
        (2, {"family": "grid", "number": 361, "columns": 19, "ours": replace(FAST, infer=11.0)}, "grid of width 19"),
        (3, {"family": "simulated", "number": 40, "stock": (0.29, "> 60")}, "simulated"),
        (4, {"number": 200, "ours": replace(FAST, listed=1.1)}, "top-1000"),
        (0, {"ours": replace(FAST, few=0.0011)}, "top-10"),
        (0, {"differences": {"ddnnf": 2e-9}}, "stock ProbLog wherever it finishes"),
        (0, {"differences": {"enumeration": 2e-9}}, "enumeration"),
        (0, {"differences": {"frontier": 2e-9}}, "frontier"),
    ],
)
def test_a_claim_that_is_missed_is_not_met(place, worse, said):
    rows = all_good()
    rows[place] = measured(**worse)
    assert any(said in claim for claim in unmet(rows))


def test_the_sizes_are_the_issues():
    assert SIZES == (5, 10, 20, 40, 80, 200)


@pytest.mark.usefixtures("_in_this_process")
@pytest.mark.parametrize(
    "case",
    [
        Case("clusters", 9, clusters(9, 5)),
        Case("clusters/score", 9, clusters(9, 5, "score")),
        Case("grid", 12, grid(12, 3, 5), 3),
    ],
    ids=lambda case: case.family,
)
def test_all_sides_agree(case):
    """Ours on the graph and from the text, both ways of stock ProbLog, and enumeration.

    Marginals and the best worlds.
    """
    found = measure(case, LIMIT, set())
    assert set(found.differences) == {"ddnnf", "sdd", "text", "enumeration", "enumerated worlds"}
    assert max(found.differences.values()) <= 1e-9


def test_a_wide_grid_agrees_with_the_frontier():
    found = measure(Case("grid", 36, grid(36, 12, 1), 12, tried=False), LIMIT, set())
    assert set(found.differences) == {"frontier"}
    assert found.differences["frontier"] <= 1e-9


def test_a_way_that_failed_is_not_tried_at_larger_sizes():
    failed = {("clusters", "sdd")}
    found = measure(Case("clusters", 5, clusters(5, 0)), LIMIT, failed)
    assert [(s.knowledge, s.why) for s in found.stock] == [("ddnnf", ""), ("sdd", "skipped")]
    measure(Case("grid", 5, grid(5, 2, 0), 2), 0.001, failed)
    assert failed == {("clusters", "sdd"), ("grid", "ddnnf"), ("grid", "sdd"), ("grid", "plogic")}


@pytest.mark.usefixtures("_in_this_process")
def test_the_benchmark_end_to_end(monkeypatch):
    """Quick sizes, smaller still: structure and agreement, never times."""
    monkeypatch.setattr(worlds, "QUICK_SIZES", (5,))
    monkeypatch.setattr(worlds, "QUICK_SCENES", (5,))
    said = []
    text, met = worlds.run(seed=0, limit=LIMIT, quick=True, as_json=True, say=said.append)
    document = json.loads(text)
    assert document["bench"] == "worlds"
    assert [(r["family"], r["K"]) for r in document["rows"]] == [
        (f, 5) for f in ("clusters", "score", "grid", "simulated")
    ]
    assert len(said) == 4
    assert met == all(claim["met"] for claim in document["claims"])
    agreement = [claim for claim in document["claims"] if "difference" in claim["claim"]]
    assert [claim["met"] for claim in agreement] == [True, True]
    assert all(float(r["differ"]) <= 1e-9 for r in document["rows"])


@pytest.mark.usefixtures("_in_this_process")
def test_the_table_says_what_its_columns_mean(monkeypatch):
    monkeypatch.setattr(worlds, "cases", lambda _, **_options: iter([Case("grid", 4, grid(4, 2, 0), 2)]))
    text, _ = worlds.run(seed=0, limit=LIMIT, quick=False, as_json=False, say=lambda _: None)
    for column in ("ddnnf", "sdd", "ours", "ratio", "text", "ratio of text", "top 10", "listed", "differ"):
        assert f"{column}:" in text or f"{column}," in text or f", {column}" in text
    assert "bench worlds" in text
    assert "claims" in text
