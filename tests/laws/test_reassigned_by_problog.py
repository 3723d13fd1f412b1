"""Mode `reassign`, where one's appearance goes to another (§5.5).

Worlds against the rules of the text, as stock ProbLog runs them.
"""

from __future__ import annotations

from hypothesis import HealthCheck, assume, given, settings
from situations import random_situations
from stock_worlds import assert_same_worlds

from plogic.base.errors import InconsistentError
from plogic.facts.dependence import Scene, dependence

QUICK = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


@QUICK
@given(random_situations(readings=("score",), modes=("reassign",)))
def test_what_is_taken_away_is_what_the_rules_say(subject):
    """Only where no cycle is decided jointly: there the text carries the numbers of the code that it would judge."""
    scene = Scene(subject)
    assume(all(len(block) == 1 for block in dependence(scene).blocks))
    assume(any(scene.robbers(h, f) for h in subject.hypotheses for f in h.features))
    try:
        assert_same_worlds(subject)
    except InconsistentError:
        return
