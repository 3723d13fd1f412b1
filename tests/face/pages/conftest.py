"""The shipped towers and a learned type as knowledge bases."""

from __future__ import annotations

import pytest
from made_types import write_learned

from kb.files.folder import shipped
from kb.files.read import read_kb


@pytest.fixture(scope="session")
def tower_kb():
    return read_kb(shipped("towers"))


@pytest.fixture(scope="session")
def learned_kb(tmp_path_factory):
    return read_kb(write_learned(tmp_path_factory.mktemp("learned")))
