"""Types learned from meshes or photographs: each by its keypoints' words, which all types look up together.

* ``LearnedIndex``: a type made ready, its appearances as arrays. A ``plogic.match.judged.type_models.TypeModel``
* ``LearnedModels``: all types of this kind
* ``searched(search, indices, data, 2)``: what a search finds of each index; copies of this process share the work
"""

from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from geometry.bodies.resting import RestingFaces
from geometry.bodies.standing import Known
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud
from kb.clouds.words import POINT, SIDE
from plogic.base.jobs import each
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.evidence import evidence
from plogic.match.judged.expectation import polished, settled
from plogic.match.judged.type_models import SURE, Found, Given, Ranks, Request, Search, Setup, TypeModel, TypeModels
from plogic.match.learned.agreement import Lobes, lobes_of
from plogic.match.learned.convincing import demanded
from plogic.match.learned.keypoints import Lexicon, lexicon_of
from plogic.match.learned.learned_jobs import ask, searched
from plogic.match.learned.learned_match import ROBUST, matched, pose_of, precision
from plogic.match.learned.learned_pixels import Seen, hiding, looked_beside, pictured, stood
from plogic.match.learned.learned_poses import NOBODY, REFINED, VERIFIED, Voted, generate, voted
from plogic.match.learned.learned_standing import Place, Stood, on_supports
from plogic.match.learned.learned_views import (
    PRINTED,
    SEEN,
    VIEWS,
    draw,
    keypoints_shown,
    maps_for,
    seen_anywhere,
)
from plogic.measures.distinctiveness import Kinds, kinds_of, rank_of_kinds

if TYPE_CHECKING:
    from sensing.pixels.drawn import Paint
    from sensing.views.maps import PhotoMaps
    from sensing.views.search import Body


@dataclass(frozen=True, eq=False)
class LearnedIndex:
    """``points`` (F, 3) metres; ``weights`` (F,) dv; ``cloud`` with its L appearances.

    ``lexicon`` where they are looked up.
    """

    settled_when_found: ClassVar[bool] = True

    object_type: ObjectType
    cloud: LearnedCloud
    weights: Floats
    lexicon: Lexicon

    @property
    def points(self) -> Floats:
        """(F, 3) metres, object frame."""
        return self.cloud.at

    @cached_property
    def lobes(self) -> Lobes:
        """All lobes."""
        return lobes_of(self.cloud, np.arange(len(self.cloud.feature)), self.centre)

    @cached_property
    def lobes_of_points(self) -> Lobes:
        """Those of keypoints."""
        return lobes_of(self.cloud, np.flatnonzero(~self.cloud.sided), self.centre)

    @cached_property
    def lobes_of_sides(self) -> Lobes:
        """Those of sides of edges, the surest first."""
        sides = np.flatnonzero(self.cloud.sided)
        return lobes_of(self.cloud, sides[np.argsort(-self.cloud.hit[sides], kind="stable")], self.centre)

    @cached_property
    def anchors(self) -> Indices:
        """All features: each is as good as any to start from."""
        return np.arange(len(self.points))

    @cached_property
    def kinds(self) -> Kinds:
        """The features by their words."""
        return kinds_of(self.weights, [feature.type for feature in self.object_type.features])

    @cached_property
    def places(self) -> Floats:
        """(L, 3) where each appearance's feature is."""
        return self.cloud.at[self.cloud.feature]

    @cached_property
    def sided(self) -> Mask:
        """(F,) which features are sides of edges: so are all of their appearances."""
        result = np.zeros(len(self.points), bool)
        result[self.cloud.feature[self.cloud.sided]] = True
        return result

    @cached_property
    def looks(self) -> NDArray[np.float32]:
        """(L, 6) looks of each appearance that is the side of an edge, and how much the last of them varies.

        0 where there are no colours.
        """
        looks = self.cloud.descriptor[:, POINT : POINT + SIDE + 1].astype(np.float32)
        return looks if looks.shape[1] else np.zeros((len(looks), SIDE + 1), np.float32)

    @cached_property
    def centre(self) -> Floats:
        """(3,) middle of the features, object frame."""
        surface, points = self.object_type.surface, self.points
        return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2.0 if surface is None else surface.centre, float)

    @property
    def resting(self) -> RestingFaces:
        """The faces that it stands on."""
        return self.object_type.resting

    @cached_property
    def inner_radius(self) -> float:
        """Metres from ``centre`` to the nearest face that it can stand on, 0 without one."""
        away = self.resting.reach - self.resting.down @ self.centre
        return max(0.0, float(away.min())) if len(away) else 0.0

    @cached_property
    def diameter(self) -> float:
        """Metres across."""
        surface = self.object_type.surface
        return float(surface.diameter if surface is not None else np.linalg.norm(np.ptp(self.points, axis=0)))

    @cached_property
    def paint(self) -> "Paint | None":
        """Its mesh as it is painted; None where its file has no texture."""
        from sensing.pixels.drawn import Paint
        from sensing.simulated.body import read_mesh

        kind = self.object_type
        mesh = None if kind.mesh_file is None else read_mesh(kind.mesh_file, kind.mesh_scale)
        return None if mesh is None or mesh.texture is None else Paint(mesh)

    @cached_property
    def plain(self) -> bool:
        """Whether it has little print."""
        return keypoints_shown(self.cloud) < PRINTED

    @cached_property
    def body(self) -> "Body | None":
        """What it looks like from all around; None where it has no texture."""
        if self.paint is None:
            return None
        from geometry.files.remembered import cache_folder
        from sensing.views.kept import kept_views
        from sensing.views.search import Body

        return Body(kept_views(self.paint, VIEWS, cache_folder("views")), self.paint.middle, self.paint.diameter)

    def ranks(self, here: Counter[str], by_chance: Counter[str]) -> Ranks:
        """The ranks by counting words; a learned type has no neighbourhoods."""
        of_here, of_chance = (rank_of_kinds(self.weights, self.kinds, some) for some in (here, by_chance))
        return Ranks(of_here, of_chance, of_here)

    def proposals(self, data: Data, kb: KnowledgeBase, most: int) -> Found:
        """The hypotheses that the whole of Γ suggests, at most ``most`` of them refined."""
        return generate(self, data, kb, NOBODY, width=(most, most))

    def settle(
        self,
        pose: Floats | Hypothesis,
        data: Data,
        kb: KnowledgeBase,
        free: Mask | None = None,
        hidden: Mask | None = None,
        rounds: int = 2,
    ) -> Hypothesis:
        """The type at a pose, or one that is matched there already: matched (D7, D8), refined, and matched again.

        A pose that fits the pixels stays as it is.
        """
        if isinstance(pose, Hypothesis) and pose.pixels is not None and rounds:
            there = self.settle(pose.camera_from_object, data, kb, free, hidden, rounds=0)
            return there.told(**pose.beyond())
        return settled(
            pose,
            lambda pose: matched(self, pose_of(self, pose, data, kb), data, kb, free, hidden),
            lambda posed: polished(posed, self.points, precision(posed), data, hidden, ROBUST),
            rounds,
            lambda posed: evidence(posed, data, kb, hidden).ratio,
        )

    def beside(self, posed: Hypothesis, others: Sequence[Hypothesis], data: Data) -> Hypothesis:
        """A hypothesis told anew what its pixels say, where these others may hide it."""
        return looked_beside(self, posed, others, data)

    def pictured(self, posed: Hypothesis, others: Mapping[str, Hypothesis], data: Data) -> Hypothesis:
        """A hypothesis told what its pixels say by which of these others, by id, are present; and how sure its pose."""
        return pictured(self, posed, others, data)

    def significance(self, posed: Hypothesis) -> float:
        """All poses of a learned type are counted in its evidence; pixels tell of one of few that looks picked."""
        return SEEN if posed.pixels is not None else SURE


