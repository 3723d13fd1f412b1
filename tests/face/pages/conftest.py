"""The shipped towers and a learnt type as knowledge bases."""

from __future__ import annotations

import pytest
from made_types import write_learnt

from kb.files.read import read_kb
from kb.files.shipped import shipped


@pytest.fixture(scope="session")
def tower_kb():
    return read_kb(shipped("towers"))


@pytest.fixture(scope="session")
def learnt_kb(tmp_path_factory):
    return read_kb(write_learnt(tmp_path_factory.mktemp("learnt")))
