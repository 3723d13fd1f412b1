"""Types learned from meshes or photographs: each by its keypoints' words, which all types look up together."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.judged.type_models import Search, TypeModels
from plogic.match.learned.by_copies import searched
from plogic.match.learned.learned_index import learned_index
from plogic.match.learned.learned_poses import REFINED, generate
from plogic.match.learned.lexicon import lexicon_of
from plogic.match.learned.resting_poses import resting

if TYPE_CHECKING:
    from collections.abc import Generator, Mapping, Sequence
    from typing import Self

    from numpy.typing import NDArray

    from geometry.bodies.resting import Plane
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import Found, Given, Request, Setup
    from plogic.match.learned.learned_index import LearnedIndex

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
        return LearnedSearch(self.models, request.kb, request.processes)

    def resting(self, plane: Plane, left: Data, given: Given, request: Request) -> Generator[Found]:
        """The hypotheses of each type that stand on a plane."""
        taken = bodies(self.models, given.accepted)
        asked = [index for name, index in sorted(self.models.items()) if not given.count(name)]
        return searched(lambda index: resting(index, plane, left, request.kb, taken), asked, left, request.processes)

    def make_ready(self) -> None:
        """Compute all that the types compute when they are first asked for it."""
        for index in self.models.values():
            for name, made in vars(type(index)).items():
                if isinstance(made, cached_property):
                    getattr(index, name)


@dataclass(eq=False)
class LearnedSearch(Search):
    """The search in what is left of Γ; ``_searched``: the types searched for before, each with how many of it were accepted then."""

    models: Mapping[str, LearnedIndex]
    kb: KnowledgeBase
    processes: int
    _searched: dict[str, int] = field(default_factory=dict)

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each type; none of one of which nothing was accepted since it was searched for, for all of its poses were told then."""
        taken = bodies(self.models, given.accepted)
        expected = [name for name in names if self._searched.get(name) != given.count(name)]

        def search(index: LearnedIndex) -> Found:
            most = AGAIN if index.object_type.name in self._searched else REFINED
            return generate(index, left, self.kb, taken, refined=most)

        with closing(searched(search, [self.models[name] for name in expected], left, self.processes)) as searches:
            for name in names:
                if name not in expected:
                    yield []
                    continue
                found = next(searches)
                given.seen(found)
                yield found
                self._searched[name] = given.count(name)


def bodies(models: Mapping[str, LearnedIndex], accepted: Sequence[Hypothesis]) -> NDArray[np.float64]:
    """(N, 4) middles, camera frame, and inner radii of accepted objects of these types, m: what reaches nearer than that is in them (A4)."""
    rows = []
    for posed in accepted:
        index, pose = models.get(posed.object_type.name), posed.camera_from_object
        if index is not None:
            rows.append((*(pose[:3, :3] @ index.centre + pose[:3, 3]), index.inner_radius))
    return np.array(rows).reshape(-1, 4)
