"""How measures are compared in a test: run it with ``pytest examples/test_measures.py``."""

from pathlib import Path

import pytest

from plogic import KnowledgeBase, Measure, perceive

GAMMA = Path(__file__).parent / "first_gamma.json"


@pytest.fixture(scope="module")
def box() -> Measure:
    """The measures of the one object that is there."""
    (accepted,) = (m for m in perceive(GAMMA, KnowledgeBase.load("first")).measures() if m.status == "accepted")
    return accepted


def test_no_other_object_hides_a_feature_so_that_the_modes_agree(box: Measure) -> None:
    assert box.ev_to_B == pytest.approx(box.ev_drop)
    assert box.ev_to_B == pytest.approx(box.ev_reassign)


def test_one_missed_corner_costs_ev_more_than_it_costs_the_posterior(box: Measure) -> None:
    assert box.ev is not None
    assert box.posterior is not None
    assert box.ev < 1.0
    assert box.posterior > (box.ev + 1.0) / 2.0


def test_the_rarer_type_is_the_more_distinctive(box: Measure) -> None:
    assert box.dv["sticker"] > box.dv["corner"]
