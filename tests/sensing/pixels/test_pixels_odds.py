"""What a fit tells: an outline and print together, and nothing of what is hidden."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from sensing.pixels.energy import FIRM, LEAST, NO_FIT, Fit

ENOUGH = 5.0
"""From which a learned type may be accepted by its pixels alone."""
NATS, SHARES = st.floats(-2.0, 2.0), st.floats(0.0, 1.0)


@settings(derandomize=True, deadline=None)
@given(st.floats(-1.0, 0.0), st.floats(-1.0, 0.0), st.floats(0.0, 2 * FIRM), st.floats(0.0, 1.0))
def test_print_without_an_outline_is_not_enough(edges, region, print_, correlation):
    assert Fit(edges, region, print_, correlation, 1.0).odds < ENOUGH


@settings(derandomize=True, deadline=None)
@given(NATS, NATS, NATS, SHARES, st.floats(0.0, 1.0))
def test_what_fits_better_tells_more(edges, region, print_, visible, more):
    fit = Fit(edges, region, print_, 0.5, visible)
    assert fit.odds >= LEAST
    for name in ("edges", "region", "print_"):
        assert fit._replace(**{name: getattr(fit, name) + more}).odds >= fit.odds


def test_what_is_not_in_sight_tells_nothing():
    assert NO_FIT.odds == 0.0
    assert Fit(1.3, 1.1, 0.0, 0.0, 0.0).odds == 0.0


def test_half_an_outline_owes_a_whole_one():
    """Few lines that fit by chance, where most are out of the picture, are no outline."""
    assert Fit(0.3, 0.2, FIRM, 0.3, 0.55).odds < ENOUGH < Fit(1.2, 1.0, FIRM, 0.3, 0.55).odds
