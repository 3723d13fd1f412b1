"""What takes the rest where a hypothesis is less probable than its P(ev) beside the others (score reading, §8).

P(present(H) | its occluders) is P(ev) before Σc. What is left of it afterwards is told by taking one thing away at a
time: an exclusion of two hypotheses, the author's constraints, who holds whom. What remains then is its occluders', for
they may be absent. Each is a ``Taker``: the words, and the situation without it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from plogic.base.errors import InconsistentError, OutsideError, TooManyHypothesesError
from plogic.facts.dependence import Scene
from plogic.facts.situation import Situation
from plogic.scene.asking.live import LiveScene
from plogic.scene.asking.relevant import relevant
from plogic.scene.readings.world_weights import p_ev

PAIRS = 12
"""Exclusions that are taken away one by one; all others are at once."""
NOTABLE = 0.0005
"""A difference that shows where probabilities have three places."""
Pair = tuple[str, str]


class Taker(NamedTuple):
    """``since``: the reason in words; ``without``: the situation in which it does not hold."""

    since: str
    without: Situation


def shortfall(
    situation: Situation, name: str, world: Sequence[str], probability: float, given: Sequence[str]
) -> Iterator[str]:
    """A line for each thing that takes some of P(ev) in ``world``, what takes most first; none where nothing does."""
    scene = Scene(situation)
    share = p_ev(scene, scene.by_id[name], {h.id: np.array([h.id in world]) for h in situation.hypotheses})
    alone = float(share[0])
    if situation.reading != "score" or not probability < alone - NOTABLE:
        return
    part = relevant(situation, [f"present({name})", *given])
    kinds = {h.id: f"{h.type} {h.id}" for h in part.hypotheses}
    told = [(_chance(taker.without, name, given), taker.since) for taker in _takers(part, name, kinds)]
    for p, since in sorted((row for row in told if row[0] > probability + NOTABLE), key=lambda row: -row[0]):
        yield f"  less than P(ev), since {since}; without that it would be {p:.4g}"
    free = replace(part, overlaps=frozenset(), exclusive=frozenset(), gravity=None, rules="", own=None)
    p, hiding = _chance(free, name, given), [g for g in _hiders(scene, name) if g in world]
    if p < alone - NOTABLE and hiding:
        which = ", ".join(kinds[g] for g in hiding)
        yield f"  less than P(ev), which is that beside {which}: what that hides would be missed where it is absent"


def _takers(part: Situation, name: str, kinds: dict[str, str]) -> Iterator[Taker]:
    """Exclusions first, its own before those of others."""
    pairs = sorted(part.overlaps | part.exclusive, key=lambda pair: (name not in pair, pair))
    for pair in pairs[:PAIRS]:
        yield Taker(_excluded(part, name, pair, kinds), _freed(part, [pair]))
    if rest := pairs[PAIRS:]:
        yield Taker(f"{len(rest)} more pairs are never together", _freed(part, rest))
    if part.rules or part.own is not None:
        yield Taker("the author's rules and constraints say so", replace(part, rules="", own=None))
    if part.gravity is not None:
        yield Taker("what floats needs an excuse (gravity)", replace(part, gravity=None))


def _excluded(part: Situation, name: str, pair: Pair, kinds: dict[str, str]) -> str:
    """The exclusion in words: a rival, or two others that it makes probable."""
    law = "they share volume, A4" if pair in part.overlaps else "they live on the same appearances, D8"
    if name in pair:
        return f"its rival {kinds[pair[1] if pair[0] == name else pair[0]]} is never together with it ({law})"
    x, y = (kinds[one] for one in pair)
    return f"{x} and {y} are never together ({law}), and of its worlds more are ruled out by that than of the others"


def _freed(part: Situation, pairs: Sequence[Pair]) -> Situation:
    return replace(part, overlaps=part.overlaps - {*pairs}, exclusive=part.exclusive - {*pairs})


def _chance(situation: Situation, name: str, given: Sequence[str]) -> float:
    """P(present) there; 0 where no world is possible, or what was observed cannot be said of it."""
    try:
        scene = LiveScene(situation)
        for observed in given:
            scene.observe(observed)
        return sum(scene.marginals()[name]) / 2
    except (InconsistentError, OutsideError, TooManyHypothesesError):
        return 0.0


def _hiders(scene: Scene, name: str) -> list[str]:
    """Who can hide some of it, in the order of Δh."""
    h = scene.by_id[name]
    found = {g for f in h.features if f.in_image and h.expects(f) for g in scene.hiders(h, f)}
    return [g for g in scene.by_id if g in found]
