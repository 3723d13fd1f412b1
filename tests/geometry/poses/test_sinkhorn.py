import numpy as np
import pytest

from geometry.errors import GeometryError
from geometry.poses.sinkhorn import Pairs, pairs_of, sinkhorn, sums_per_model

SLACK = 0.05


def some(seed, count=3, models=7, images=11, share=0.6):
    """Random affinities (K, P) of random pairs, over several orders of magnitude."""
    rng = np.random.default_rng(seed)
    pairs = pairs_of(rng.random((models, images)) < share)
    return np.exp(rng.uniform(-12, 2, (count, len(pairs)))), pairs, rng


def dense(values, pairs):
    """The matrix (N, M) of `values` (P,), 0 where no pair is."""
    matrix = np.zeros(pairs.shape)
    matrix[pairs.model, pairs.image] = values
    return matrix


def plainly(matrix, slack, rounds):
    """The paper's loop: the bordered matrix, its rows and then its columns divided by their sums, slack excepted."""
    m = np.full((matrix.shape[0] + 1, matrix.shape[1] + 1), slack)
    m[:-1, :-1] = matrix
    for _ in range(rounds):
        for i in range(len(m) - 1):
            m[i] /= m[i].sum()
        for j in range(m.shape[1] - 1):
            m[:, j] /= m[:, j].sum()
    return m


@pytest.mark.parametrize("seed", range(5))
def test_rows_and_columns_sum_to_one_with_their_slack(seed):
    affinities, pairs, _ = some(seed)
    m = sinkhorn(affinities, pairs, SLACK, rounds=1000)
    assert len(affinities) > 0
    for k in range(len(affinities)):
        weights = dense(m.weights[k], pairs)
        assert np.abs(weights.sum(axis=1) + m.model_slack[k] - 1).max() <= 1.001e-3
        assert np.abs(weights.sum(axis=0) + m.image_slack[k] - 1).max() < 1e-12


@pytest.mark.parametrize("rounds", [1, 4, 300])
@pytest.mark.parametrize("seed", range(3))
def test_as_many_rounds_give_the_same_as_the_plain_loop(seed, rounds):
    affinities, pairs, _ = some(seed)
    m = sinkhorn(affinities, pairs, SLACK, tolerance=0.0, rounds=rounds)
    assert len(affinities) > 0
    for k in range(len(affinities)):
        oracle = plainly(dense(affinities[k], pairs), SLACK, rounds)
        assert np.abs(oracle[-1, :-1] - m.image_slack[k]).max() < 1e-9
        assert np.abs(oracle[:-1, :-1] - dense(m.weights[k], pairs)).max() < 1e-9


def test_where_it_starts_changes_nothing_that_is_reached():
    affinities, pairs, rng = some(7)
    cold = sinkhorn(affinities, pairs, SLACK, tolerance=1e-12, rounds=5000)
    warm = sinkhorn(affinities, pairs, SLACK, rng.uniform(0.01, 9, (3, 11)), tolerance=1e-12, rounds=5000)
    np.testing.assert_allclose(cold.weights, warm.weights, atol=1e-10)
    again = sinkhorn(affinities, pairs, SLACK, cold.scale, rounds=1)
    np.testing.assert_allclose(cold.weights, again.weights, atol=1e-10)


def test_model_and_image_points_change_places():
    affinities, pairs, _ = some(8)
    order = np.lexsort((pairs.model, pairs.image))
    mirrored = Pairs(pairs.image[order], pairs.model[order], pairs.shape[::-1])
    m = sinkhorn(affinities, pairs, SLACK, tolerance=1e-12, rounds=5000)
    n = sinkhorn(affinities[:, order], mirrored, SLACK, tolerance=1e-12, rounds=5000)
    np.testing.assert_allclose(m.weights[:, order], n.weights, atol=1e-10)
    np.testing.assert_allclose(m.model_slack, n.image_slack, atol=1e-10)


def test_each_start_ends_as_if_it_were_alone():
    affinities, pairs, _ = some(9, count=5)
    together = sinkhorn(affinities, pairs, SLACK)
    alone = [sinkhorn(affinities[k : k + 1], pairs, SLACK) for k in range(5)]
    assert np.array_equal(together.weights, np.concatenate([m.weights for m in alone]))
    assert np.array_equal(together.scale, np.concatenate([m.scale for m in alone]))


def test_a_point_without_a_pair_goes_to_slack_and_a_lone_pair_has_its_closed_form():
    allowed = np.zeros((3, 4), dtype=bool)
    allowed[1, 2] = True
    m = sinkhorn(np.array([[0.7]]), pairs_of(allowed), SLACK, tolerance=1e-12, rounds=5000)
    r = (-SLACK + np.sqrt(SLACK**2 + 4 * 0.7)) / (2 * 0.7)  # r (k r + s) = 1, for row and column alike
    assert m.weights[0, 0] == pytest.approx(0.7 * r * r)
    np.testing.assert_allclose(m.model_slack[0], [1, SLACK * r, 1])
    np.testing.assert_allclose(m.image_slack[0], [1, 1, SLACK * r, 1])


def test_weights_and_sums_of_no_pairs_at_all():
    none = pairs_of(np.zeros((2, 3), dtype=bool))
    m = sinkhorn(np.zeros((4, 0)), none, SLACK)
    assert np.all(m.model_slack == 1)
    assert np.all(m.image_slack == 1)
    assert np.array_equal(sums_per_model(m.weights, none, np.ones((3, 2))), np.zeros((4, 2, 2)))


def test_sums_per_model_are_those_of_the_matrix():
    affinities, pairs, rng = some(10)
    values = rng.normal(size=(11, 3))
    expected = np.stack([dense(row, pairs) @ values for row in affinities])
    np.testing.assert_allclose(sums_per_model(affinities, pairs, values), expected, rtol=1e-12)


def test_allowed_must_be_a_matrix():
    with pytest.raises(GeometryError, match="allowed must have the shape"):
        pairs_of([True, False])
