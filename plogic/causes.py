"""What causes each appearance in one world: the fixed matchings (score) or their most probable assignment (posterior) (§8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.acceptance import expected
from plogic.bounds import bounded
from plogic.likelihood import causes_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.dependence import Scene
    from plogic.situation import FeatureFact, HypothesisFact

NOISE = "noise"


def causes(scene: Scene, present: Iterable[str]) -> dict[str, str]:
    """Appearance id → ``"h1/roof/apex"`` or ``"noise"``, for every appearance of Γ, exactly one each (trap a)."""
    members = set(present)
    columns = {h.id: np.array([h.id in members]) for h in scene.situation.hypotheses}
    return {a.id: _cause(scene, a.id, columns) for a in scene.situation.appearances}


def _cause(scene: Scene, appearance: str, columns: dict[str, np.ndarray[tuple[int], np.dtype[np.bool_]]]) -> str:
    live = [(h, f) for h, f in scene.claimants.get(appearance, ()) if columns[h.id][0] and expected(scene, h, f, columns)[0]]
    if not live:
        return NOISE
    return _nearest(live) if scene.situation.reading == "score" else _likeliest(scene, appearance, live)


def _nearest(live: list[tuple[HypothesisFact, FeatureFact]]) -> str:
    """Where two expect the same appearance, the smaller residual takes it; then the earlier in Δh."""
    h, f = min(live, key=lambda pair: pair[1].residual if pair[1].residual is not None else float("inf"))
    return f"{h.id}/{f.id}"


def _likeliest(scene: Scene, appearance: str, live: list[tuple[HypothesisFact, FeatureFact]]) -> str:
    """The largest term of Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j); ties go to a claimant, the earliest in Δh."""
    table = causes_of(scene, appearance)
    share = {(h.id, f.id): s for (h, f), s in zip(table.claimants, table.shares, strict=True)}
    terms = [(_term(share[h.id, f.id], live, i), f"{h.id}/{f.id}") for i, (h, f) in enumerate(live)]
    terms.append((_term(table.noise, live, None), NOISE))
    return max(terms, key=lambda term: term[0])[1]


def _term(share: float, live: list[tuple[HypothesisFact, FeatureFact]], hit: int | None) -> float:
    for i, (_, f) in enumerate(live):
        share *= bounded(f.hit_rate) if i == hit else 1.0 - bounded(f.hit_rate)
    return share
