"""``plogic bench start``: what it counts, of scripts whose work is known, and what it claims."""

from __future__ import annotations

import pytest

from benchmarks.start.bench import ASIDE, COMMANDS, Side, _rows, claims, of_peer

SCRIPT = """#!/usr/bin/env python3
import json, sys, time
end = time.process_time() + {busy}
while time.process_time() < end:
    pass
if "--timings" in sys.argv:
    with open(sys.argv[sys.argv.index("--timings") + 1], "w") as file:
        json.dump({{"seconds": {{"search": {search}}}}}, file)
sys.exit({code})
"""


def side(folder, busy, *, search=0.0, code=0):
    folder.mkdir()
    script = folder / "plogic"
    script.write_text(SCRIPT.format(busy=busy, search=search, code=code), encoding="utf-8")
    script.chmod(0o755)
    return Side(script, folder)


def test_processor_seconds_of_each_side_and_what_the_search_takes_aside(tmp_path):
    sides = {"plogic": side(tmp_path / "a", 0.1), "peer": side(tmp_path / "b", 0.4, search=0.2)}
    told: list[str] = []
    whole, aside = _rows("perceive", sides, 1, told.append)
    assert [whole["command"], aside["command"]] == ["perceive", ASIDE]
    assert 0.1 <= whole["plogic"] < whole["peer"]
    assert whole["peer"] >= 0.4
    assert aside["plogic"] == whole["plogic"]
    assert aside["peer"] < whole["peer"]
    assert whole["numpy"] > 0.0
    assert whole["of peer's"] == pytest.approx(whole["plogic"] / whole["peer"], abs=0.01)
    assert len(told) == 1


def test_a_command_that_fails_ends_the_benchmark(tmp_path):
    with pytest.raises(RuntimeError, match="worlds"):
        _rows("worlds", {"plogic": side(tmp_path / "a", 0.0, code=1)}, 1, print)


def test_the_peer_is_not_led_to_our_own_code_nor_told_less_than_we(tmp_path):
    one = side(tmp_path / "a", 0.0)
    one.script.write_text("#!/bin/sh\nenv > told\n")
    Side(one.script, one.folder, of_peer({"PYTHONPATH": "/ours", "HOME": "/home", "PATH": "/bin:/usr/bin"})).run(())
    told = (one.folder / "told").read_text()
    assert "HOME=/home" in told
    assert "/ours" not in told


def test_claims_with_and_without_a_peer():
    alone = [{"command": name, "plogic": 0.1} for name in COMMANDS]
    assert [claim.met for claim in claims(alone)] == [True]
    beside = [{"command": name, "plogic": 0.4, "peer": 0.5, "of peer's": 0.8} for name in (*COMMANDS, ASIDE)]
    assert [claim.met for claim in claims(beside)] == [False, False, True, True]
