"""Ties that nothing in the image decides: names do, and the order in which things are told does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from many_objects import accepted_rows, few_kb, few_of_seed, twins

from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver
from sensing.appearance import Gamma

SEED = 5400


def told(document):
    """What is accepted, and why of what else was tried, without what appearances are called in the trace."""
    return accepted_rows(document), [(w["probability"], w["present"], w["causes"]) for w in document["worlds"]]


@pytest.fixture(scope="module")
def one():
    """What is made of the scene where every type is there twice."""
    return Perceiver(twins())(few_of_seed(SEED).gamma, Options(reading="posterior"))


@pytest.mark.parametrize("order", ["reversed", "mixed"])
def test_of_two_types_that_are_equal_the_first_by_name_is_found(one, order):
    kb, gamma = twins(), few_of_seed(SEED).gamma
    other = (
        kb.types[::-1]
        if order == "reversed"
        else [kb.types[i] for i in np.random.default_rng(3).permutation(len(kb.types))]
    )
    assert {row["type"] for row in accepted_rows(one)} <= {kind.name for kind in few_kb().types}
    assert told(Perceiver(replace(kb, types=tuple(other)))(gamma, Options(reading="posterior"))) == told(one)


def test_of_two_data_that_are_equal_the_first_by_name_is_claimed():
    gamma = few_of_seed(SEED).gamma
    again = tuple(replace(datum, id=f"{datum.id}_again") for datum in gamma.appearances)
    perceiver, both = Perceiver(few_kb()), gamma.appearances + again
    one = perceiver(Gamma(gamma.camera, both), Options(reading="posterior"))
    assert accepted_rows(one)
    for seed in (0, 2):
        mixed = tuple(both[i] for i in np.random.default_rng(seed).permutation(len(both)))
        assert told(perceiver(Gamma(gamma.camera, mixed), Options(reading="posterior"))) == told(one)
