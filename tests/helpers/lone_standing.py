"""Hypotheses that have nothing to do with each other but what they stand on, and the probabilities of worlds."""

from __future__ import annotations

from dataclasses import replace

from situations import feature, hypothesis, plane, situation

from plogic.base.errors import InconsistentError
from plogic.facts.stances import Stance, Support
from plogic.scene.worlds.ranked_worlds import ranked_worlds


def worlds_of(subject):
    """Each world and its probability; {} where none is possible."""
    try:
        return {w.present: w.probability for w in ranked_worlds(subject, 10**6).worlds}
    except InconsistentError:
        return {}


def lone(*names, reading="posterior", **changes):
    """Hypotheses that have nothing to do with each other."""
    features = [[feature("x", match=f"a_{name}"), feature("y", "C")] for name in names]
    return situation([hypothesis(name, some) for name, some in zip(names, features, strict=True)], reading, **changes)


def by_chance(subject, e):
    """All of them stand by chance where they are absent."""
    return replace(subject, support=replace(subject.support, by_chance=tuple((h.id, e) for h in subject.hypotheses)))


def on_plane(ratio, none=0.0, rests=0.9):
    return Support(rests, none, (plane("s1", 1.0 - none),), (Stance("h1", "s1", 1, rests, ratio),))
