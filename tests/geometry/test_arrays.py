"""Sums and lengths over short last axes are numpy's."""

import numpy as np
import pytest

from geometry.arrays import lengths, summed


@pytest.mark.parametrize("shape", [(2,), (1, 3), (0, 2), (50, 3), (7, 11, 2), (5, 4, 7)])
def test_sums_and_lengths_are_numpys(shape):
    values = np.random.default_rng(1).normal(size=shape) * 10.0 ** np.arange(shape[-1])
    np.testing.assert_allclose(summed(values), values.sum(axis=-1), rtol=1e-15, atol=1e-12)
    np.testing.assert_allclose(lengths(values), np.linalg.norm(values, axis=-1), rtol=1e-15)
    turned = np.moveaxis(values, -1, 0).copy()
    np.testing.assert_allclose(summed(np.moveaxis(turned, 0, -1)), values.sum(axis=-1), rtol=1e-15, atol=1e-12)
