"""``make fuzz``: a short run of every kind, what was found before, and that what must not happen is seen."""

from __future__ import annotations

import json
import os
import warnings
from itertools import islice
from random import Random
from typing import TYPE_CHECKING

import pytest

from benchmarks.fuzz import bench
from benchmarks.fuzz.bench import Plan, attack, kept
from benchmarks.fuzz.console import commands, fault_of
from benchmarks.fuzz.kinds import Kind, kinds
from benchmarks.fuzz.mutators import as_bytes
from benchmarks.fuzz.shaped import change
from benchmarks.fuzz.worker import inputs, outcome
from geometry.json_checks import check_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

KINDS = kinds()
SHORT = 12
"""Inputs of each kind beside the good ones and those that were found before."""


@pytest.mark.parametrize("name", KINDS)
def test_a_short_run_of_every_kind(name, tmp_path):
    kind = KINDS[name]
    kind.beside(tmp_path)
    path = tmp_path / kind.file
    path.parent.mkdir(parents=True, exist_ok=True)
    good, before = list(kind.seeds())[:8], kept(name)
    tried = [*good, *before, *islice(inputs(kind, 0, 1, good, SHORT), SHORT)]
    faults = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for data in tried:
            path.write_bytes(data)
            faults.append(outcome(kind, path, data)[1])
    assert faults == [None] * (len(good) + len(before) + SHORT)


def test_the_same_seed_makes_the_same_inputs():
    kind = KINDS["gamma"]
    first, again = (list(inputs(kind, 3, 2, kind.seeds(), 20)) for _ in range(2))
    assert first == again
    assert len(set(first)) > 10


def _breaks(path: Path) -> None:
    first = path.read_bytes()[:1]
    if first == b"e":
        raise ZeroDivisionError("ours")
    if first == b"d":
        os._exit(1)
    while first == b"h":
        pass


def made(*seeds: bytes) -> Sequence[Kind]:
    """A kind whose reader breaks by the first letter of what it reads."""
    return [Kind("made", as_bytes, lambda: seeds, "x", _breaks)]


def test_what_must_not_happen_is_found_kept_and_told(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "SLOW", -0.8)  # and a second
    told: list[str] = []
    (tally,) = attack(made(b"fine", b"error", b"dies", b"hangs"), Plan(4, 60.0, 0, 1, tmp_path), told.append)
    assert sorted(fault.what for fault in tally.faults.values()) == [
        "ZeroDivisionError: ours", "more than -0.8 processor seconds", "the process died",
    ]  # fmt: skip
    assert {path.read_bytes() for path in (tmp_path / "made").iterdir()} == {b"error", b"dies", b"hangs"}
    assert len([line for line in told if str(tmp_path) in line]) == 3
    assert tally.tried == 4
    assert not bench.claims([tally])[0].met


@pytest.mark.parametrize(
    ("status", "said", "printed", "why"),
    [
        (0, "", "P = 0.5\n", None),
        (1, "plogic: x.json: is no JSON\n", "", None),
        (-9, "", "", "ended with -9"),
        (1, "Traceback (most recent call last):\n", "", "said Traceback"),
        (1, "plogic: internal error: KeyError\n", "", "said plogic: internal error"),
        (0, "", "name \x1b[2J\n", "printed '\\x1b'"),
        (1, "a\n" * 200, "", "wrote 200 lines"),
        (1, "a" * 5000, "", "wrote a line of 5000"),
    ],
)
def test_what_is_wrong_with_a_run(tmp_path, status, said, printed, why):
    (tmp_path / ".err").write_text(said)
    (tmp_path / ".out").write_text(printed)
    found = fault_of(status, 0.1, 1 << 20, tmp_path)
    assert (found is None) if why is None else (found is not None and found.startswith(why))


def test_every_kind_is_read_by_some_command():
    read = {command.kind for command in commands()}
    assert set(KINDS) - read == {"camera-opencv-json", "cloud", "points", "points-csv"}


@pytest.mark.parametrize("name", ["gamma", "poses", "stereo", "truth", "panorama", "interpretation-query"])
def test_changes_within_a_shape_mostly_keep_it(name):
    kind = KINDS[name]
    shape = kind.mutate.shape()
    kept, texts = 0, set[str]()
    for seed in range(100):
        tree, rng = json.loads(kind.seeds()[0]), Random(seed)  # noqa: S311 - no secret
        for _ in range(3):
            change(tree, shape, rng)
        kept += not check_of(shape)(tree)
        texts.add(json.dumps(tree))
    assert kept >= 90
    assert len(texts) >= 90
