"""``plogic bench programs``: the programs are what they are said to be, and claims are computed from measurements."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from benchmarks.programs import bench
from benchmarks.programs.bench import Measured, claims
from benchmarks.programs.families import SIZES, Sample, samples
from benchmarks.programs.whole import Whole
from benchmarks.worlds.stock import StockRun
from plogic.logic.answers.answer import answers_of_text

LIMIT = 60.0


def measured(*, mine=0.3, theirs=0.1, over=False, answer=0.5, family="smokers", size=4):
    runs = {
        "sdd": StockRun("sdd", infer=0.05, answers={} if over else {"q": 0.5}, why="> 60" if over else ""),
        "ddnnf": StockRun("ddnnf", infer=0.5, answers={"q": 0.5}),
        "plogic": StockRun("plogic", infer=0.04, answers={"q": answer}),
    }
    whole = {"sdd": Whole(LIMIT if over else theirs, over), "plogic": Whole(mine)}
    return Measured(Sample(family, size, "q."), runs, whole, LIMIT)


def test_all_sizes_of_the_families_are_there_the_same_at_every_call():
    found = list(samples(0, quick=False))
    assert [(one.family, one.size) for one in found if one.family != "alarm"] == [
        (family, size) for family, sizes in SIZES.items() for size in sizes
    ]
    assert found == list(samples(0, quick=False))
    assert found != list(samples(1, quick=False))


@pytest.mark.parametrize("sample", list(samples(3, quick=True)), ids=lambda sample: sample.family)
def test_every_family_has_answers_that_are_neither_certain_nor_all_equal(sample):
    answers = answers_of_text(sample.text)
    assert answers
    assert any(0.0 < p < 1.0 for p in answers.values())


def test_claims_hold_where_nobody_is_worse_off():
    found = {
        claim.claim.split(":")[0]: claim for claim in claims([measured(), measured(family="HMM", size=20, over=True)])
    }
    assert all(claim.met for claim in found.values())
    assert found["whole process"].value == pytest.approx(0.3 - 1.2 * 0.1 - 0.25)
    assert found["what was faster than stock stays so"].value == pytest.approx(0.04 / LIMIT)


@pytest.mark.parametrize(
    ("worse", "claim"), [({"mine": 0.4}, "whole process"), ({"answer": 0.5 + 1e-8}, "largest difference")]
)
def test_claims_fail_where_they_should(worse, claim):
    failed = [
        one.claim for one in claims([measured(family="HMM", size=20, over=True), measured(**worse)]) if not one.met
    ]
    assert [one.startswith(claim) for one in failed] == [True]


def test_a_program_that_we_do_not_answer_is_told():
    one = measured(family="HMM", size=20)
    silent = replace(one, runs={**one.runs, "plogic": StockRun("plogic", why="> 60")})
    assert "programs answered" in [claim.claim for claim in claims([silent]) if not claim.met]


def test_the_document_has_rows_and_claims(monkeypatch):
    monkeypatch.setattr(bench, "samples", lambda _seed, quick: [Sample("HMM", 20 + quick, "0.3::a. query(a).")])
    said = []
    text, _ = bench.run(seed=0, limit=20.0, quick=True, as_json=True, say=said.append)
    document = json.loads(text)
    assert document["bench"] == "programs"
    assert document["rows"][0]["difference"] <= 1e-9
    assert {"sdd process", "plogic process", "sdd", "ddnnf", "plogic"} <= document["rows"][0].keys()
    assert [claim["bar"] for claim in document["claims"]] == [">= 1", "<= 0", "<= 1e-09", "<= 1"]
    assert len(said) == 1
