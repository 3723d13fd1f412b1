"""The measures of one interpretation side by side.

Ev in each mode, Shanahan's value, the posterior, distinctiveness and rank (§5).

Vocabulary, each with an example value:

* ``Measure``: one hypothesis, ``Measure("h1", "t1", "accepted", ev=0.88, ..., posterior=0.97)``
* ``Distinctive``: one feature type, ``Distinctive("apex", over_types=0.99, over_instances=0.98)``
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import expm1, isnan, pi

import numpy as np

from plogic.base.bounds import LEAST
from plogic.facts.dependence import Scene
from plogic.facts.document import Interpretation
from plogic.facts.hypothesis import FeatureFact, Hypothesis, feature_nodes
from plogic.facts.interpretation import situation_of
from plogic.facts.situation import OTHERS, Reconsider, Situation
from plogic.measures.explanatory import Cells, case_of, explanatory_value, shanahan_values
from plogic.scene.readings.world_weights import p_ev
from plogic.scene.worlds.ranked_worlds import ranked_worlds

MODES: tuple[Reconsider, ...] = ("to_B", "drop", "reassign")


@dataclass(frozen=True)
class Measure:
    """The measures of one hypothesis; None where one is undefined (0/0) or the document does not tell what it takes.

    ``ev`` is that of the hypothesis alone (§5.4), ``ev_to_B``, ``ev_drop`` and ``ev_reassign`` beside Δi (§5.5).
    ``ev_over_instances``: alone, with dv over the instances in Δi (§5.1). ``shanahan``: among the hypothesis and its
    rivals (§5.7). ``posterior``: P(present) in the posterior reading (§8). ``dv`` and ``dv_over_instances``: the mean
    distinctiveness of its detected features. ``rank``: of its type (§5.3).
    """

    id: str
    type: str
    status: str
    ev: float | None
    ev_to_B: float | None  # noqa: N815 - the mode's name
    ev_drop: float | None
    ev_reassign: float | None
    ev_over_instances: float | None
    shanahan: float | None
    posterior: float
    dv: float | None
    dv_over_instances: float | None
    rank: float | None


@dataclass(frozen=True)
class Distinctive:
    """dv of a feature type over Σo's types, and over the instances in Δi.

    None where a learned type's features are summed up.
    """

    type: str
    over_types: float
    over_instances: float | None


def measured(document: Interpretation) -> tuple[tuple[Measure, ...], tuple[Distinctive, ...]]:
    """A row for each hypothesis of an interpretation, and one for each feature type.

    Raises:
        SituationError: the posterior cannot be computed exactly.
    """
    situation = situation_of(document)
    status = {h["id"]: h["status"] for h in document["hypotheses"]}
    believed = frozenset(name for name, said in status.items() if said == "accepted")
    scenes = {mode: Scene(replace(situation, reconsider=mode)) for mode in MODES}
    over_types = document["measures"].get("dv_types", situation.dv)
    over_delta = dv_over_instances([h for h in situation.hypotheses if h.id in believed], situation.dv)
    posterior = ranked_worlds(replace(situation, reading="posterior"), 1).marginals
    sensing = document.get("sensing")
    noise = None if sensing is None else _noise(situation, sensing["match_tolerance"])
    rows = [
        Measure(
            id=h.id,
            type=h.type,
            status=status[h.id],
            ev=_ev(scenes["to_B"], h, frozenset()),
            ev_to_B=_ev(scenes["to_B"], h, believed),
            ev_drop=_ev(scenes["drop"], h, believed),
            ev_reassign=_ev(scenes["reassign"], h, believed),
            ev_over_instances=None if over_delta is None else explanatory_value(_support(h), over_delta),
            shanahan=None if noise is None else _shanahan(h, situation, noise),
            posterior=posterior[h.id],
            dv=_mean(h, over_types),
            dv_over_instances=None if over_delta is None else _mean(h, over_delta),
            rank=situation.rank.get(h.type),
        )
        for h in situation.hypotheses
    ]
    features = [
        Distinctive(name, value, None if over_delta is None else over_delta[name]) for name, value in over_types.items()
    ]
    return tuple(rows), tuple(features)


def dv_over_instances(believed: Sequence[Hypothesis], dv: Mapping[str, float]) -> dict[str, float] | None:
    """Dv of each feature type over the instances in Δi, that over Σo where Δi is empty (§5.1).

    Every Feature node counts: of a compound, the part that it is told by too. None where features are summed up.
    """
    told = (feature_nodes(h.parts, [(f.id, f.type) for f in h.features]) for h in believed)
    counts = Counter(kind for nodes in told for kind in nodes.values())
    if OTHERS in counts:
        return None
    total = counts.total()
    return {name: 1.0 - counts[name] / total for name in dv} if total else dict(dv)


def _ev(scene: Scene, h: Hypothesis, beside: frozenset[str]) -> float | None:
    """Ev of a hypothesis in the world of it and those beside it."""
    share = float(p_ev(scene, h, {name: np.array([name == h.id or name in beside]) for name in scene.by_id})[0])
    return None if isnan(share) else 2.0 * share - 1.0


def _support(h: Hypothesis) -> dict[str, Cells]:
    """The four cells of each feature type, of the hypothesis alone."""
    cases: dict[str, Counter[str]] = {}
    for f in (f for f in h.features if f.in_image):
        case = case_of(expected=h.expects(f), detected=f.match is not None)
        cases.setdefault(f.type, Counter())[case] += f.stands_for
    return {name: Cells(**counts) for name, counts in cases.items()}


def _mean(h: Hypothesis, dv: Mapping[str, float]) -> float | None:
    found = [dv[f.type] for f in _detected(h) if f.type in dv]
    return sum(found) / len(found) if found else None


def _detected(h: Hypothesis) -> Iterable[FeatureFact]:
    return (f for f in h.features if f.in_image and f.match is not None)


def _noise(situation: Situation, tolerance: float) -> dict[str, float]:
    """By appearance, P(clutter of its type lies within the match tolerance of a place).

    What it takes to call the datum noise.
    """
    return {a.id: max(-expm1(-a.clutter * pi * tolerance**2), LEAST) for a in situation.appearances}


def _shanahan(h: Hypothesis, situation: Situation, noise: Mapping[str, float]) -> float | None:
    """Shanahan's value of a hypothesis among itself and its rivals, each with all of Γ to explain."""
    rivals = {name for pair in situation.rivals if h.id in pair for name in pair} | {h.id}
    rows = [other for other in situation.hypotheses if other.id in rivals]
    if any(other.type not in situation.priors for other in rows):
        return None
    values = shanahan_values({other.id: _abducibles(other, situation, noise) for other in rows})
    return values[h.id]


def _abducibles(h: Hypothesis, situation: Situation, noise: Mapping[str, float]) -> list[float]:
    """Priors of what "it stands there, and nothing else" takes on.

    The object, each hit, each miss, and noise for the data left over.
    """
    expected = [f for f in h.features if f.in_image and h.expects(f)]
    hits = [f.hit_rate if f.match is not None else 1.0 - f.hit_rate for f in expected]
    taken = {f.match for f in expected if f.match is not None}
    left = [chance for name, chance in noise.items() if name not in taken]
    return [min(max(prior, LEAST), 1.0) for prior in (situation.priors[h.type], *hits, *left)]
