"""The pick of a hypothesis on which very many others bear, as a variable of its own (§8, score), where one factor over all is too wide.

present(h) holds iff h is supported and the feature that it picks is concordant: a boolean formula over the pick and
over who is present, which the graph takes as gates.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.base.bounds import alternative
from plogic.inference.gates import And, Literal, Not, Or
from plogic.scene.factors.weight_tables import IMPOSSIBLE, log

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.facts.dependence import Scene
    from plogic.facts.hypothesis import FeatureFact, Hypothesis
    from plogic.inference.gates import Formula
    from plogic.scene.factors.alternatives import Cast
    from plogic.scene.factors.weight_tables import Tables


def add_pick(tables: Tables, cast: Cast, scene: Scene, h: Hypothesis, epsilon: float) -> None:
    """Modes `to_B` and `reassign`: state 0 and 1 of the pick are luck, good and bad (ε each); state i > 1 is the i-th feature in the image."""
    seen = [f for f in h.features if f.in_image]
    shares = alternative([f.dv for f in seen])
    if not shares:  # every dv is 0: ev is undefined, and the hypothesis is never present
        variable, state = cast.place[h.id]
        tables.unary[variable][state] = IMPOSSIBLE
        return
    pick = tables.variable([log(epsilon), log(epsilon), *(log((1 - 2 * epsilon) * share) for share in shares)])
    agrees = [_picked(pick, 0)]
    agrees += [And((_picked(pick, i), _concordant(cast, scene, h, f))) for i, f in enumerate(seen, 2)]
    accepted = And((Or(tuple(_found(cast, scene, h, f) for f in seen)), Or(tuple(agrees))))
    present = _present(cast, h.id)
    tables.required.append(Or((And((present, accepted)), And((Not(present), Not(accepted))))))


def _picked(pick: int, state: int) -> Formula:
    return Literal(pick, frozenset({state}))


def _present(cast: Cast, name: str) -> Formula:
    variable, state = cast.place[name]
    return Literal(variable, frozenset({state}))


def _any_of(cast: Cast, names: Iterable[str]) -> Formula:
    return Or(tuple(Literal(v, frozenset(states)) for v, states in cast.literals(names)))


def _in_view(cast: Cast, h: Hypothesis, f: FeatureFact) -> Formula:
    """D7, given that ``h`` is in the world."""
    return Not(_any_of(cast, cast.hiders(h, f))) if h.expects(f) else Or(())


def _robbed(cast: Cast, scene: Scene, h: Hypothesis, f: FeatureFact) -> Formula:
    """Mode `reassign`: another present object's expected feature claims the appearance (§5.5)."""
    robbers = scene.robbers(h, f) if cast.situation.reconsider == "reassign" else []
    return Or(tuple(And((_present(cast, g.id), _in_view(cast, g, e))) for g, e in robbers))


def _found(cast: Cast, scene: Scene, h: Hypothesis, f: FeatureFact) -> Formula:
    """D8."""
    return Or(()) if f.match is None else Or((_in_view(cast, h, f), Not(_robbed(cast, scene, h, f))))


def _concordant(cast: Cast, scene: Scene, h: Hypothesis, f: FeatureFact) -> Formula:
    """Expected ⇔ Detected: what is matched is in view or lost to another; what is not is out of view."""
    in_view = _in_view(cast, h, f)
    return Not(in_view) if f.match is None else Or((in_view, _robbed(cast, scene, h, f)))
