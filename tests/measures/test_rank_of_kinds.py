"""rank of types whose features admit one appearance type each: counting finds what the matching finds."""

from collections import Counter
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plogic.measures.distinctiveness import kinds_of, rank, rank_of_kinds, valuation

KINDS = st.lists(st.sampled_from("abcd"), max_size=8)
WEIGHTS = st.sampled_from([0.0, 0.1, 0.25, 0.5, 0.5, 0.9, 1.0])


def counted(weights, types, there):
    return rank_of_kinds(weights, kinds_of(weights, types), Counter(there))


@given(st.lists(st.tuples(st.sampled_from("abcd"), WEIGHTS), max_size=8), KINDS)
def test_counting_is_the_best_matching(features, there):
    kinds, weights = [kind for kind, _ in features], np.array([weight for _, weight in features])
    expected = rank(weights, [[kind] for kind in kinds], Counter(there))
    assert counted(weights, kinds, there) == pytest.approx(expected, abs=1e-9)


@given(
    st.lists(st.tuples(st.sampled_from("ab"), WEIGHTS), min_size=1, max_size=4),
    st.lists(st.sampled_from("ab"), max_size=4),
)
def test_counting_is_the_best_of_all_substitutions(features, there):
    weights, best = np.array([weight for _, weight in features]), 0.0
    for count in range(min(len(features), len(there)) + 1):
        for some in combinations(range(len(features)), count):
            for data in permutations(range(len(there)), count):
                if all(features[f][0] == there[a] for f, a in zip(some, data, strict=True)):
                    best = max(best, valuation(weights, dict(zip(some, data, strict=True))))
    assert counted(weights, [kind for kind, _ in features], there) == pytest.approx(best)


def test_nothing_there_is_worth_nothing_and_everything_is_worth_one():
    weights = np.array([0.2, 0.7, 0.4])
    assert counted(weights, ["a", "b", "a"], []) == 0.0
    assert counted(weights, ["a", "b", "a"], ["a", "a", "b", "c"]) == pytest.approx(1.0)
    assert counted(weights, ["a", "b", "a"], ["a"]) == pytest.approx(0.4 / 1.3)
    assert counted(np.zeros(0), [], ["a"]) == 0.0
