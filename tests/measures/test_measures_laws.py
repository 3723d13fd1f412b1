"""Laws of the measures (§5), by property-based tests, with brute force as the oracle of rank."""

from collections import Counter
from itertools import combinations, permutations
from math import isclose, log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from plogic.measures.distinctiveness import (
    best_substitution,
    compatible,
    distinctiveness,
    is_legal,
    probability_of_distinctiveness,
    rank,
    valuation,
)
from plogic.measures.explanatory import (
    Cells,
    case_of,
    explanatory_value,
    probability_of_ev,
    reconsidered,
    shanahan_values,
    tally,
)

COUNTS = st.dictionaries(st.sampled_from(["apex", "corner", "patch", "edge"]), st.integers(1, 200), min_size=1)
CELLS = st.builds(Cells, *[st.integers(0, 9)] * 4)
SUPPORT = st.dictionaries(st.sampled_from(["apex", "corner", "patch"]), CELLS, min_size=1)
DV = {"apex": 0.9, "corner": 0.6, "patch": 0.2}


@given(COUNTS)
def test_shares_sum_to_one_and_dv_is_their_complement(counts):
    shares = probability_of_distinctiveness(counts)
    assert isclose(sum(shares.values()), 1.0)
    assert distinctiveness(counts) == {name: 1.0 - share for name, share in shares.items()}


def test_one_feature_type_in_all_of_sigma_is_not_distinctive_and_its_valuation_is_zero():
    assert distinctiveness({"patch": 7}) == {"patch": 0.0}
    assert rank(np.zeros(3), [["patch"]] * 3, {"patch": 5}) == 0.0
    assert explanatory_value({"patch": Cells(3, 0, 0, 0)}, {"patch": 0.0}) is None


@pytest.mark.parametrize(
    ("expected", "detected", "case"), [(True, True, "A"), (True, False, "C"), (False, False, "B"), (False, True, "D")]
)
def test_the_four_cases(expected, detected, case):
    assert case_of(expected=expected, detected=detected) == case


@given(SUPPORT)
def test_ev_lies_between_minus_one_and_one_and_changes_sign_with_detection(support):
    ev = explanatory_value(support, DV)
    flipped = {name: Cells(A=c.C, C=c.A, B=c.D, D=c.B) for name, c in support.items()}
    if ev is None:
        assert explanatory_value(flipped, DV) is None
    else:
        assert -1.0 <= ev <= 1.0
        assert isclose(explanatory_value(flipped, DV), -ev, abs_tol=1e-12)
        assert 0.0 <= probability_of_ev(ev) <= 1.0


@given(SUPPORT, st.integers(2, 5))
def test_duplicating_every_feature_leaves_ev_alone(support, times):
    many = {name: Cells(c.A * times, c.C * times, c.B * times, c.D * times) for name, c in support.items()}
    one, more = explanatory_value(support, DV), explanatory_value(many, DV)
    assert one == more or isclose(one, more, abs_tol=1e-12)


@given(SUPPORT, st.data())
def test_an_explained_miss_never_lowers_ev_and_to_b_is_at_least_drop(support, data):
    explained = {name: data.draw(st.integers(0, c.C)) for name, c in support.items()}
    before = explanatory_value(support, DV)
    drop = explanatory_value(reconsidered(support, explained, "drop"), DV)
    to_b = explanatory_value(reconsidered(support, explained, "to_B"), DV)
    if before is not None and drop is not None:
        assert before - 1e-12 <= drop <= to_b + 1e-12


@given(
    st.lists(
        st.sampled_from([("apex", "A"), ("patch", "C"), ("patch", "D"), ("corner", "B"), ("corner", "A")]), max_size=20
    )
)
def test_tally_counts_every_case_once(pairs):
    names = ("apex", "corner", "patch")
    kind = np.array([names.index(name) for name, _ in pairs], np.intp)
    expected, detected = (np.array([case in letters for _, case in pairs], bool) for letters in ("AC", "AD"))
    counts = {
        name: Counter(case for other, case in pairs if other == name) for name in sorted({name for name, _ in pairs})
    }
    support = tally(names, kind, expected, detected)
    assert list(support) == list(counts)
    assert support == {name: Cells(**count) for name, count in counts.items()}


def of_matrix(allowed):
    """The ways of each feature (F, A), every appearance being of a kind of its own."""
    return [np.flatnonzero(row).tolist() for row in allowed], dict.fromkeys(range(allowed.shape[1]), 1)


MATRICES = st.integers(1, 4).flatmap(
    lambda f: st.integers(1, 4).flatmap(
        lambda a: st.tuples(
            st.lists(st.sampled_from([0.1, 0.15, 0.86, 0.99]), min_size=f, max_size=f),
            st.lists(st.lists(st.booleans(), min_size=a, max_size=a), min_size=f, max_size=f),
        )
    )
)


