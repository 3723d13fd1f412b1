"""A gate of hundreds of ways, as ``findall`` makes them, is counted right."""

from math import comb

import pytest

from plogic.logic.served.engine import Text, run


def test_findall_over_nine_choices_counts_them():
    program = "0.3::h(X) :- between(1,9,X). n(K) :- findall(X,h(X),L), length(L,K). query(n(_))."
    (answers,) = run([Text(program, "program.pl")])
    found = {answer.goal: answer.probability for answer in answers}
    assert found == pytest.approx({f"n({k})": comb(9, k) * 0.3**k * 0.7 ** (9 - k) for k in range(10)}, abs=1e-12)
