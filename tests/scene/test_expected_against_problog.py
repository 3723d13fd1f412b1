"""D7 is one function and one rule text.

What each says of every feature of random scenes, in random worlds, is the same.
"""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import random_situations

from plogic.facts.dependence import Scene, dependence
from plogic.facts.hypothesis import Seen, expected
from plogic.facts.situation import names_of
from plogic.facts.vocabulary import VOCABULARY
from plogic.scene.readings import world_weights
from plogic.scene.text import fact_layers
from plogic.scene.text.layout import Writer
from plogic.scene.text.object_types import object_types
from plogic.scene.text.rules import COMMON, EXPECTED, OBJECT_TYPES, fallbacks

QUICK = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def features(subject):
    return [(h, f) for h in subject.hypotheses for f in h.features]


def by_function(subject, world):
    """The features that D7 as a function expects, by their places.

    Who hides is taken from the facts, by its definition.
    """
    rivals = {frozenset(pair) for pair in subject.rivals}
    opaque = {h.id for h in subject.hypotheses if h.opaque}

    def hidden(h, f):
        others = (set(f.hidden_by) & world & opaque) - {h.id}
        return any(frozenset((h.id, g)) not in rivals for g in others)

    rows = enumerate(features(subject))
    return {i for i, (h, f) in rows if h.id in world and expected(f, h.opaque, hidden(h, f))}


def by_rules(subject, world):
    """The same by stock ProbLog: the facts and the rules of the generated program, the world as facts."""
    from problog import get_evaluatable
    from problog.program import PrologString

    scene = Scene(subject)
    w = Writer(scene, dependence(scene), names_of(subject))
    asked = [w.fact("expected", h.id, f.id).rstrip(".") for h, f in features(subject)]
    lines = [
        *object_types(w),
        *fact_layers.geometry(w),
        OBJECT_TYPES,
        COMMON,
        *(e.clause for e in VOCABULARY if e.signature in {"opaque/1", "expected/2"}),
        *(w.fact("present", name) for name in sorted(world)),
        "present(_) :- fail.",
        *fallbacks("score"),
        *(f"asked({i}) :- {goal}." for i, goal in enumerate(asked)),
        *(f"query(asked({i}))." for i in range(len(asked))),
    ]
    results = get_evaluatable().create_from(PrologString("\n".join(lines))).evaluate()
    return {int(term.args[0]) for term, p in results.items() if p > 0.5}


@QUICK
@given(random_situations(), st.randoms(use_true_random=False))
def test_the_function_and_the_rules_expect_the_same(subject, random):
    world = {h.id for h in subject.hypotheses if random.random() < 0.7}
    assert by_rules(subject, world) == by_function(subject, world)


@QUICK
@given(random_situations(), st.randoms(use_true_random=False))
def test_many_worlds_at_once_are_each_of_them(subject, random):
    """In arrays over worlds (``score_reading``) and over features (``Seen``) it is what it is one by one."""
    scene, worlds = Scene(subject), [{h.id for h in subject.hypotheses if random.random() < 0.7} for _ in range(5)]
    present = {h.id: np.array([h.id in world for world in worlds]) for h in subject.hypotheses}
    rows = [present[h.id] & world_weights.expected(scene, h, f, present) for h, f in features(subject)]
    found = [set(np.flatnonzero(column).tolist()) for column in np.array(rows).T]
    assert found == [by_function(subject, world) for world in worlds]
    for h in subject.hypotheses:
        flags = (np.array([getattr(f, name) for f in h.features]) for name in Seen._fields)
        assert expected(Seen(*flags), h.opaque).tolist() == [h.expects(f) for f in h.features]


def test_the_program_states_it_once():
    assert COMMON.count("in_view(H, F) :-") == EXPECTED.count("in_view(H, F) :-") == 1
    assert EXPECTED in COMMON
