"""The simulated family: Δh as the search poses it, near-duplicates merged, nothing pruned.

Photographs that are joined stay independent.
"""

import math
from collections import Counter
from itertools import combinations

import pytest

from benchmarks.families.bench import clusters
from benchmarks.worlds.oracle import enumerated, marginals_of
from benchmarks.worlds.scenes import MOST_OBJECTS, RIVALS, joined, photographs
from benchmarks.worlds.stock import stock
from plogic.cycle.delta import Options, unpruned
from plogic.cycle.state import same_hypothesis
from plogic.facts.sanity import check
from plogic.match.gamma.data import data_of
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from plogic.scene.text.program_text import program_text, query_lines
from plogic.scene.worlds.ranked_worlds import ranked_worlds


@pytest.fixture(scope="module")
def perceiver():
    return Perceiver(kb_of("towers"))


@pytest.fixture(scope="module")
def gamma(perceiver):
    from plogic.face.commands.simulate import shapes_of
    from sensing.detectors.detector import detect
    from sensing.simulated.scene import random_scene

    scene = random_scene(shapes_of(perceiver.kb), 7)
    return detect(scene.photograph().image, scene.camera, perceiver.kb.appearance_types)


@pytest.fixture(scope="module")
def delta(perceiver, gamma):
    return cut_to(26, perceiver, gamma)


def cut_to(most, perceiver, gamma):
    data = data_of(gamma.appearances, gamma.camera)
    return unpruned(
        data, perceiver.kb, list(perceiver.models.values()), perceiver.dv, Options(reading="posterior"), most
    )


@pytest.mark.parametrize("number", [5, 10, 20, 40, 80, 200])
def test_ten_rivals_and_more_an_object(number):
    shares = photographs(number)
    assert sum(share for _, share in shares) == number
    assert all(1 <= objects <= MOST_OBJECTS for objects, _ in shares)
    assert all(share >= RIVALS * objects for objects, share in shares if number >= RIVALS)


def test_no_two_hypotheses_are_near_duplicates(delta):
    posed = list(delta.beliefs.values())
    assert len(posed) >= 2 * RIVALS
    assert not [pair for pair in combinations(posed, 2) if same_hypothesis(*pair)]


def test_what_the_cycle_accepts_leads_them_and_each_has_rivals(perceiver, gamma, delta):
    accepted = [h for h in perceiver(gamma)["hypotheses"] if h["status"] == "accepted"]
    beliefs = list(delta.beliefs.values())
    assert len(accepted) == 2
    assert {h["type"] for h in accepted} == {b.object_type.name for b in beliefs[:2]}
    rivals = [sum(name in pair for pair in delta.situation.rivals) for name in ("h1", "h2")]
    assert min(rivals) >= 5
    assert sum(rivals) >= RIVALS


def test_cut_to_the_best(perceiver, gamma, delta):
    worths = [belief.worth for belief in delta.beliefs.values()]
    assert worths == sorted(worths, reverse=True)
    few = cut_to(4, perceiver, gamma)
    check(few.situation)
    assert [b.worth for b in few.beliefs.values()] == worths[:4]


def test_photographs_joined_change_no_marginal():
    views = [clusters(5, 0), clusters(6, 1)]
    whole = joined(views)
    check(whole)
    found = marginals_of(whole, enumerated(whole))
    wanted = {
        f"v{i}_{h}": p for i, view in enumerate(views, 1) for h, p in marginals_of(view, enumerated(view)).items()
    }
    assert found == pytest.approx(wanted, abs=1e-12)


def test_ten_rivals_of_a_photograph_weigh_what_stock_problog_and_enumeration_say(perceiver, gamma):
    """The same Δh, small enough for all three: every marginal, and the whole of the worlds."""
    situation = cut_to(RIVALS, perceiver, gamma).situation
    ranking = ranked_worlds(situation, 2**RIVALS)
    assert len(situation.hypotheses) == RIVALS
    assert max(Counter(h.group for h in situation.hypotheses).values()) > 1
    run = stock(program_text(situation) + query_lines(situation), "ddnnf", 120.0)
    assert run.why == ""
    assert ranking.marginals == pytest.approx({h: run.answers[f"present({h})"] for h in ranking.marginals}, abs=1e-9)
    assert ranking.marginals == pytest.approx(marginals_of(situation, enumerated(situation)), abs=1e-9)
    assert math.fsum(w.probability for w in ranking.worlds) == pytest.approx(1.0, abs=1e-9)
