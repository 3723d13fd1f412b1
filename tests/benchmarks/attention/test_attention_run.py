"""``plogic bench attention`` end to end on few types and scenes."""

from __future__ import annotations

import json

from benchmarks.attention.bench import run


def test_a_real_run_tells_both_orders():
    said = []
    text, _ = run(seed=0, quick=True, as_json=True, say=said.append, scenes=2, types=20)
    document = json.loads(text)
    row = document["rows"][0]
    assert [row["types"] for row in document["rows"]] == [f"20, {looks} looks" for looks in (10, 30, 100)]
    assert (document["bench"], row["scenes"], row["there"]) == ("attention", 2, 6)
    assert row["found"] == row["reversed"] >= 5
    assert row["place"] <= row["by rank"]
    assert row["in half"] <= row["found"]
    assert len(said) == 6
    ratio, same, more = document["claims"]
    assert (same["value"], same["met"]) == (row["same"] / 2, row["same"] == 2)
    assert ratio["bar"] == "<= 0.6"
    assert more["value"] == row["in half"] - row["reversed in half"]


def test_learned_types_are_left_out_where_they_are_not_there():
    said = []
    text, _ = run(seed=0, quick=False, as_json=True, say=said.append, scenes=1, types=4, learn=lambda *_: None)
    assert not any("learned" in row["types"] for row in json.loads(text)["rows"])
