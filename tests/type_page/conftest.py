"""The shipped towers and a learnt type, and one browser for all tests of the page."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), *(str(HERE.parent / folder) for folder in ("report", "kb", "commands"))]

from made_types import write_learnt  # noqa: E402 - found by the line above
from one_browser import chromium, flat_chromium  # noqa: E402 - as above

from kb.files.read import read_kb  # noqa: E402 - as above
from kb.files.shipped import shipped  # noqa: E402 - as above

__all__ = ["chromium", "flat_chromium", "learnt_kb", "tower_kb"]


@pytest.fixture(scope="session")
def tower_kb():
    return read_kb(shipped("towers"))


@pytest.fixture(scope="session")
def learnt_kb(tmp_path_factory):
    return read_kb(write_learnt(tmp_path_factory.mktemp("learnt")))
