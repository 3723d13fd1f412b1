"""What is collected once each, by ``all/3`` and ``all_or_none/3``, has the lists of stock ProbLog, and takes no text.

``findall/3`` collects proofs, of which a hypothesis of the score reading has thousands: it is refused at once.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from enumeration import log_weights
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation
from stock_worlds import evaluated

from plogic.base.errors import InconsistentError, ProgramError
from plogic.facts.situation import names_of
from plogic.logic.safety.mapping import shown
from plogic.scene.asking.live import scene_answers
from plogic.scene.asking.query import answers
from plogic.scene.text.program_text import program_text

pytestmark = pytest.mark.usefixtures("served_here")

COLLECTED = (
    "all_or_none(H, present(H), L)", "all(H, present(H), L)", "all(T, object(H, T), L)", "all_or_none(X-Y, occludes(X, Y), L)",
    "all(H/F, case(H, F, c), L)",
)  # fmt: skip


def by_items(lists):
    """Lists as text, with probabilities, → the same in one order of items, for grounding decides it."""
    found = Counter()
    for text, p in lists:
        found[", ".join(sorted(text.strip("[]").split(", ")))] += p
    return dict(found)


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(random_situations(most=3, modes=("to_B", "drop")), st.sampled_from(COLLECTED))
def test_what_is_collected_once_is_what_problog_collects(subject, goal):
    from problog.errors import InconsistentEvidenceError

    names = names_of(subject)
    try:
        theirs = evaluated(f"{program_text(subject)}\nlists(L) :- {goal}.\nquery(lists(_)).\n")
    except InconsistentEvidenceError:
        with pytest.raises(InconsistentError):
            scene_answers(subject, [goal])
        return
    ours = scene_answers(subject, [goal])[0]
    wanted = by_items((shown(term.args[0], names), p) for term, p in theirs.items() if p > 0)
    assert by_items((a.goal.rpartition(", [")[2].rstrip(")"), a.probability) for a in ours) == pytest.approx(
        wanted, abs=1e-9
    )


def crowd(number, **changes):
    """Some whose features the one before and the one before that hide; as many proofs of each as features, and more."""
    names = [f"h{i}" for i in range(1, number + 1)]
    return situation(
        [
            hypothesis(
                name,
                [
                    *(feature(f"{name}_{k}", dv=0.3 + 0.05 * k) for k in range(6)),
                    *(feature(f"{name}_m{k}", "C", hidden_by=tuple(names[max(0, i - 2) : i])) for k in range(3)),
                ],
            )
            for i, name in enumerate(names)
        ],
        **changes,
    )


def test_ten_hypotheses_are_collected_as_brute_force_counts_them():
    subject = crowd(10)
    logs = log_weights(subject)
    worlds = np.exp(logs - np.logaddexp.reduce(logs))
    wanted = Counter()
    for bits, p in zip(product((False, True), repeat=10), worlds, strict=True):
        wanted[f"n({sum(bits)})"] += p
    rules = "n(N) :- all_or_none(H, present(H), L), length(L, N).\nunasked(L) :- findall(H, present(H), L).\n"
    found = {a.goal: a.probability for a in answers(replace(subject, rules=rules), "n(N)")}
    assert found == pytest.approx({goal: p for goal, p in wanted.items() if p > 0}, abs=1e-9)


@pytest.mark.parametrize("asked", ["findall(H, present(H), L)", "n(N)"])
def test_a_list_of_proofs_is_refused_at_once_and_told_what_is_right(asked):
    rules = "n(N) :- findall(H, present(H), L), length(L, N).\n"
    with pytest.raises(ProgramError) as error:
        answers(replace(crowd(10), rules=rules), asked)
    assert "findall/3 collects an answer once for each proof: present(X1) has" in str(error.value)
    assert "all_or_none/3 collects each answer once; the number of objects is number_of_objects(N)" in str(error.value)
