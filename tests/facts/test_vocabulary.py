"""The vocabulary of queries: names that programs can define, and that users find again."""

from __future__ import annotations

import pytest
from problog.engine import DefaultEngine

from plogic.facts.vocabulary import VOCABULARY
from plogic.logic.safety.atoms import SPELLINGS

BUILT_IN = frozenset(DefaultEngine().get_builtins())


@pytest.mark.parametrize("entry", VOCABULARY, ids=lambda entry: f"{entry.signature} {entry.reading}".strip())
def test_a_name_of_problog_is_not_defined_but_spelled_otherwise(entry):
    written = entry.usage.split("(")[0]
    assert entry.signature not in BUILT_IN, "name it otherwise, and add a row to SPELLINGS"
    assert SPELLINGS.get((written, entry.arity), written) == entry.name


def test_each_spelling_belongs_to_an_entry():
    assert set(SPELLINGS.values()) <= {entry.name for entry in VOCABULARY}
