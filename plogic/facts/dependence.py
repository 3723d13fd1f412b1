"""Who can change whose probability: the graph over the hypotheses that makes the score reading well founded (§8).

Structure only, no numbers. Vocabulary:

* ``hiders``, the opaque hypotheses, no rivals, whose surface lies before a feature: ``("h2",)``
* ``Dependence.of["h1"] == ("h2", "h3")``: the presence of h2 and of h3 changes a cell of h1
* ``Dependence.blocks``: the strongly connected components; one of more than one hypothesis is decided jointly, over the
  states in which no two are ``Scene.apart``
* ``Dependence.left_out["h1"] == ("h9",)``: what was not looked at, since at most six occluders are (mode `drop`, and
  joint states)
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from plogic.base.errors import TooManyHypothesesError
from plogic.base.walk import by_key
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.situation import Reconsider, Situation

MOST_OCCLUDERS = 6
"""Occluders per hypothesis that a context lists (§8, mode `drop`)."""
LARGEST_BLOCK = 10
"""Hypotheses that one cyclic component may have: its joint states are 2 to that power."""


@dataclass(frozen=True)
class Scene:
    """A situation with its look-ups."""

    situation: Situation

    @cached_property
    def by_id(self) -> dict[str, Hypothesis]:
        """Each hypothesis under its id."""
        return {h.id: h for h in self.situation.hypotheses}

    @cached_property
    def _rivals(self) -> frozenset[tuple[str, str]]:
        """Both orders of every pair."""
        return self.situation.rivals | {(y, x) for x, y in self.situation.rivals}

    @cached_property
    def claimants(self) -> dict[str, list[tuple[Hypothesis, FeatureFact]]]:
        """Appearance id → the candidate features that are matched to it, in the order of Δh."""
        features = ((h, f) for h in self.situation.hypotheses for f in h.features)
        return by_key((f.match, (h, f)) for h, f in features if f.match is not None and h.expects(f))

    @cached_property
    def apart(self) -> frozenset[tuple[str, str]]:
        """The pairs, in both orders, that Σc forbids to be present together (A4, D8)."""
        pairs = self.situation.overlaps | self.situation.exclusive
        return pairs | {(y, x) for x, y in pairs}

    def rival(self, x: str, y: str) -> bool:
        """Whether the two never hide each other (§4.1)."""
        return (x, y) in self._rivals

    def hiders(self, h: Hypothesis, f: FeatureFact) -> tuple[str, ...]:
        """The hypotheses that hide the feature in every world in which they are present (D4, D7)."""
        return tuple(g for g in f.hidden_by if g != h.id and self.by_id[g].opaque and not self.rival(g, h.id))

    def robbers(self, h: Hypothesis, f: FeatureFact) -> list[tuple[Hypothesis, FeatureFact]]:
        """Features of others that claim this feature's appearance (mode `reassign`, §5.5)."""
        others = self.claimants.get(f.match, ()) if f.match is not None else ()
        return [(g, e) for g, e in others if g.id != h.id and not self.rival(g.id, h.id)]


@dataclass(frozen=True)
class Dependence:
    """The graph; ``of`` is closed: a hypothesis' probability depends on nothing else."""

    of: dict[str, tuple[str, ...]]
    blocks: tuple[tuple[str, ...], ...]
    left_out: dict[str, tuple[str, ...]]

    def outside(self, block: Iterable[str]) -> tuple[str, ...]:
        """What a block depends on beyond itself, in alphabetical order."""
        inside = set(block)
        return tuple(sorted({g for h in inside for g in self.of[h]} - inside))


def dependence(scene: Scene) -> Dependence:
    """The graph of the score reading; raises TooManyHypothesesError for a cycle that is too large."""
    return arranged(
        {h.id: _ordered_influences(scene, h) for h in scene.situation.hypotheses}, scene.situation.reconsider
    )


def arranged(wanted: dict[str, list[str]], reconsider: Reconsider) -> Dependence:
    """The graph from what can change a cell of each hypothesis, in the order of ``ordered``.

    Raises as ``dependence``.
    """
    limit = MOST_OCCLUDERS if reconsider == "drop" else len(wanted)
    of = {h: tuple(gs[:limit]) for h, gs in wanted.items()}
    blocks = _blocks(of)
    of = _limit_joint(of, blocks)
    left_out = {h: tuple([g for g in gs if g not in of[h]]) for h, gs in wanted.items() if len(gs) > len(of[h])}
    return Dependence(of, blocks, left_out)


def ordered(cells: dict[str, int]) -> list[str]:
    """Those who change most cells first, then by id."""
    return sorted(cells, key=lambda g: (-cells[g], g)) if len(cells) > 1 else list(cells)


def _ordered_influences(scene: Scene, h: Hypothesis) -> list[str]:
    """What can change a cell of ``h``: most cells first, then by id."""
    cells: dict[str, int] = {}
    for f in h.features:
        for g in _influences(scene, h, f):
            cells[g] = cells.get(g, 0) + 1
    return ordered(cells)


def _influences(scene: Scene, h: Hypothesis, f: FeatureFact) -> set[str]:
    mode, candidate = scene.situation.reconsider, h.expects(f)
    if mode == "drop":
        return set(scene.hiders(h, f)) if candidate and f.match is None else set()
    hidden = set(scene.hiders(h, f)) if candidate else set()
    if mode == "to_B" or not f.in_image or (candidate and not hidden):
        return hidden
    taken = {g for other, e in scene.robbers(h, f) for g in (other.id, *scene.hiders(other, e))}
    return (hidden | taken) - {h.id}


def _blocks(of: dict[str, tuple[str, ...]]) -> tuple[tuple[str, ...], ...]:
    settled = _settled(of)
    found: list[tuple[str, ...]] = [(h,) for h in settled]
    if len(settled) < len(of):
        found += _components({h: [g for g in gs if g not in settled] for h, gs in of.items() if h not in settled})
    blocks = tuple(sorted(found))
    for block in blocks:
        if len(block) > LARGEST_BLOCK:
            raise TooManyHypothesesError(
                f"{len(block)} hypotheses occlude each other in a cycle; at most {LARGEST_BLOCK} can be decided jointly"
            )
    return blocks


def _settled(of: dict[str, tuple[str, ...]]) -> set[str]:
    """Those who depend on no cycle: nobody, or only such."""
    settled: set[str] = set()
    waiting = of
    while ready := [h for h, gs in waiting.items() if settled.issuperset(gs)]:
        settled.update(ready)
        waiting = {h: gs for h, gs in waiting.items() if h not in settled}
    return settled


def _components(of: dict[str, list[str]]) -> list[tuple[str, ...]]:
    import networkx as nx

    return [tuple(sorted(block)) for block in nx.strongly_connected_components(nx.DiGraph(of))]


def _limit_joint(of: dict[str, tuple[str, ...]], blocks: tuple[tuple[str, ...], ...]) -> dict[str, tuple[str, ...]]:
    """Of what a cyclic block depends on outside itself, keep what most of its members depend on."""
    limited = dict(of)
    for block in (block for block in blocks if len(block) > 1):
        outside = [g for h in block for g in of[h] if g not in block]
        kept = set(sorted(set(outside), key=lambda g, o=outside: (-o.count(g), g))[:MOST_OCCLUDERS])  # type: ignore[misc]
        if len(kept) < len(set(outside)):
            limited.update({h: tuple(g for g in of[h] if g in block or g in kept) for h in block})
    return limited
