"""A gate of hundreds of ways, as ``findall`` makes them, is counted right, and no tables are planned for it."""

from math import comb

import pytest

from plogic.logic.answers import by_tables
from plogic.logic.served.program_child import serve

PROGRAM = "0.3::h(X) :- between(1,9,X). n(K) :- findall(X,h(X),L), length(L,K). query(n(_))."


def test_findall_over_nine_choices_counts_them(monkeypatch):
    def planned(*_):
        raise AssertionError

    monkeypatch.setattr(by_tables, "tables_of", planned)
    texts = [{"text": PROGRAM, "file": "program.pl"}]
    (answers,) = serve({"texts": texts, "goals": [], "given": [], "names": None})["answers"]
    wanted = {f"n({k})": comb(9, k) * 0.3**k * 0.7 ** (9 - k) for k in range(10)}
    assert dict(answers) == pytest.approx(wanted, abs=1e-12)
