"""``plogic bench towers``: the claims are computed from outcomes, never stated; a few real scenes run end to end."""

import json

import pytest

from benchmarks.shared.claims import Claim, report
from benchmarks.towers import bench as towers
from benchmarks.towers.bench import PLAN, Outcome, _claims


def outcome(kind="hiding", *, posed=(True, True), countable=True, reported=2, relation=True, seconds=0.5):
    return Outcome(kind, 0, countable, tuple(True for _ in posed), posed, reported, 0, relation, {"search": seconds})


def values(outcomes):
    return {claim.claim.split(":")[0]: (claim.value, claim.met) for claim in _claims(outcomes)}


def test_a_claim_is_met_only_by_its_value():
    assert Claim("share", ">=", 0.95, 0.95).met
    assert not Claim("share", ">=", 0.95, 0.9499).met
    assert not Claim("false reports", "<=", 0, 1).met


def test_one_wrong_pose_in_ten_scenes_fails_the_claim():
    good = [outcome() for _ in range(9)]
    assert all(met for _, met in values(good).values())
    found = values([*good, outcome(posed=(True, False))])
    assert found["scenes with both towers at least half visible"] == (pytest.approx(0.9), False)


def test_what_is_less_than_half_visible_does_not_count():
    hidden = outcome(posed=(True, False), countable=False, relation=False)
    assert values([outcome(), hidden])["scenes with both towers at least half visible"] == (1.0, True)


def test_a_tower_reported_among_decoys_fails_the_claim():
    decoys = outcome("decoys", posed=(), countable=False, reported=1, relation=None)
    assert values([outcome(), decoys])["towers reported in scenes that have none"] == (1, False)


def test_the_plan_is_the_issues():
    kinds = [PLAN[i % len(PLAN)] for i in range(120)]
    assert kinds.count("hiding") == 60
    assert kinds.count("decoys") >= 20
    assert kinds.count("single") > 0


def test_the_json_document_is_the_contracts():
    text, met = report("towers", [{"row": "hiding", "scenes": 1}], [Claim("share", ">=", 0.95, 0.5)], as_json=True)
    document = json.loads(text)
    assert not met
    assert document["bench"] == "towers"
    assert document["claims"] == [{"claim": "share", "bar": ">= 0.95", "value": 0.5, "met": False}]


def test_three_real_scenes_end_to_end():
    """Scenes of seeds that no figure is quoted from: found without any ground truth, then judged by it."""
    said = []
    text, _ = towers.run(3, 77, as_json=True, say=said.append)
    document = json.loads(text)
    assert len(said) == 3
    assert {row["row"] for row in document["rows"]} >= {"hiding", "beside", "stage detect", "stage search"}
    assert sum(row["towers"] for row in document["rows"] if row["row"] in {"hiding", "beside"}) == 6
    assert sum(row["found"] for row in document["rows"] if row["row"] in {"hiding", "beside"}) >= 5
