"""The prior of clutter, λ·P(dv(F)), where a KB states none (§8)."""

import pytest

from kb.clouds.cloud import LAMBDA, clutter_prior
from kb.files.folder import shipped
from kb.files.read import read_kb


@pytest.fixture(scope="module")
def towers():
    return read_kb(shipped("towers"))


def test_it_shares_lambda_out_by_p_dv(towers):
    """95 of 112 features are patches and look like nothing else; the other 17 look like any of five junctions."""
    prior = clutter_prior(towers.types, towers.appearance_types)
    assert prior["patch"] == pytest.approx(LAMBDA * 6 * 95 / 112, abs=1e-6)
    assert prior["l_junction"] == pytest.approx(LAMBDA * 6 * 17 / 112 / 5, abs=1e-6)
    assert sum(prior.values()) == pytest.approx(LAMBDA * 6, abs=1e-5)


def test_what_no_feature_looks_like_is_rare_but_possible(towers):
    prior = clutter_prior(towers.types, (*towers.appearance_types, "marker"))
    assert 0.0 < prior["marker"] < min(value for name, value in prior.items() if name != "marker")


def test_without_types_everything_is_rare_alike():
    assert clutter_prior((), ("a", "b")) == {"a": 0.01, "b": 0.01}


def test_what_a_kb_states_stands(towers):
    assert towers.rates.clutter["patch"] == 1.5
