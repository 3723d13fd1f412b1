"""What causes each appearance in one world: the fixed matchings (score) or their most probable assignment (posterior) (§8).

Vocabulary: a ``Claim`` is a candidate feature that is matched to an appearance, with what hides it:
``Claim("h1", "h1/roof/apex", 0.5, 0.05, 0.8, frozenset({"h2"}))``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from plogic.bounds import alternative, bounded

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.factors.alternatives import Cast

NOISE = "noise"


class Claim(NamedTuple):
    """``label``: what the cause is called; ``residual`` in pixels, inf where there is none; ``density`` per pixel²; ``hit`` h_F."""

    hypothesis: str
    label: str
    residual: float
    density: float
    hit: float
    hiders: frozenset[str]


class CauseTable:
    """The claims of every appearance of Γ, and which appearances the presence of a hypothesis can touch."""

    def __init__(self, cast: Cast) -> None:
        self._score = cast.situation.reading == "score"
        self._claims: dict[str, list[Claim]] = {a.id: [] for a in cast.situation.appearances}
        for h in cast.situation.hypotheses:
            for f in h.features:
                if f.match is not None and h.candidate(f):
                    residual = float("inf") if f.residual is None else f.residual
                    hiders = frozenset(cast.hiders(h, f)) if f.hidden_by else frozenset()
                    self._claims[f.match].append(Claim(h.id, f"{h.id}/{f.id}", residual, f.density, bounded(f.hit_rate), hiders))
        self._shares = {a.id: alternative([*(c.density for c in self._claims[a.id]), a.clutter]) for a in cast.situation.appearances}
        self._known: dict[tuple[str, tuple[int, ...]], str] = {}
        self.touched: dict[str, set[str]] = {h.id: set() for h in cast.situation.hypotheses}
        for appearance, claims in self._claims.items():
            for claim in claims:
                for name in (claim.hypothesis, *claim.hiders):
                    self.touched[name].add(appearance)

    def causes(self, worlds: Sequence[Sequence[str]]) -> list[dict[str, str]]:
        """For each world: appearance → ``"h1/roof/apex"`` or ``"noise"``, for every appearance, exactly one each (trap a).

        Worlds differ in a few hypotheses: only what these touch is looked at anew.
        """
        if not worlds:
            return []
        first = set(worlds[0])
        base = self._of(self._claims, first)
        found = [base]
        for world in worlds[1:]:
            present = set(world)
            anew = sorted(set().union(*(self.touched[name] for name in first ^ present)))
            found.append({**base, **self._of(anew, present)})
        return found

    def _of(self, appearances: Iterable[str], present: set[str]) -> dict[str, str]:
        return {a: self._cause(a, present) for a in appearances}

    def _cause(self, appearance: str, present: set[str]) -> str:
        claims = self._claims[appearance]
        live = tuple([i for i, c in enumerate(claims) if c.hypothesis in present and c.hiders.isdisjoint(present)])
        if not live:
            return NOISE
        key = (appearance, live)
        if key not in self._known:
            self._known[key] = self._nearest(*key) if self._score else self._likeliest(*key)
        return self._known[key]

    def _nearest(self, appearance: str, live: tuple[int, ...]) -> str:
        """Where two expect the same appearance, the smaller residual takes it; then the earlier in Δh."""
        claims = self._claims[appearance]
        return min((claims[i] for i in live), key=lambda claim: claim.residual).label

    def _likeliest(self, appearance: str, live: tuple[int, ...]) -> str:
        """The largest term of Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j); ties go to a claimant, the earliest in Δh."""
        claims = self._claims[appearance]
        shares = self._shares[appearance] or [0.0] * (len(claims) + 1)
        terms = [(self._term(appearance, shares[i], live, i), claims[i].label) for i in live]
        terms.append((self._term(appearance, shares[-1], live, None), NOISE))
        return max(terms, key=lambda term: term[0])[1]

    def _term(self, appearance: str, share: float, live: tuple[int, ...], cause: int | None) -> float:
        for i in live:
            hit = self._claims[appearance][i].hit
            share *= hit if i == cause else 1.0 - hit
        return share
