"""Hand-modelled types whose data are places alone: all are searched for at once (``plogic.match.hand.generate``).

* ``TypeIndex``: a type made ready: its view cells, its features' places and dv. A
  ``plogic.match.judged.type_models.TypeModel``
* ``HandModels``: all types of this kind
"""

from collections import Counter
from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import ClassVar, Self, TypeVar

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.bodies.resting import RestingFaces
from geometry.poses.refine import USUAL, Steps
from kb.clouds.cloud import KnowledgeBase, ObjectType, Rates
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data, project_ideal
from plogic.match.hand.distance_maps import Drawn
from plogic.match.hand.generate import ROBUST, Width, best_votes, generate, of_triples
from plogic.match.hand.links import MOST_PAIRS, feature_links
from plogic.match.hand.place_index import PlaceIndex, permutations, place_index, unique_sets
from plogic.match.hand.place_votes import Coarse
from plogic.match.hand.view_cells import ViewCells, view_cells
from plogic.match.judged.evidence import sigmas_of
from plogic.match.judged.expectation import matched, polished, pose_of, settled
from plogic.match.judged.type_models import SURE, Found, Given, Ranks, Request, Search, Setup, TypeModels
from plogic.measures.distinctiveness import compatible, rank

CELLS_TRIED = 24
"""View cells whose rank is taken for the tie-break of attention, about: every so many-th of them."""
EVERY = 8_000
"""Coarse poses that all features vote on where none is left out to save time."""
HOME = Steps(30)
"""Of the last least squares, where no match is lost by it: with few features and residuals that weigh less, eight end
half a millimetre from where they should, towards where they began."""
ANCHORS = 16
"""Features that seeds and pairs are made of: the most distinctive ones."""