def learned_index(object_type: ObjectType, dv: Mapping[str, float], lexicon: Lexicon | None = None) -> LearnedIndex:
    """The index of a type with a learned cloud; dv 0 throughout counts every feature alike.

    Without a lexicon it has one of its own.
    """
    cloud = object_type.learned
    assert cloud is not None  # noqa: S101 - the caller looks
    weights = np.array([dv[feature.type] for feature in object_type.features])
    return LearnedIndex(
        object_type,
        cloud,
        weights if weights.any() else np.ones(len(weights)),
        lexicon or lexicon_of({object_type.name: cloud}),
    )


AGAIN = 40
"""Poses of a type whose sides are looked at where it is searched for again, after one of it was accepted."""


@dataclass(frozen=True, eq=False)
class LearnedModels(TypeModels):
    """``models``: the types by name."""

    models: Mapping[str, LearnedIndex]

    @classmethod
    def of(cls, setup: Setup) -> Self:
        """Make some types ready, which share one lexicon where the KB has words; nothing is kept in a folder."""
        clouds = {kind.name: kind.learned for kind in setup.types if kind.learned is not None}
        lexicon = lexicon_of(clouds, setup.kb.words.centroids) if setup.kb.words is not None else None
        return cls({kind.name: learned_index(kind, setup.dv, lexicon) for kind in setup.types})

    def search(self, request: Request) -> Search:
        """The search in one Γ, by this process and copies of it."""
        return LearnedSearch(self.models, request)

    def make_ready(self) -> None:
        """Compute all that the types compute when they are first asked for it."""
        for index in self.models.values():
            for name, made in vars(type(index)).items():
                if isinstance(made, cached_property) and name != "body":  # kept on disk, and only photos ask for it
                    getattr(index, name)


