"""The terminal's tables, printed."""

from __future__ import annotations

import io
import sys

import pytest
from in_process import told
from rich.console import Console

from plogic.face.shown import progress, tables
from plogic.face.shown.figures import chance, places, precise, signed


def printed(table):
    out = io.StringIO()
    Console(file=out, width=140, color_system=None).print(table)
    return out.getvalue()


def test_worlds_are_ranked_with_what_is_not_listed(towers):
    lines = printed(tables.worlds(towers)).splitlines()
    rows = [line.split() for line in lines if line.split() and line.split()[0] in {"1", "2", "3"}]
    assert [r[1] for r in rows] == ["0.968", "0.024", "0.007"]
    assert any("not listed" in line for line in lines)


def test_worlds_that_are_cut_off_count_as_not_listed(towers):
    assert "0.031..0.032" in printed(tables.worlds(towers, limit=1))


def test_measures_have_the_four_cases_and_ev(towers):
    text = printed(tables.measures(towers))
    row = next(line.split() for line in text.splitlines() if "pyramid tower h2" in line)
    support = towers["hypotheses"][1]["support"]["apex"]
    assert row[:4] == ["pyramid", "tower", "h2", "accepted"]
    assert row[6:10] == [str(support[c]) for c in tables.CELLS]
    assert f"{towers['hypotheses'][1]['ev_reconsidered']:+.2f}" in row


def test_answers_print_intervals_and_take_no_markup():
    rows = [
        {"goal": "present(h1)", "probability": 0.97, "interval": [0.97, 0.97]},
        {"goal": "[red]x", "probability": 0.2, "interval": [0.1, 0.3]},
    ]
    text = printed(tables.answers({"format": "answers/1", "answers": rows}))
    assert "0.970" in text
    assert "0.100..0.300" in text
    assert "[red]x" in text


@pytest.mark.parametrize(
    ("p", "text"), [(None, "–"), (0.0, "0"), (1.0, "1"), (1e-9, "<0.001"), (0.99999, ">0.999"), (0.5, "0.500")]
)
def test_what_is_almost_certain_does_not_read_as_certain(p, text):
    assert chance(p) == text


def test_digits_that_are_asked_for_hold_within_and_no_longer():
    with places(6):
        shown = [chance(p) for p in (0.0, 1.0, 0.12345678, 1e-9, 1 - 1e-9)]
        assert shown == ["0", "1", "0.123457", "<0.000001", ">0.999999"]
        assert (signed(0.5), precise(1 / 3, 4)) == ("+0.50000", "0.333333")
    assert (chance(0.12345678), signed(0.5), precise(1 / 3, 4)) == ("0.123", "+0.50", "0.3333")


def test_digits_of_a_command(tmp_path):
    program = tmp_path / "coin.pl"
    program.write_text("0.12345678::heads. query(heads). query(tails). tails :- fail.")
    line = next(line for line in told("query", program, "--digits", 7) if "heads" in line)
    assert line.split() == ["0.1234568", "heads"]
    assert next(line for line in told("query", program) if "heads" in line).split() == ["0.123", "heads"]
    assert "7.5" in "".join(told("query", program, "--digits", "7.5"))


def test_an_empty_interpretation_has_tables():
    assert "possible worlds" in printed(tables.worlds({}))
    assert "measures" in printed(tables.measures({"hypotheses": [{"id": "h1", "type": "t", "status": "rejected"}]}))


def test_progress_is_a_line_every_ten_seconds_without_a_terminal(monkeypatch):
    clock = iter([0.0, 5.0, 10.0, 10.0, 15.0, 20.5, 20.5])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    told_of = progress.Progress()
    for view in range(4):
        told_of.at(f"{view} views")
    told_of.end()
    assert sys.stderr.getvalue() == "1 views\n3 views\n"