@dataclass(frozen=True)
class TypeIndex:
    """One type made ready for search.

    ``points`` (F, 3) metres; ``weights`` (F,) dv; ``anchors`` feature indices, the most distinctive; ``links`` (N, 2)
    joined by edges.
    """

    settled_when_found: ClassVar[bool] = False
    object_type: ObjectType
    cells: ViewCells
    points: Floats
    weights: Floats
    anchors: Indices
    links: Indices

    @property
    def centre(self) -> Floats:
        """(3,) m, the middle of the features, object frame."""
        return self.cells.centre

    @property
    def resting(self) -> RestingFaces:
        """The faces that it stands on."""
        return self.object_type.resting

    @cached_property
    def turns(self) -> Floats:
        """(F, 3) x axes of the features' frames, object frame: what a datum's angle is on the screen."""
        return np.array([feature.rotation[:, 0] for feature in self.object_type.seen_features]).reshape(-1, 3)

    @cached_property
    def neighbourhoods(self) -> Mask:
        """(1 + C, F) all features, and what each of some view cells shows, evenly over the sphere."""
        step = max(1, len(self.cells.visible) // CELLS_TRIED)
        return np.concatenate([np.ones((1, len(self.weights)), bool), self.cells.visible[::step]])

    @cached_property
    def in_line(self) -> tuple[Indices, Floats, tuple[str, ...]] | None:
        """Where each feature has one appearance type.

        (1 + C, F) the how many-th of its type it is in each neighbourhood, the heaviest the first.

        Then (1 + C,) what each neighbourhood weighs, and (F,) the types' names; None where a feature looks like several
        types, or none.
        """
        looks = [sorted({a.type for a in feature.appearances}) for feature in self.object_type.seen_features]
        if any(len(names) != 1 for names in looks):
            return None
        flat = tuple(name for names in looks for name in names)
        codes = np.unique(np.array(flat), return_inverse=True)[1]
        place = np.argsort(np.argsort(-self.weights, kind="stable"), kind="stable")
        heavier = ((codes[:, None] == codes) & (place <= place[:, None])).astype(np.float32)
        return (
            (self.neighbourhoods.astype(np.float32) @ heavier.T).astype(np.intp),
            self.neighbourhoods @ self.weights,
            flat,
        )

    def ranks(self, here: Counter[str], by_chance: Counter[str]) -> Ranks:
        """The ranks among so many data of each type.

        Where each feature has one appearance type counting finds the best θ, else it is a matching.
        """
        if self.in_line is not None:
            counted, chance = self._counted(here), self._counted(by_chance, neighbourhoods=1)
            return Ranks(float(counted[0]), float(chance[0]), float(counted[1:].max(initial=0.0)))
        looks = [sorted({a.type for a in feature.appearances}) for feature in self.object_type.seen_features]
        whole, usual = (rank(self.weights, looks, some) for some in (here, by_chance))
        shown = (np.flatnonzero(seen).tolist() for seen in self.neighbourhoods[1:] if seen.any())
        some = (rank(self.weights[seen], [looks[f] for f in seen], here) for seen in shown)
        return Ranks(whole, usual, max(some, default=0.0))

    def _counted(self, there: Counter[str], neighbourhoods: int | None = None) -> Floats:
        """The rank within each of the first ``neighbourhoods`` where each feature has one appearance type.

        Of a type the heaviest that are there.
        """
        assert self.in_line is not None  # noqa: S101 - the caller looks
        number, whole, names = self.in_line
        number, whole, shown = number[:neighbourhoods], whole[:neighbourhoods], self.neighbourhoods[:neighbourhoods]
        matched = shown & (number <= np.array([there.get(name, 0) for name in names]))
        return np.asarray(np.minimum(1.0, matched @ self.weights / np.where(whole > 0.0, whole, 1.0)))

    def proposals(self, data: Data, kb: KnowledgeBase, most: int) -> Found:
        """The hypotheses that the whole of Γ suggests, at most ``most`` of them refined."""
        return generate(place_index([self]), data, kb, width=Width(EVERY, most, most))[self.object_type.name]

    def settle(
        self,
        pose: Floats | Hypothesis,
        data: Data,
        kb: KnowledgeBase,
        free: Mask | None = None,
        hidden: Mask | None = None,
        rounds: int = 2,
    ) -> Hypothesis:
        """The type at a pose, or one that is matched there already.

        Matched (D7, D8), refined on places, and matched again.
        """
        allowed, rates = self.allowed(data), kb.rates

        def match(pose: Floats) -> Hypothesis:
            posed = pose_of(self.object_type, pose, data, kb)
            return matched(posed, data, allowed, rates.match_tolerance, free, hidden)

        def better(posed: Hypothesis, steps: Steps = USUAL) -> Floats | None:
            return polished(posed, self.points, self.precision(rates), data, hidden, ROBUST, rates.sigma, steps)

        posed = settled(pose, match, better, rounds)
        home = better(posed, HOME) if rounds > 1 else None
        there = posed if home is None else match(home)
        return there if np.array_equal(there.matches, posed.matches) else posed

    def beside(self, posed: Hypothesis, others: Sequence[Hypothesis], data: Data) -> Hypothesis:  # noqa: ARG002 - its protocol's
        """What is matched says all of it."""
        return posed

    def pictured(self, posed: Hypothesis, others: Mapping[str, Hypothesis], data: Data) -> Hypothesis:  # noqa: ARG002 - its protocol's
        """No photo is asked."""
        return posed

    def significance(self, posed: Hypothesis) -> float:
        """By places alone the best of so many tries is good by luck: as many as there are pairs of data.

        Where angles count all poses are counted.
        """
        return SURE if posed.axes is not None else log(MOST_PAIRS)

    def precision(self, rates: Rates) -> Floats:
        """(F,) weights of the features in least squares: 1/σ², the KB's own σ being 1."""
        return np.asarray((rates.sigma / sigmas_of(self.object_type, rates)) ** 2)

    def allowed(self, data: Data) -> Mask:
        """(F, A) the data of a type that the feature has in any of its lobes."""
        (names, which), nobody = data.by_look, np.zeros(len(self.points), bool)
        looking = [self._features_by_look.get(name, nobody) for name in names]
        return np.array(looking, bool).reshape(len(names), len(nobody)).T[:, which]

    @cached_property
    def _features_by_look(self) -> dict[str, Mask]:
        types = [frozenset(a.type for a in feature.appearances) for feature in self.object_type.seen_features]
        names = sorted(frozenset().union(*types))
        return dict(zip(names, compatible(types, names).T, strict=True))


Made = TypeVar("Made", bound=TypeIndex)


def type_index(
    object_type: ObjectType,
    dv: Mapping[str, float],
    cells: ViewCells | None = None,
    made: type[Made] = TypeIndex,  # type: ignore[assignment]
) -> Made:
    """Build the index of one type; dv 0 throughout (one feature type in all of Σo) counts every feature alike.

    ``cells``, where they are known.
    """
    features = object_type.seen_features
    members = np.bincount(object_type.whole)[object_type.whole]  # a compound weighs as one (A1)
    weights = np.array([dv[object_type.features[w].type] for w in object_type.whole])
    weights = (weights if weights.any() else np.ones(len(features))) / members
    points = np.array([feature.at for feature in features]).reshape(-1, 3)
    links = feature_links(points, [feature.arms for feature in features])
    links = links[unique_sets(links, permutations(points, object_type.symmetries))]
    return made(object_type, cells or view_cells(object_type), points, weights, _anchors(weights), links)


def _anchors(weights: Floats) -> Indices:
    """The features at least half as distinctive as the best, or the ``ANCHORS`` best where those are below four."""
    order = np.argsort(-weights, kind="stable")[:ANCHORS]
    top = order[weights[order] >= 0.5 * weights.max()]
    return np.sort(top if len(top) >= 4 else order)


@dataclass(frozen=True, eq=False)
class HandModels(TypeModels):
    """``models``: the types by name."""

    models: Mapping[str, TypeIndex]

    @classmethod
    def of(cls, setup: Setup) -> Self:
        """Make some types ready; nothing is kept in a folder."""
        return cls({kind.name: type_index(kind, setup.dv) for kind in setup.types})

    @cached_property
    def places(self) -> PlaceIndex:
        """The index over all types."""
        return place_index(list(self.models.values()))

    def search(self, request: Request) -> Search:
        """The search for all types at once in one Γ, by this process alone: to copy it takes as long as to search."""
        return HandSearch(self.places, request)

    def make_ready(self) -> None:
        """Compute the index now."""
        self.places.make_ready()


WAVE = 10
"""Types that are refined together."""


@dataclass(eq=False)
class HandSearch(Search):
    """The search for all types at once in what is left of Γ.

    ``coarse``: the poses that triples of more data vote for; what was claimed later votes for none any more.
    """

    places: PlaceIndex
    request: Request
    at_once: ClassVar[int | None] = WAVE

    @cached_property
    def drawn(self) -> Drawn:
        """The maps of Γ."""
        return Drawn(self.request.data.whole)

    def votes(self) -> dict[str, float]:
        """The votes of all features that the best pose of triples or links shows."""
        return dict(zip(self.names, self._votes(self.request.data, ()).tolist(), strict=True))

    def promising(self, names: Sequence[str], left: Data, given: Given) -> list[str]:
        """Those of which a coarse pose finds more than it misses."""
        votes = dict(zip(self.names, self._votes(left, given.accepted).tolist(), strict=True))
        return [name for name in names if votes[name] > 0.0]

    @property
    def names(self) -> list[str]:
        """Of the types."""
        return [own.object_type.name for own in self.places.indices]

    def _votes(self, left: Data, accepted: Sequence[Hypothesis]) -> Floats:
        """(T,) the best in some data, beside what is accepted."""
        covered = covered_by(accepted, left)
        return best_votes(self.places, left, self.coarse, covered, self.drawn, self.request.check)

    @cached_property
    def coarse(self) -> Coarse:
        """The coarse poses of all types that triples of Γ vote for."""
        return of_triples(self.places, self.request.data, self.drawn, self.request.check)

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type, settled; what accepted objects cover is not missed."""
        found = self._found(names, left, given) if names else {}
        for name in names:
            given.seen(found[name])
            yield found[name]

    def _found(self, names: Sequence[str], left: Data, given: Given) -> dict[str, Found]:
        every = self.places.indices
        asked = [number for number, own in enumerate(every) if own.object_type.name in names]
        some = self.places if len(asked) == len(every) else place_index([every[number] for number in asked])
        return generate(
            some,
            left,
            self.request.kb,
            covered_by(given.accepted, left),
            coarse=self.coarse.of(asked),
            drawn=self.drawn,
            check=self.request.check,
        )


def covered_by(posed: Iterable[Hypothesis], data: Data) -> Mask:
    """(H, W) where the opaque ones of some objects stand in the ideal image: what is there may well be hidden."""
    import cv2

    mask = np.zeros((data.camera.height, data.camera.width), dtype=np.uint8)
    for some in posed:
        surface = some.object_type.surface
        if surface is not None and some.object_type.opaque:
            corners = project_ideal(some.camera_from_object[None], surface.vertices, data)[0]
            for triangle in np.rint(corners[surface.triangles]).astype(np.int32):
                cv2.fillConvexPoly(mask, triangle, 1)
    return mask.astype(bool)
