"""Inputs that are led by the code that they reach: what is told of them, and who goes on from them."""

from __future__ import annotations

import json
from base64 import b64encode
from importlib.util import find_spec

import pytest
from click.testing import CliRunner

from benchmarks.fuzz import bench, guided
from benchmarks.fuzz.bench import REACHED, Plan, attack, kept
from benchmarks.fuzz.guided import begun, judge
from benchmarks.fuzz.guided_child import compiled, mutator, reader
from benchmarks.fuzz.kinds import Kind, kinds
from benchmarks.fuzz.mutators import as_bytes


def _breaks(path):
    if path.read_bytes() == b"breaks":
        raise ZeroDivisionError("ours")


MADE = Kind("made", as_bytes, lambda: [b"fine"], "x", _breaks)


def begin(tmp_path, count=5):
    return begun(MADE, Plan(count, 60.0, 1, 1, tmp_path / "out"), tmp_path / "work", lambda _: None)


def test_every_input_is_told_and_what_must_not_happen_is_kept(tmp_path):
    told: list[bytes] = []
    reading = reader(MADE, tmp_path / "x", told.append)
    for data in (b"fine", b"breaks", b"good"):
        reading(data)
    one = begin(tmp_path)
    for line in told:
        one.told(line.removesuffix(b"\n"))
    assert (one.tally.tried, len(one.outcomes)) == (3, 1)
    (fault,) = one.tally.faults.values()
    assert (fault.what, fault.data) == ("ZeroDivisionError: ours", b"breaks")
    assert [path.read_bytes() for path in (tmp_path / "out" / "made").iterdir()] == [b"breaks"]
    assert json.loads(told[1])["data"] == b64encode(b"breaks").decode()


def test_what_an_input_reached_is_read_from_what_libfuzzer_says(tmp_path):
    one = begin(tmp_path)
    one.covered("#2\tINITED cov: 47 ft: 47 corp: 1/1b\n#30\tNEW    cov: 104 ft: 104 corp: 3/10b lim: 8\n")
    one.covered("#2\tINITED cov: 90 ft: 47 corp: 1/1b\n#300\tDONE   cov: 120 ft: 104 corp: 3/10b lim: 8\n")
    assert (one.began, one.reached) == (47, 120)


def test_what_ends_a_process_is_a_fault_only_where_nobody_watches(tmp_path):
    one = begin(tmp_path)
    one.suspects += [b"slow only there", b"breaks"]
    judge(one, Plan(5, 60.0, 1, 1, tmp_path / "out"), lambda _: None)
    assert [fault.data for fault in one.tally.faults.values()] == [b"breaks"]


def test_changes_keep_the_structure_and_are_those_of_their_seed():
    kind = kinds()["gamma"]
    change = mutator(kind, lambda *_: b"own")
    made = [change(kind.seeds()[0], 300, seed) for seed in range(160)]
    assert made == [change(kind.seeds()[0], 300, seed) for seed in range(160)]
    assert 2 <= made.count(b"own") <= 30
    assert len(set(made)) > 80
    assert max(map(len, made)) <= 300


def test_the_plain_bench_goes_on_from_what_reached_far(tmp_path):
    reached = tmp_path / REACHED / "made"
    reached.mkdir(parents=True)
    (reached / "one").write_bytes(b"breaks")
    (tally,) = attack([MADE], Plan(2, 60.0, 0, 1, tmp_path), lambda _: None)
    assert kept("made", tmp_path / REACHED) == [b"breaks"]
    assert [fault.data for fault in tally.faults.values()] == [b"breaks"]


def test_what_numba_compiles_is_not_watched():
    assert "sensing.pixels.loops" in compiled()
    assert "sensing.files.images" not in compiled()


def test_without_atheris_a_line_says_so(monkeypatch):
    monkeypatch.setattr(guided, "find_spec", lambda _: None)
    done = CliRunner().invoke(guided.main, [])
    assert done.exit_code == 0
    assert done.output.startswith("not led by the code that is reached: atheris is not installed")


@pytest.mark.skipif(find_spec("atheris") is None, reason="atheris is not installed")
def test_a_short_run(tmp_path):
    done = CliRunner().invoke(guided.main, ["--count", "300", "--kinds", "stereo", "-o", str(tmp_path), "--json"])
    assert done.exit_code == 0, done.output
    (row,) = json.loads(done.output.splitlines()[-1])["rows"]
    assert row["reached"] > row["began"] > 0
    assert len(kept("stereo", tmp_path / bench.REACHED)) == row["kept"] > 0
