"""What a fit tells: an outline and print together, and nothing of what is hidden."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.match.learned.learned_views import SEEN
from sensing.pixels.energy import FIRM, LEAST, NO_FIT, Fit, printed

ENOUGH = SEEN
"""From which a learned type may be accepted by its pixels alone."""
NATS, SHARES, QUIET = st.floats(-2.0, 2.0), st.floats(0.0, 1.0), st.floats(-1.5, 0.0)


@settings(derandomize=True, deadline=None)
@given(st.floats(-1.0, 0.0), st.floats(-1.0, 0.0), st.floats(0.0, 2 * FIRM), st.floats(0.0, 1.0))
def test_print_without_an_outline_is_not_enough(edges, region, print_, correlation):
    assert Fit(edges, region, print_, correlation, 1.0).odds < ENOUGH


@settings(derandomize=True, deadline=None)
@given(st.floats(-1.0, 0.0), st.floats(-1.0, 0.0), st.floats(0.0, 2 * FIRM), SHARES, QUIET)
def test_of_what_is_plain_too(edges, region, print_, shown, quiet):
    """Creases and quiet make up for no outline; nor do they with print, unless the colours of its sides are neutral."""
    assert Fit(edges, region, 0.0, 0.1, 1.0, shown, 0.5, quiet, 0.0).odds < ENOUGH
    assert Fit(edges, region - 0.3, print_, 0.1, 1.0, shown, 0.5, quiet, 0.0).odds < ENOUGH
    assert Fit(0.0, 0.0, FIRM, 0.1, 1.0, 0.0).odds > ENOUGH


@settings(derandomize=True, deadline=None)
@given(NATS, NATS, NATS, SHARES, SHARES, NATS, QUIET, st.floats(-2.0, 0.0))
def test_what_fits_better_tells_more(edges, region, print_, visible, shown, creases, quiet, length):
    fit = Fit(edges, region, print_, 0.5, visible, shown, creases, quiet, length)
    assert fit.odds >= LEAST
    for name in ("edges", "region", "print_", "creases", "length"):
        assert fit._replace(**{name: getattr(fit, name) + 0.3}).odds >= fit.odds - 1e-9


def test_print_is_demanded_of_what_shows_some():
    """An outline alone is enough of what is plain, where chance gives few."""
    fit = Fit(1.2, 1.0, 0.02, 0.05, 1.0, creases=0.8)
    assert [printed(fit._replace(shown=shown)) for shown in (0.1, 0.35, 0.8)] == pytest.approx([0.0, 0.5, 1.0])
    assert fit._replace(shown=0.8).odds < ENOUGH < fit._replace(shown=0.1).odds
    assert fit._replace(shown=0.1, quiet=-0.7, length=-1.0).odds < 0.5 * fit._replace(shown=0.1).odds


def test_what_is_not_in_sight_tells_nothing():
    assert NO_FIT.odds == 0.0
    assert Fit(1.3, 1.1, 0.0, 0.0, 0.0).odds == 0.0
    assert Fit(1.3, 1.1, 0.0, 0.0, 0.0, 0.1, 1.0, -0.5, -1.0).odds == 0.0


def test_half_an_outline_owes_a_whole_one():
    """Few lines that fit by chance, where most are out of the picture, are no outline."""
    assert Fit(0.3, 0.2, FIRM, 0.3, 0.55).odds < ENOUGH < Fit(1.2, 1.0, FIRM, 0.3, 0.55).odds
