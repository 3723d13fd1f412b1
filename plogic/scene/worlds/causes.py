"""What causes each appearance in one world: the fixed matchings (score), or their most probable assignment (posterior).

Sets of hypotheses are bits of a number, that of the i-th in Δh being 1 << i. A ``Claim`` is a candidate feature that is
matched to an appearance, with what hides it: ``Claim(0b1, "h1/roof/apex", 0.5, 0.05, 0.8, 0b110)``.
"""

from collections.abc import Sequence
from typing import NamedTuple

from plogic.base.bounds import alternative, bounded
from plogic.facts.hypothesis import Hypothesis
from plogic.scene.factors.weight_tables import Cast

NOISE = "noise"


class Claim(NamedTuple):
    """``label``: what the cause is called; ``residual`` in pixels, inf where there is none; ``density`` per pixel².

    ``hit`` h_F.
    """

    hypothesis: int
    label: str
    residual: float
    density: float
    hit: float
    hiders: int


class CauseTable:
    """The claims of every appearance of Γ, and which appearances the presence of a hypothesis can touch."""

    def __init__(self, cast: Cast) -> None:
        situation = cast.situation
        self._score = situation.reading == "score"
        self._clutter = {a.id: a.clutter for a in situation.appearances}
        self._bit = {h.id: 1 << i for i, h in enumerate(situation.hypotheses)}
        self._claims: dict[str, list[Claim]] = {a: [] for a in self._clutter}
        self._touched: dict[str, list[str]] = {name: [] for name in self._bit}
        self._relevant = dict.fromkeys(self._clutter, 0)
        self._known: dict[str, dict[int, str]] = {a: {} for a in self._clutter}
        self._shares: dict[str, list[float]] = {}
        for h in situation.hypotheses:
            self._add_claims(cast, h)

    def _add_claims(self, cast: Cast, h: Hypothesis) -> None:
        name, mine, bit = h.id, self._bit[h.id], self._bit
        for f in h.features:
            match = f.match
            if match is None or not h.expects(f):
                continue
            hiders = 0
            for g in cast.hiders(h, f) if f.hidden_by else ():
                hiders |= bit[g]
                self._touched[g].append(match)
            residual = float("inf") if f.residual is None else f.residual
            self._claims[match].append(Claim(mine, f"{name}/{f.id}", residual, f.density, bounded(f.hit_rate), hiders))
            self._touched[name].append(match)
            self._relevant[match] |= mine | hiders

    def causes(self, worlds: Sequence[Sequence[str]]) -> list[dict[str, str]]:
        """For each world: appearance → ``"h1/roof/apex"`` or ``"noise"``, exactly one for every appearance (trap a).

        Worlds differ in a few hypotheses: only what these touch is looked at anew.
        """
        if not worlds:
            return []
        first, known, relevant = set(worlds[0]), self._known, self._relevant
        base = sum(self._bit[name] for name in first)
        found = [{a: self._cause(a, base) for a in self._claims}]
        for world in worlds[1:]:
            changed = first.symmetric_difference(world)
            present = base ^ sum([self._bit[name] for name in changed])
            anew = set[str]().union(*[self._touched[name] for name in changed])
            found.append(found[0] | {a: known[a].get(present & relevant[a]) or self._cause(a, present) for a in anew})
        return found

    def _cause(self, appearance: str, present: int) -> str:
        """Only whether those are present matters who claim the appearance, or hide what does."""
        known, key = self._known[appearance], present & self._relevant[appearance]
        if key not in known:
            live = [i for i, c in enumerate(self._claims[appearance]) if key & c.hypothesis and not key & c.hiders]
            known[key] = (
                NOISE
                if not live
                else self._nearest(appearance, live)
                if self._score
                else self._likeliest(appearance, live)
            )
        return known[key]

    def _nearest(self, appearance: str, live: list[int]) -> str:
        """Where two expect the same appearance, the smaller residual takes it; then the earlier in Δh."""
        return min([self._claims[appearance][i] for i in live], key=lambda claim: claim.residual).label

    def _likeliest(self, appearance: str, live: list[int]) -> str:
        """The largest term of Σ_i N_i h_i Π_{j≠i}(1−h_j) + f Π_j(1−h_j); ties go to a claimant, the earliest in Δh."""
        claims, clutter = self._claims[appearance], self._clutter[appearance]
        if appearance not in self._shares:
            self._shares[appearance] = alternative([*[c.density for c in claims], clutter]) or [0.0] * (len(claims) + 1)
        shares = self._shares[appearance]
        most, likeliest = -1.0, NOISE
        for i in live:
            term = _term(shares[i], claims, live, i)
            if term > most:
                most, likeliest = term, claims[i].label
        return NOISE if _term(shares[-1], claims, live, None) > most else likeliest


def _term(share: float, claims: list[Claim], live: list[int], cause: int | None) -> float:
    for i in live:
        hit = claims[i].hit
        share *= hit if i == cause else 1.0 - hit
    return share
