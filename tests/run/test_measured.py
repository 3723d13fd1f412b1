"""The measures of one interpretation side by side, each against its own definition."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from synthetic import belief_at, cycle_of, data, one_before_the_other, perceiver, scene, towers

from cli import cli
from plogic.cycle.delta import Options, delta_of
from plogic.facts.interpretation import text_of
from plogic.measures.distinctiveness import distinctiveness_over_delta
from plogic.run.document import document_of
from plogic.run.measured import dv_over_instances, measured
from plogic.scene.worlds.ranked_worlds import ranked_worlds


@pytest.fixture(scope="module")
def document():
    """Two towers, one before the other, and a rival of the one behind."""
    rng = np.random.default_rng(7400)
    shot = scene(rng, one_before_the_other(rng))
    cycle = cycle_of(shot.gamma)
    cycle = replace(cycle, considered=(belief_at("t1", shot.poses["t2"], data(shot), "rival"),))
    delta = delta_of(cycle, data(shot), towers(), perceiver().dv, Options())
    ranking = ranked_worlds(delta.situation, 100)
    return document_of(towers(), shot.gamma, delta, cycle.rejected, cycle.trace.document(), ranking, None)


def test_ev_is_what_the_document_says(document):
    told = {h["id"]: h for h in document["hypotheses"]}
    rows = measured(document)[0]
    assert [row.status for row in rows] == ["accepted", "accepted", "rival"]
    for row in rows:
        assert row.ev == pytest.approx(told[row.id]["ev"], abs=1e-9)
    for row in rows[:2]:
        assert row.ev_to_B == pytest.approx(told[row.id]["ev_reconsidered"], abs=1e-9)


def test_the_hidden_one_gains_by_what_hides_it_and_the_modes_differ(document):
    behind = max(measured(document)[0][:2], key=lambda row: row.ev_to_B - row.ev)
    assert behind.ev_to_B > behind.ev_drop > behind.ev


def test_shanahans_values_of_rivals_sum_to_one_and_put_the_right_one_first(document):
    rows = {row.id: row for row in measured(document)[0]}
    (pair,) = [fact["args"] for fact in document["facts"] if fact["fact"] == "rival"]
    assert sum(rows[name].shanahan for name in pair) == pytest.approx(1.0)
    assert rows[pair[0]].shanahan > rows[pair[1]].shanahan
    (alone,) = [row.shanahan for name, row in rows.items() if name not in pair]
    assert alone == 1.0


def test_the_posterior_is_that_of_the_other_reading(document):
    rows = measured(document)[0]
    assert rows[0].posterior > 0.99
    assert rows[2].posterior < 0.01
    assert measured({**document, "reading": "posterior"})[0] == rows


def test_dv_is_over_types_and_over_instances(document):
    kinds = {kind.name: kind for kind in towers().types}
    accepted = [kinds[h["type"]] for h in document["hypotheses"] if h["status"] == "accepted"]
    over = distinctiveness_over_delta(accepted, towers().types)
    features = measured(document)[1]
    assert {f.type: f.over_types for f in features} == document["measures"]["dv"]
    assert {f.type: f.over_instances for f in features} == pytest.approx({f.type: over[f.type] for f in features})


def test_without_an_instance_dv_is_that_over_types():
    assert dv_over_instances([], {"apex": 0.9}) == {"apex": 0.9}


def test_what_an_older_document_lacks_is_left_open(document):
    rows = measured({key: value for key, value in document.items() if key != "sensing"})[0]
    assert [row.shanahan for row in rows] == [None] * 3


def test_the_command_prints_both_tables_and_one_document(document, tmp_path):
    path = tmp_path / "i.json"
    path.write_text(text_of(document))
    told = json.loads(CliRunner().invoke(cli, ["measures", str(path), "--json"]).output)
    assert told["format"] == "measures/1"
    assert [row["id"] for row in told["hypotheses"]] == ["h1", "h2", "h3"]
    shown = CliRunner().invoke(cli, ["measures", str(path)]).output
    assert "Shanahan" in shown
    assert "dv over instances in Δ" in shown
