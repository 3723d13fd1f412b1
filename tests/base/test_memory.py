"""What a command and its children may take of memory, and how that is counted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from plogic.base import memory
from plogic.base.errors import InputError

ROOT = Path(__file__).parents[2]
GIB = 1 << 30


@pytest.mark.parametrize(
    ("there", "processors", "expected"), [(64 * GIB, 8, 12 * GIB), (4 * GIB, 8, 3 * GIB), (64 * GIB, None, 5 * GIB)]
)
def test_the_limit_grows_with_processors_and_leaves_some_of_what_there_is(there, processors, expected, monkeypatch):
    monkeypatch.setattr(memory, "whole", lambda: there)
    monkeypatch.setattr(os, "cpu_count", lambda: processors)
    assert memory.limit({}) == expected
    assert memory.limit({"PLOGIC_MEMORY": "100"}) == 100 << 20
    assert memory.limit({"PLOGIC_MEMORY": "0"}) == 0


def test_a_container_has_no_more_than_its_limit(monkeypatch, tmp_path):
    monkeypatch.setattr(memory, "CGROUP", tmp_path / "memory.max")
    machine = memory.whole()
    (tmp_path / "memory.max").write_text("max\n")
    assert memory.whole() == machine
    (tmp_path / "memory.max").write_text("1000000\n")
    assert memory.whole() == 1_000_000


def test_what_is_no_number_of_megabytes_is_refused():
    with pytest.raises(InputError, match="should be a number of MB"):
        memory.limit({"PLOGIC_MEMORY": "8G"})


COPIES = """
import os, time
from plogic.base import memory
from plogic.base.children import Copy
held = b"x" * (200 << 20)
alone = memory.taken(os.getpid(), 0)
copies = [Copy(time.sleep, 60) for _ in range(3)]
print(len(held), alone, memory.taken(os.getpid(), 0), memory.taken(os.getpid(), 1 << 40))
"""


def test_copies_count_what_they_share_once():
    run = subprocess.run([sys.executable, "-c", COPIES], cwd=ROOT, capture_output=True, text=True, check=True)
    held, alone, together, bound = map(int, run.stdout.split())
    assert held < alone < held + (50 << 20)
    assert together < alone + (50 << 20)
    assert bound > 4 * held