@dataclass(eq=False)
class LearnedSearch(Search):
    """The search in what is left of Γ.

    ``_searched``: the types searched for before, each with how many of it were accepted then; ``_seen``: the poses that
    the whole photo suggested of them; ``_odds``: what pixels told at most of each, and ``_demanded`` by that;
    ``_stood``: on what each was looked for.
    """

    models: Mapping[str, LearnedIndex]
    request: Request
    _searched: dict[str, int] = field(default_factory=dict)
    _seen: dict[str, Seen] = field(default_factory=dict)
    _odds: dict[str, float] = field(default_factory=dict)
    _demanded: float = SEEN
    _stood: dict[str, list[Stood]] = field(default_factory=dict)

    @cached_property
    def _voted(self) -> dict[str, Voted]:
        """What all of Γ votes for, of each type."""
        data, found = self.request.data, dict[str, Voted]()
        ask(self.models.values(), data)
        with closing(
            each(lambda index: voted(index, data), list(self.models.values()), self.request.processes)
        ) as some:
            for name, one in zip(self.models, some, strict=True):
                self.request.check()
                found[name] = one
        return found

    @cached_property
    def _maps(self) -> "PhotoMaps | None":
        """What the types with little print ask of the photo."""
        return maps_for(list(self.models.values()), self.request.data, self.request.processes)

    def votes(self) -> dict[str, float]:
        """The votes of the pairs of a type for its best pose."""
        return {name: float(of.votes.max(initial=0.0)) for name, of in self._voted.items()}

    def promising(self, names: Sequence[str], left: Data, given: Given) -> list[str]:  # noqa: ARG002 - all was asked before
        """Those not searched for yet, or since one was accepted: all poses of the others were told then."""
        return [name for name in names if self._searched.get(name) != given.count(name)]

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type."""
        taken, before = bodies(self.models, given.accepted), hiding(given.accepted)
        whole = len(left.ids) == len(self.request.data.ids)
        maps = self._maps

        def search(index: LearnedIndex) -> tuple[Found, Seen]:
            name = index.object_type.name
            most = AGAIN if name in self._searched else REFINED
            seen = self._seen[name] if name in self._seen else seen_anywhere(index, maps, self.request.data)
            found = generate(
                index,
                left,
                self.request.kb,
                taken,
                before=before,
                width=(most, VERIFIED),
                of=self._voted.get(name) if whole else None,
                seen=seen,
            )
            return found, seen

        indices = [self.models[name] for name in names]
        with closing(searched(search, indices, left, self.request.processes)) as searches:
            for name, (found, self._seen[name]) in zip(names, searches, strict=True):
                given.seen(found)
                best = max((posed.pixels for _, posed in found if posed.pixels is not None), default=-np.inf)
                self._odds[name] = max(best, self._odds.get(name, -np.inf))
                self._searched[name] = given.count(name)
                if len(self._odds) == len(self.models):
                    self.reckon({})
                yield found

    def reckon(self, odds: Mapping[str, float]) -> None:
        """Demand of pixels by how many of the types are there, as far as is known; ``odds``: the greatest of some."""
        self._demanded = demanded(np.array(list({**self._odds, **odds}.values())))

    def standing(self, supports: Sequence[Known], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type of which none is accepted, on planes or tops.

        Where it was looked for before, those alone that what was accepted since may hide.
        """
        place = Place(self.request, left, tuple(given.accepted), bodies(self.models, given.accepted), self._maps)
        asked = [self.models[name] for name in sorted(self.models) if not given.count(name)]
        if place.maps is not None:
            draw([index for index in asked if index.paint is not None], self.request.processes)

        def search(index: LearnedIndex) -> tuple[Found, list[Stood]]:
            return on_supports(index, supports, self._stood.get(index.object_type.name, ()), place)

        with closing(searched(search, asked, left, self.request.processes)) as searches:
            for index, (found, stood) in zip(asked, searches, strict=True):
                self._stood[index.object_type.name] = stood
                yield found

    def stood(self, posed: Hypothesis, known: Known, others: Sequence[Hypothesis]) -> Hypothesis:
        """A hypothesis moved to where contact with a plane and its pixels agree; as it was where no photo was asked."""
        return stood(self.models[posed.type], posed, known, others, self.request)

    def demanded(self, model: TypeModel, posed: Hypothesis) -> float:
        """Of what pixels tell so much less, the more of the types are there."""
        return model.significance(posed) if posed.pixels is None else self._demanded


def bodies(models: Mapping[str, LearnedIndex], accepted: Sequence[Hypothesis]) -> Floats:
    """(N, 4) middles, camera frame, and inner radii of accepted objects of these types, m.

    What reaches nearer than that is in them (A4).
    """
    held = [(models[some.type], some.camera_from_object) for some in accepted if some.type in models]
    rows = [(*(pose[:3, :3] @ index.centre + pose[:3, 3]), index.inner_radius) for index, pose in held]
    return np.array(rows).reshape(-1, 4)