def brute_force(weights, allowed):
    features, data = range(len(weights)), range(allowed.shape[1])
    best = 0.0
    for size in range(min(allowed.shape) + 1):
        for chosen in combinations(features, size):
            for taken in permutations(data, size):
                substitution = dict(zip(chosen, taken, strict=True))
                if is_legal(substitution, allowed):
                    best = max(best, valuation(weights, substitution))
    return best


@given(MATRICES)
def test_rank_is_the_best_over_all_legal_substitutions(matrix):
    weights, allowed = np.array(matrix[0]), np.array(matrix[1], dtype=bool)
    substitution = best_substitution(weights, *of_matrix(allowed))
    assert is_legal(substitution, allowed)
    assert isclose(rank(weights, *of_matrix(allowed)), brute_force(weights, allowed), abs_tol=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(1, 25), st.integers(1, 25), st.floats(0.05, 0.9))
def test_rank_is_that_of_scipys_assignment(seed, features, data, share):
    rng = np.random.default_rng(seed)
    weights, allowed = rng.choice([0.0, 0.3, 0.5, 0.97], features), rng.random((features, data)) < share
    rows, columns = linear_sum_assignment(np.where(allowed, weights[:, None], 0.0), maximize=True)
    best = sum(weights[f] for f, a in zip(rows, columns, strict=True) if allowed[f, a])
    assert isclose(rank(weights, *of_matrix(allowed)) * weights.sum(), best, abs_tol=1e-9)


@given(
    st.lists(st.tuples(st.sampled_from([0.2, 0.5, 0.9]), st.sets(st.sampled_from("abcd"))), min_size=1, max_size=12),
    st.dictionaries(st.sampled_from("abcd"), st.integers(0, 5)),
)
def test_counting_looks_gives_the_same_rank(features, there):
    weights, looks = np.array([weight for weight, _ in features]), [sorted(some) for _, some in features]
    names = [name for name, count in there.items() for _ in range(count)]
    allowed = compatible([frozenset(some) for some in looks], names)
    assert isclose(rank(weights, looks, there), rank(weights, *of_matrix(allowed)), abs_tol=1e-12)


def test_an_appearance_type_may_serve_several_feature_types():
    allowed = compatible(
        [frozenset({"l_junction", "arrow_junction"}), frozenset({"l_junction"})], ["l_junction", "patch"]
    )
    assert allowed.tolist() == [[True, False], [True, False]]
    assert rank(np.array([0.9, 0.6]), *of_matrix(allowed)) == pytest.approx(0.9 / 1.5)


def test_in_clutter_rank_saturates():
    """A thousand random appearances give an absent type of a hundred features a rank near 1 (§5.3).

    Rank is attention, no verdict.
    """
    rng = np.random.default_rng(0)
    names = [f"t{i}" for i in range(30)]
    features = [frozenset({names[i]}) for i in rng.integers(0, 30, 100)]
    appearances = [names[i] for i in rng.integers(0, 30, 1000)]
    assert rank(np.full(100, 0.97), features, Counter(appearances)) > 0.99


PRIORS = st.lists(st.floats(0.01, 1.0), min_size=1, max_size=6)


@given(st.dictionaries(st.sampled_from(["d1", "d2", "d3"]), PRIORS, min_size=1))
def test_shanahans_values_sum_to_one(rivals):
    assert isclose(sum(shanahan_values(rivals).values()), 1.0)


@given(PRIORS, PRIORS, PRIORS)
def test_adding_a_rival_lowers_shanahans_value(one, two, three):
    before = shanahan_values({"d1": one, "d2": two})
    after = shanahan_values({"d1": one, "d2": two, "d3": three})
    assert after["d1"] < before["d1"]


@given(PRIORS, PRIORS, st.integers(2, 6))
def test_duplicating_every_feature_multiplies_shanahans_log_odds(one, two, times):
    def odds(values):
        return log(values["d1"]) - log(values["d2"])

    before = odds(shanahan_values({"d1": one, "d2": two}))
    after = odds(shanahan_values({"d1": one * times, "d2": two * times}))
    assert isclose(after, times * before, rel_tol=1e-6, abs_tol=1e-6)


def test_thousands_of_abducibles_do_not_underflow():
    values = shanahan_values({"d1": [0.1] * 5000, "d2": [0.1] * 5001})
    assert isclose(values["d1"] / values["d2"], 10.0, rel_tol=1e-6)


def test_a_prior_outside_its_range_is_refused():
    with pytest.raises(ValueError, match="prior"):
        shanahan_values({"d1": [0.0]})
