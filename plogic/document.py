"""The whole ``interpretation/1`` document of one image (contract), from the typed parts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.camera import camera_to_dict
from plogic.assets import image_asset, mesh_assets
from plogic.expectation import hidden_by
from plogic.factors.asking import together
from plogic.interpretation import FORMAT, facts_of, hypothesis_document
from plogic.measures.distinctiveness import instance_counts, probability_of_distinctiveness
from plogic.measures.explanatory import case_of, probability_of_ev
from plogic.outlines import outline_rings
from sensing.gamma_files import appearance_to_dict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.belief import Belief
    from plogic.delta import Delta
    from plogic.situation import Situation
    from plogic.worlds import Ranking
    from sensing.appearance import Gamma

LISTED_REJECTED = 12
"""Rejected hypotheses that are written, the best first; the trace names them all."""

Cases = dict[str, tuple[bool, bool, str | None]]


def document_of(
    kb: KnowledgeBase,
    gamma: Gamma,
    delta: Delta,
    rejected: Sequence[Belief],
    trace: list[dict[str, object]],
    ranking: Ranking,
    image: NDArray[np.uint8] | None,
) -> dict[str, Any]:
    """Everything that ``worlds``, ``query``, ``explain``, ``report`` and ``program`` need."""
    situation = delta.situation
    counts = instance_counts(kb.types)
    return {
        "format": FORMAT,
        "reading": situation.reading,
        "reconsider": situation.reconsider,
        "smoothing": situation.smoothing,
        "kb": {"name": kb.name, "digest": kb.digest},
        "camera": camera_to_dict(gamma.camera),
        "appearances": [
            {**appearance_to_dict(a), "clutter": fact.clutter}
            for a, fact in zip(gamma.appearances, situation.appearances, strict=True)
        ],
        "hypotheses": _hypotheses(delta, gamma, ranking) + _rejected(rejected, gamma),
        "worlds": [
            {"probability": w.probability, "present": list(w.present), "causes": dict(w.causes)} for w in ranking.worlds
        ],
        "unlisted_mass": list(ranking.unlisted),
        "relations": relation_probabilities(situation),
        "facts": facts_of(situation),
        "measures": {"dv": situation.dv, "p_dv": probability_of_distinctiveness(counts), "rank": situation.rank},
        "priors": situation.priors,
        "rules": situation.rules,
        "labels": {},
        "assets": image_asset(image)
        | mesh_assets({b.posed.object_type.name: b.posed.object_type for b in delta.beliefs.values()}),
        "trace": trace,
    }


def relation_probabilities(situation: Situation) -> list[dict[str, Any]]:
    """P(relation) of each pair: that both are present, most probable first."""
    chances = together(situation, [(fact.x, fact.y) for fact in situation.relations])
    rows = [
        {"relation": fact.relation, "args": [fact.x, fact.y], "probability": chance}
        for fact, chance in zip(situation.relations, chances, strict=True)
    ]
    return sorted(rows, key=lambda row: (-row["probability"], row["relation"], row["args"]))


def _hypotheses(delta: Delta, gamma: Gamma, ranking: Ranking) -> list[dict[str, Any]]:
    facts = {h.id: h for h in delta.situation.hypotheses}
    return [
        {
            **hypothesis_document(facts[name], _cases(belief, _beside(name, delta))),
            **_verdict(belief, gamma),
            "probability": ranking.marginals[name],
        }
        for name, belief in delta.beliefs.items()
    ]


def _beside(name: str, delta: Delta) -> list[Belief]:
    """The accepted opaque objects that may hide features of a hypothesis: its rivals hide nothing (D7)."""
    rivals = {frozenset(pair) for pair in delta.situation.rivals}
    return [
        other
        for key, other in delta.beliefs.items()
        if key != name
        and other.status == "accepted"
        and other.posed.object_type.opaque
        and frozenset((name, key)) not in rivals
    ]


def _hidden(belief: Belief, beside: Sequence[Belief]) -> NDArray[np.bool_]:
    mask = np.zeros(len(belief.posed.uv), dtype=bool)
    for other in beside:
        mask |= hidden_by(belief.posed, other.posed)
    return mask


def _cases(belief: Belief, beside: Sequence[Belief]) -> Cases:
    """(expected, detected, case) of each feature beside Δi; outside the image, no case."""
    posed = belief.posed
    expected = posed.candidate & ~_hidden(belief, beside)
    rows = zip(
        posed.object_type.features, expected.tolist(), posed.detected.tolist(), posed.in_image.tolist(), strict=True
    )
    return {f.name: (e, d, case_of(expected=e, detected=d) if inside else None) for f, e, d, inside in rows}


def _verdict(belief: Belief, gamma: Gamma) -> dict[str, Any]:
    """What the cycle decided of one hypothesis, with its measures and outline."""
    posed, ev = belief.posed, belief.ev
    support = {
        name: {"expected_detected": c.A, "expected_missed": c.C, "hidden_missed": c.B, "hidden_detected": c.D}
        for name, c in posed.support().items()
    }
    return {
        "label": posed.object_type.name,
        "status": belief.status,
        "why": belief.why,
        "ev": ev,
        "p_ev": None if ev is None else probability_of_ev(ev),
        "ev_reconsidered": belief.ev_reconsidered,
        "log_likelihood_ratio": belief.worth,
        "support": support,
        "outline": outline_rings(posed, gamma.camera),
    }


def _rejected(rejected: Sequence[Belief], gamma: Gamma) -> list[dict[str, Any]]:
    best = sorted(rejected, key=lambda b: -b.worth)[:LISTED_REJECTED]
    return [
        {
            "id": f"r{i}",
            "type": b.posed.object_type.name,
            "T_camera_object": b.posed.camera_from_object.tolist(),
            "opaque": b.posed.object_type.opaque,
            "group": None,
            "probability": 0.0,
            "parts": [],
            "features": [],
            **_verdict(b, gamma),
        }
        for i, b in enumerate(best, 1)
    ]
