"""The shares of those that stand by chance that ``benchmarks/planes.py`` prints are those that were drawn."""

import numpy as np
import pytest

from benchmarks.planes import shares_of


@pytest.mark.parametrize("shares", [(0.4, 0.2), (0.03, 0.05), (0.0, 0.0)])
def test_the_likeliest_shares_are_those_that_were_drawn(shares):
    """Tilt and height, normal where it stands, the tilt alone where it is level; uniform over 40 deviations else."""
    rng, many, wide = np.random.default_rng(0), 20_000, 40.0
    kind = rng.choice(3, many, p=[1.0 - sum(shares), *shares])
    off = np.where((kind[:, None] == [1, 1]) | (kind[:, None] == [2, 0]), rng.normal(size=(many, 2)), 0.0)
    free = np.column_stack([kind == 0, kind != 1])
    off = np.where(free, rng.uniform(-wide / 2, wide / 2, (many, 2)), off)
    likelier = wide * np.exp(-0.5 * off**2) / np.sqrt(2.0 * np.pi)
    rows = [(float(tilt * height), float(tilt)) for tilt, height in likelier]
    assert shares_of(rows) == pytest.approx(np.array(shares), abs=0.01)
