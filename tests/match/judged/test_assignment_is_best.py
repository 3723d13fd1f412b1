"""The assignment of features to data is the best there is, however it is found."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from plogic.match.judged.expectation import _best_pairs


@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.integers(1, 8), st.floats(0.05, 1.0))
def test_pairs_have_the_sum_of_scipys_and_use_nothing_twice(seed, features, data, share):
    rng = np.random.default_rng(seed)
    gain = np.where(rng.random((features, data)) < share, rng.choice([0.5, 0.7, 0.7, 0.9, 1.0], (features, data)), 0.0)
    rows, columns = _best_pairs(gain)
    assert len(set(rows.tolist())) == len(rows) == len(set(columns.tolist()))
    best = gain[linear_sum_assignment(gain, maximize=True)].sum()
    assert abs(gain[rows, columns].sum() - best) < 1e-12
