"""World weights sum to P(evidence).

Scenes against the program text in stock ProbLog, programs against every total choice and stock.
"""

from __future__ import annotations

import math
import re

import pytest
from drawn_programs import programs
from hypothesis import HealthCheck, assume, given, settings
from situations import random_situations, towers

from plogic.base.errors import InconsistentError
from plogic.logic.answers.state_ranking import ranked
from plogic.logic.served.engine import Text, through
from plogic.logic.served.program_child import serve
from plogic.logic.served.program_worlds import program_worlds
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
EVIDENCE = re.compile(r"^evidence\((.*)\)\.$", re.MULTILINE)


def stock_mass(text):
    """P(all that the program has as evidence/1), asked as a query of the program without it."""
    from problog import get_evaluatable
    from problog.program import PrologString

    atoms = EVIDENCE.findall(text)
    asked = f"{EVIDENCE.sub('', text)}\nall_of_it :- {', '.join(['true', *atoms])}.\nquery(all_of_it).\n"
    results = get_evaluatable("ddnnf").create_from(PrologString(asked)).evaluate()
    (p,) = (p for goal, p in results.items() if str(goal) == "all_of_it")
    return p


def log_scale(subject):
    """Logarithm of what the text divides by: in the posterior reading Z = ΣN + f for each claimed appearance."""
    if subject.reading == "score":
        return 0.0
    densities = {a.id: [a.clutter] for a in subject.appearances}
    for h in subject.hypotheses:
        for f in h.features:
            if f.match is not None and h.expects(f):
                densities[f.match].append(f.density)
    return math.fsum(math.log(math.fsum(found)) for found in densities.values() if len(found) > 1)


def assert_weighs_the_same(subject):
    mass = stock_mass(program_text(subject))
    try:
        ranking = ranked_worlds(subject, 10**6)
    except InconsistentError:
        assert mass == pytest.approx(0.0, abs=1e-15)
        return
    assert ranking.log_evidence == pytest.approx(math.log(mass) + log_scale(subject), abs=1e-9)


@QUICK
@given(random_situations(most=4))
def test_a_scenes_evidence_weighs_what_stock_problog_says(subject):
    assert_weighs_the_same(subject)


@pytest.mark.parametrize("mode", ["drop", "to_B", "reassign"])
def test_the_two_towers_evidence_weighs_what_stock_problog_says(mode):
    assert_weighs_the_same(towers("score", mode))


@settings(QUICK, max_examples=100)
@given(programs())
def test_a_programs_worlds_sum_to_its_evidence_and_its_marginals(drawn):
    held = drawn.held()
    assume(held)
    mass = math.fsum(p for p, _ in held)
    found = ranked({"texts": [{"text": drawn.text, "file": "program"}], "number": 10_000})
    assert found["all"]
    assert found["log_evidence"] == pytest.approx(math.log(mass), abs=1e-9)
    assert math.fsum(world["p"] for world in found["worlds"]) == pytest.approx(1.0, abs=1e-9)
    for atom in drawn.queries:
        expected = math.fsum(p for p, true in held if atom in true) / mass
        assert math.fsum(world["p"] for world in found["worlds"] if atom in world["holds"]) == pytest.approx(
            expected, abs=1e-9
        )


@QUICK
@given(programs())
def test_a_programs_evidence_weighs_what_stock_problog_says(drawn):
    assume(drawn.held())
    with through(serve):
        ranking = program_worlds(Text(drawn.text), 3)
    assert ranking.log_evidence == pytest.approx(math.log(stock_mass(drawn.text)), abs=1e-9)
    listed = math.fsum(world.probability for world in ranking.worlds)
    assert ranking.unlisted[0] - 1e-12 <= 1.0 - listed <= ranking.unlisted[1] + 1e-12
