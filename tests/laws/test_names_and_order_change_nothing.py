"""Renaming and reordering change no number: features and appearances of scenes, clauses and predicates of programs."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from crowds import crowd
from drawn_programs import programs
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from situations import random_situations

from plogic.base.errors import InconsistentError
from plogic.logic.answers.state_ranking import ranked
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=50, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
KINDS = [("score", "to_B"), ("score", "drop"), ("score", "reassign"), ("posterior", "to_B")]


def listed(subject):
    ranking = ranked_worlds(subject, 10**6)
    return {frozenset(w.present): w.probability for w in ranking.worlds}, ranking


def assert_same(subject, other, back=None):
    """``back``: name in the other situation → name in the first."""
    back = back or {h.id: h.id for h in subject.hypotheses}
    worlds, before = listed(subject)
    others, after = listed(other)
    assert {frozenset(back[h] for h in present): p for present, p in others.items()} == pytest.approx(worlds, abs=1e-12)
    assert {back[h]: p for h, p in after.marginals.items()} == pytest.approx(before.marginals, abs=1e-12)
    assert after.log_evidence == pytest.approx(before.log_evidence, abs=1e-9)


def shuffled(subject, random):
    """Features, appearances and hypotheses, what hides a feature, and both names of each pair."""

    def mixed(items):
        return tuple(random.sample(items, len(items)))

    def turned(pairs):
        return frozenset(pair if random.random() < 0.5 else pair[::-1] for pair in pairs)

    hypotheses = [
        replace(h, features=mixed([replace(f, hidden_by=mixed(f.hidden_by)) for f in h.features]))
        for h in subject.hypotheses
    ]
    return replace(
        subject,
        hypotheses=mixed(hypotheses),
        appearances=mixed(subject.appearances),
        overlaps=turned(subject.overlaps),
        rivals=turned(subject.rivals),
        exclusive=turned(subject.exclusive),
        priors=dict(mixed(list(subject.priors.items()))),
    )


def relabelled(subject):
    """Other names for features, appearances, instances and types of features, in another alphabetical order."""
    features = {f.id: f"it's {99 - i} F" for i, f in enumerate(f for h in subject.hypotheses for f in h.features)}
    data = {a.id: f"Datum {99 - i}" for i, a in enumerate(subject.appearances)}

    def feature(f):
        return replace(f, id=features[f.id], match=f.match and data[f.match], type="Edge of 2")

    hypotheses = tuple(
        replace(h, group=f"of {h.group}", features=tuple(feature(f) for f in h.features)) for h in subject.hypotheses
    )
    return replace(
        subject,
        hypotheses=hypotheses,
        appearances=tuple(replace(a, id=data[a.id], type="spot") for a in subject.appearances),
    )


@QUICK
@given(random_situations(), st.randoms(use_true_random=False))
def test_the_order_of_everything_in_a_scene(subject, random):
    try:
        assert_same(subject, shuffled(subject, random))
    except InconsistentError:
        with pytest.raises(InconsistentError):
            ranked_worlds(shuffled(subject, random))


@QUICK
@given(random_situations())
def test_the_names_of_features_appearances_and_instances(subject):
    try:
        assert_same(subject, relabelled(subject))
    except InconsistentError:
        with pytest.raises(InconsistentError):
            ranked_worlds(relabelled(subject))


@pytest.mark.parametrize(("reading", "mode"), KINDS)
def test_names_and_order_in_a_crowd(reading, mode):
    from random import Random

    subject = crowd(11, 1, reading, mode)
    assert_same(subject, shuffled(relabelled(subject), Random(7)))  # noqa: S311 - drawn once


def worlds_of(text):
    found = ranked({"texts": [{"text": text, "file": "program"}], "number": 10_000})
    return {frozenset(world["holds"]): world["p"] for world in found["worlds"]}, found["log_evidence"]


@QUICK
@given(programs(), st.randoms(use_true_random=False))
def test_the_order_of_a_programs_clauses_and_bodies(drawn, random):
    assume(drawn.held())

    def mixed(items):
        return tuple(random.sample(items, len(items)))

    rules = mixed([(head, mixed(body)) for head, body in drawn.rules])
    other = replace(drawn, choices=mixed([mixed(a) for a in drawn.choices]), rules=rules, queries=mixed(drawn.queries))
    lines = mixed(other.text.splitlines())
    (before, mass), (after, other_mass) = worlds_of(drawn.text), worlds_of("\n".join(lines))
    assert after == pytest.approx(before, abs=1e-12)
    assert other_mass == pytest.approx(mass, abs=1e-12)


@QUICK
@given(programs())
def test_the_names_of_predicates(drawn):
    """c/2 becomes a quoted name that comes after r/1, which becomes a plain one."""
    assume(drawn.held())

    def named(text):
        return re.sub(r"\bc\(", "'Zed c'(", re.sub(r"\br\(", "again(", text))

    (before, mass), (after, other_mass) = worlds_of(drawn.text), worlds_of(named(drawn.text))
    assert after == pytest.approx({frozenset(map(named, holds)): p for holds, p in before.items()}, abs=1e-12)
    assert other_mass == pytest.approx(mass, abs=1e-12)
