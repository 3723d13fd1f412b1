"""From the cycle's beliefs to the typed ``Situation``: ids, facts between hypotheses, groups of rivals (§8).

The occlusion relations are those of hypotheses, and of their parts, that can be present together (§3.5-3.7). Of parts
those count that are objects and have a body (``kb.clouds.cloud``), each with the parts and the whole of every other
hypothesis; parts of one hypothesis are not compared. A part's body is taken alone: what else of its own object stands
before it is not looked at. The relation of two wholes is in ``relations_of``.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Mask
from geometry.camera import Camera
from geometry.connected import roots
from geometry.visibility.occlusion import PosedSurface, drawn, occlusion
from geometry.visibility.outline import Area
from geometry.visibility.roc import Roc
from kb.clouds.cloud import KnowledgeBase
from kb.surfaces.surface import Surface
from plogic.base.jobs import each
from plogic.cycle.lumped import compound_parts, counts, lumped, told, told_as, types_told
from plogic.cycle.placing import gravity_of_view, space_of_view
from plogic.cycle.planes import Setting
from plogic.cycle.stances import support_of_view
from plogic.cycle.state import Cycle, Trace
from plogic.facts.hypothesis import FeatureFact, Hypothesis, part_facts
from plogic.facts.pixel_table import PixelTable
from plogic.facts.situation import AppearanceFact, DvOver, PairFact, Reading, Reconsider, Situation, pair_facts
from plogic.facts.spatial import Space
from plogic.match.gamma.data import Data
from plogic.match.judged.evidence import as_fitted, clutter_density, judged
from plogic.match.judged.expectation import hidden_by
from plogic.match.judged.rivals import SHARED_CLAIMS, overlap, reaches_into, shared_claims
from plogic.match.judged.type_models import TypeModel
from sensing.uncollected import uncollected

Rated = tuple[Floats, Floats]
Fitted = Callable[[Hypothesis, Data, KnowledgeBase, Mask | None], Rated]


MOST_PART_PAIRS = 400
"""Pairs with a part in them that are looked at in one image, those of the first hypotheses first: the nearest to being
accepted."""


class Drawn(NamedTuple):
    """A posed body with its image."""

    surface: PosedSurface
    image: Area


def relations_of(
    posed: Mapping[str, Hypothesis], pairs: Sequence[tuple[str, str]], camera: Camera
) -> tuple[PairFact, ...]:
    """The occlusion relation of each pair of hypotheses with surfaces, and the ordered pair it is said of (§3.6)."""
    named = dict.fromkeys(name for pair in pairs for name in pair)
    bodies = {
        name: _drawn(surface, posed[name], camera)
        for name in named
        if (surface := posed[name].object_type.surface) is not None
    }
    some = [(x, y) for x, y in pairs if x in bodies and y in bodies]
    return tuple(
        fact
        for x, y in some
        for fact in pair_facts(_relation(bodies[x], bodies[y], camera), x, y, opaque=(posed[x].opaque, posed[y].opaque))
    )


def part_relations_of(
    posed: Mapping[str, Hypothesis], pairs: Sequence[tuple[str, str]], camera: Camera
) -> tuple[PairFact, ...]:
    """The same of the first ``MOST_PART_PAIRS`` pairs of nodes of which one at least is a part."""
    nodes = [(x, y, parts) for x, y in pairs for parts in _nodes(posed[x], posed[y])][:MOST_PART_PAIRS]
    asked = dict.fromkeys((name, part) for x, y, parts in nodes for name, part in zip((x, y), parts, strict=True))
    bodies = {(name, part): _drawn(_bodies(posed[name])[part], posed[name], camera) for name, part in asked}
    return tuple(
        fact
        for x, y, (p, q) in nodes
        for fact in pair_facts(
            _relation(bodies[x, p], bodies[y, q], camera), x, y, (p, q), (posed[x].opaque, posed[y].opaque)
        )
    )


def _nodes(x: Hypothesis, y: Hypothesis) -> list[tuple[str, str]]:
    """The pairs of nodes with bodies, but for that of the wholes."""
    return [(p, q) for p in _bodies(x) for q in _bodies(y) if p or q]


def _bodies(posed: Hypothesis) -> dict[str, Surface]:
    kind = posed.object_type
    return ({} if kind.surface is None else {"": kind.surface}) | kind.part_bodies


def _drawn(surface: Surface, posed: Hypothesis, camera: Camera) -> Drawn:
    placed = PosedSurface(surface.vertices, surface.triangles, surface.rays, posed.camera_from_object)
    return Drawn(placed, drawn(placed, camera))


def _relation(x: Drawn, y: Drawn, camera: Camera) -> Roc:
    return occlusion(x.surface, y.surface, camera, images=(x.image, y.image))


EVERY = 1000
"""Poses a type that ``unpruned`` refines and verifies: more than the search tells apart in one image."""


@dataclass(frozen=True)
class Options:
    """What a user can choose of one interpretation.

    ``end`` is the moment of ``time.monotonic`` at which the search stops; ``dv_over``: what ev is weighed by (§5.1).
    """

    reading: Reading = "score"
    reconsider: Reconsider = "to_B"
    smoothing: float = 0.0
    end: float | None = None
    dv_over: DvOver = "types"


@dataclass(frozen=True)
class Delta:
    """Δh with its ids, in the order h1, h2, ..., accepted ones first, and what decides its probabilities.

    ``dv`` of each feature type: what its ev are weighed by.
    """

    situation: Situation
    dv: Mapping[str, float] = field(default_factory=dict)

    @property
    def beliefs(self) -> dict[str, Hypothesis]:
        """The hypotheses by id."""
        return {hypothesis.id: hypothesis for hypothesis in self.situation.hypotheses}


@uncollected()
def delta_of(
    cycle: Cycle,
    data: Data,
    kb: KnowledgeBase,
    dv: Mapping[str, float],
    options: Options,
    fitted: Fitted = as_fitted,
    *,
    related: bool = True,
    models: Mapping[str, TypeModel] | None = None,
) -> Delta:
    """Name the hypotheses that were not rejected and collect the facts that decide their probabilities.

    ``fitted(posed, data, kb, hidden)`` gives the hit rates (F,) and densities (F,) that the program is told.
    ``models``: the types by name, by which it is known what they stand on; without them, nobody knows. Where gravity
    says what floats, that is not told: either weighs what a hypothesis rests on.
    ``related``: whether relations and space, which decide no probability of a world, are worked out as well.
    """
    posed = {f"h{i}": hypothesis for i, hypothesis in enumerate((*cycle.accepted, *cycle.considered), 1)}
    pairs = list(combinations(posed, 2))
    overlaps = frozenset(pair for pair in pairs if _share_volume(*(posed[name] for name in pair)))
    shared = {pair: shared_claims(posed[pair[0]], posed[pair[1]])[1] for pair in pairs if pair not in overlaps}
    exclusive = overlaps | {pair for pair, share in shared.items() if share > SHARED_CLAIMS}
    together = [pair for pair in pairs if pair not in exclusive] if related else []
    rivals = exclusive | {pair for pair, share in shared.items() if share > 0.0}
    hiding = {(x, y): hidden_by(posed[x], posed[y]) for x in posed for y in posed if x != y}
    posed = {name: some.told(hidden=_hidden(name, posed, hiding, rivals)) for name, some in posed.items()}
    group = instances({name: some.type for name, some in posed.items()}, exclusive)
    rates = {name: fitted(some, data, kb, some.hidden) for name, some in posed.items()}
    gravity = gravity_of_view(posed, overlaps, data.camera, kb)
    held = gravity is not None and bool(gravity.feet)  # what holds it weighs: where it stands weighs no second time
    rows = zip(data.ids, data.types, data.uv.tolist(), clutter_density(kb, data).tolist(), strict=True)
    hypotheses = tuple(
        _hypothesis(name, some, group[name], hiding, rates[name], data, dv) for name, some in posed.items()
    )
    return Delta(
        Situation(
            reading=options.reading,
            reconsider=options.reconsider,
            smoothing=options.smoothing,
            hypotheses=hypotheses,
            appearances=tuple(AppearanceFact(name, kind, (u, v), f) for name, kind, (u, v), f in rows),
            overlaps=overlaps,
            rivals=rivals,
            exclusive=exclusive,
            space=space_of_view(posed, overlaps, data.camera, kb, models or {}) if related else Space(),
            gravity=gravity,
            support=None if held else support_of_view(posed, Setting(models or {}, data.camera, kb), cycle.supported),
            relations=relations_of(posed, together, data.camera),
            part_relations=part_relations_of(posed, together, data.camera),
            priors={t.name: kb.rates.prior.get(t.name, 0.5) for t in kb.types},
            dv=types_told(dv, kb, hypotheses),
            dv_over=options.dv_over,
            rank={row.type: row.rank for row in cycle.attention},
            rules=kb.rules or "",
        ),
        dv,
    )


def pictured(delta: Delta, data: Data, models: Mapping[str, TypeModel], processes: int) -> Delta:
    """Δh, each hypothesis told what the photo says of it beside those that can be present with it (§9.10).

    ``processes`` share in looking.
    """
    if data.photo is None:
        return delta
    posed, overlaps = delta.beliefs, delta.situation.overlaps

    def looked(name: str) -> tuple[PixelTable | None, float | None]:
        some = posed[name]
        apart = {other for pair in overlaps if name in pair for other in pair}
        others = {y: g for y, g in posed.items() if y != name and y not in apart and g.group != some.group}
        told = models[some.type].pictured(some, others, data)
        return told.pixel_table, told.pose_probability

    with closing(each(looked, list(posed), processes)) as found:
        told = tuple(
            some.told(pixel_table=table, pose_probability=sure)
            for some, (table, sure) in zip(posed.values(), found, strict=True)
        )
    return replace(delta, situation=replace(delta.situation, hypotheses=told))


def _share_volume(one: Hypothesis, other: Hypothesis) -> bool:
    """A4: what the cycle told apart, and moved apart where it could be, to a millimetre.

    Open hypotheses as far as estimated poses go.
    """
    told = one.status != "open" and other.status != "open"
    return overlap(one, other) or (told and reaches_into(one, other))


def unpruned(
    data: Data, kb: KnowledgeBase, models: Iterable[TypeModel], dv: Mapping[str, float], options: Options, most: int
) -> Delta:
    """Δh before anything is accepted or rejected.

    Every distinct pose that the search comes to on the whole of Γ, the ``most`` of greatest worth.
    """
    found = [judged(posed, data, kb, dv) for model in models for _, posed in model.proposals(data, kb, EVERY)]
    best = tuple(sorted(found, key=lambda b: -b.worth)[:most])
    return delta_of(Cycle((), best, (), (), Trace()), data, kb, dv, options)


def instances(types: Mapping[str, str], exclusive: frozenset[tuple[str, str]]) -> dict[str, str]:
    """The instance that each hypothesis competes for, ``types`` by id: same type, connected by exclusion."""
    place = {name: i for i, name in enumerate(types)}
    first = roots(len(place), ((place[x], place[y]) for x, y in exclusive if types[x] == types[y]))
    number = {root: i for i, root in enumerate(sorted(set(first)), 1)}
    return {name: f"i{number[root]}" for name, root in zip(types, first, strict=True)}


def _hidden(
    name: str,
    posed: Mapping[str, Hypothesis],
    hiding: Mapping[tuple[str, str], Mask],
    rivals: frozenset[tuple[str, str]],
) -> Mask:
    """(F,) the features that accepted opaque hypotheses hide: its rivals hide nothing of it (D7).

    This is who hides what beside Δi, for the program's rates and for the cases of the document.
    """
    mask = np.zeros(len(posed[name].uv), dtype=bool)
    for other, some in posed.items():
        rival = other == name or (name, other) in rivals or (other, name) in rivals
        if not rival and some.status == "accepted" and some.opaque:
            mask |= hiding[name, other]
    return mask


def _hypothesis(
    name: str,
    posed: Hypothesis,
    group: str,
    hiding: Mapping[tuple[str, str], Mask],
    rates: tuple[Floats, Floats],
    data: Data,
    dv: Mapping[str, float],
) -> Hypothesis:
    others = [y for x, y in hiding if x == name]
    hits, near = rates
    features = tuple(
        FeatureFact(
            id=feature.name,
            type=feature.type,
            at=_triple(posed.at[f]),
            uv=(float(posed.uv[f, 0]), float(posed.uv[f, 1])),
            dv=float(dv[feature.type]) * counts(posed, f),
            in_image=bool(posed.in_image[f]),
            in_lobe=bool(posed.in_lobe[f]),
            self_hidden=bool(posed.self_hidden[f]),
            hidden_by=tuple(y for y in others if hiding[name, y][f]),
            match=data.ids[posed.matches[f]] if posed.matches[f] >= 0 else None,
            residual=float(posed.residual[f]) if posed.matches[f] >= 0 else None,
            density=float(near[f]),
            hit_rate=float(hits[f]),
            stands_for=counts(posed, f),
            learned_rate=None if posed.hit is None else round(float(posed.hit[f]), 4),
        )
        for f, feature in ((f, told_as(posed, f)) for f in told(posed))
    )
    return posed.told(
        id=name,
        group=group,
        features=features + lumped(posed, dv),
        parts=part_facts(posed.object_type) + compound_parts(posed),
    )


def _triple(row: Floats) -> tuple[float, float, float]:
    return float(row[0]), float(row[1]), float(row[2])
