"""What votes in the trials of ``plogic bench scale``, and how long each stage takes.

* ``Capped``: an index that looks at fewer entries
* ``Stages``: seconds of the processor a frame

Where the looks of an image are exchanged for others at random, each type meets it as another random type would: nothing
of it is there, and its votes are those of one more wrong type. A thousand types and a hundred exchanges are votes of
10^5 types.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.scale.recall import Standing
from geometry.frames import pose_error
from plogic.cycle.perception import attend, perceive
from plogic.cycle.state import Task
from plogic.match.gamma.data import data_of
from plogic.match.kinds import Models
from plogic.match.oriented.asked import typed_data
from plogic.match.oriented.oriented_models import OrientedModels, search_of
from plogic.match.oriented.oriented_search import USUAL, coarse_poses
from plogic.match.oriented.pair_index import MOST, PairIndex
from plogic.match.oriented.pair_votes import counted, raw_votes
from sensing.appearance import Gamma
from sensing.uncollected import uncollected

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from benchmarks.clutter.scenes import Trial
    from benchmarks.scale.types import Ready
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.oriented.oriented_search import Search
    from plogic.match.oriented.pair_votes import Votes

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

WIDTH = 128
"""Bytes of a descriptor, of which there are none."""
TURNED, AWAY = np.radians(30.0), 0.15
"""A vote is right that is of the right type, turned less, radians, and less far off, as a share of the distance:
refinement has to do the rest."""
ALL = 1 << 62


@dataclass(frozen=True, eq=False)
class Capped(PairIndex):
    """An index with its own limit ``most`` of entries that all queries find together.

    Without one it notes in ``asked`` how many they are.
    """

    most: int | None
    asked: list[int]

    def found(
        self, looks: tuple[Indices, Indices], angles: tuple[Floats, Floats], tolerance: float, most: int = MOST
    ) -> tuple[Indices, NDArray[np.uint64], NDArray[np.uint8]]:
        """As the index finds them."""
        if self.most is None:
            self.asked.append(len(super().found(looks, angles, np.inf, ALL)[0]))
        return super().found(looks, angles, tolerance, most if self.most is None else self.most)


class Stages(NamedTuple):
    """Seconds of the processor: of attention, of votes, of laying and refining, and of the rest of the cycle."""

    attention: float
    votes: float
    laying: float
    rest: float


class Seen(NamedTuple):
    """The result of one trial: whether a right vote was laid, whether the object was found, how many others accepted.

    ``place``: which share of the types attention put before the right one.
    """

    stages: Stages
    laid: bool
    found: bool
    false: int
    place: float


def capped(index: PairIndex, most: int | None) -> Capped:
    """The index with another limit; None leaves it."""
    return Capped(index.indices, index.looks, index.sights, index.key, index.entry, index.turned, most, [])


def seen(ready: Ready, trial: Trial) -> Seen:
    """One trial, stage by stage, then the whole cycle."""
    with uncollected():
        data = data_of(trial.gamma.appearances, trial.gamma.camera, WIDTH)
        times = [process_time()]
        attend(ready.indices.values(), data.types, ready.kb)
        times.append(process_time())
        search = _search(ready, data)
        raw = search.raw
        times.append(process_time())
        votes = counted(raw)
        times.append(process_time())
        search.proposals(data)
        times.append(process_time())
        cycle = perceive(Task(data, ready.kb, _models(ready), ready.dv))
        times.append(process_time())
    first, voting, counting, proposing, whole = np.diff(times).tolist()
    laying = max(0.0, proposing - counting)
    stages = Stages(first, voting + counting, laying, max(0.0, whole - voting - counting - laying))
    right = is_right(ready, votes, data, trial)
    best = np.argsort(-votes.weight, kind="stable")[: USUAL.laid]
    found = [_found(belief, trial) for belief in cycle.accepted]
    place = [row.type for row in cycle.attention].index(trial.truth.type) / len(cycle.attention)
    return Seen(stages, bool(right[best].any()), any(found), len(found) - sum(found), place)


def is_right(ready: Ready, votes: Votes, data: Data, trial: Trial) -> NDArray[np.bool_]:
    """(N,) which votes are near the true pose of the true type."""
    right = np.zeros(len(votes.kind), bool)
    own = np.flatnonzero(votes.kind == _kind(ready, trial))
    truth = trial.truth.camera_from_object
    distance = float(np.linalg.norm(truth[:3, 3]))
    errors = [pose_error(pose, truth) for pose in coarse_poses(ready.shared, votes.take(own), data)]
    right[own] = [turned <= TURNED and away <= AWAY * distance for turned, away in errors]
    return right


def standing_of(votes: Votes, right: NDArray[np.bool_], kind: int, types: int) -> Standing:
    """Where the best right vote stands; (N,) ``right``, of the type ``kind`` of so many."""
    own, best = votes.kind == kind, int(votes.weight[right].max(initial=0))
    wrong = votes.weight[own & ~right]
    return Standing(
        best, int((votes.weight[right] == best).sum()), int((wrong > best).sum()), int((wrong == best).sum()),
        np.bincount(votes.weight[~own]).astype(np.int64), types - 1,
    )  # fmt: skip


def standing(ready: Ready, trial: Trial) -> Standing:
    """Where the right vote stands."""
    return under_cap(ready, trial, MOST)


def under_cap(ready: Ready, trial: Trial, most: int) -> Standing:
    """Where the right vote stands where so many entries are looked at, at most."""
    data = data_of(trial.gamma.appearances, trial.gamma.camera, WIDTH)
    votes = _votes(ready, capped(ready.shared, most), data)
    return standing_of(votes, is_right(ready, votes, data, trial), _kind(ready, trial), len(ready.indices))


def entries(ready: Ready, trials: Sequence[Trial]) -> float:
    """Entries that a frame asks for, a type, mean."""
    index = capped(ready.shared, None)
    for trial in trials:
        _votes(ready, index, data_of(trial.gamma.appearances, trial.gamma.camera, WIDTH))
    return float(np.mean(index.asked)) / len(ready.indices)


def with_more(ready: Ready, trial: Trial, before: Standing, passes: int, rng: np.random.Generator) -> Standing:
    """The standing among the votes of so many times more types: the looks of the image are exchanged each time anew."""
    data = data_of(trial.gamma.appearances, trial.gamma.camera, WIDTH)
    looks, sigma = typed_data(data, ready.shared.looks).looks, _search(ready, data).asked.noise.angle
    for _ in range(passes):
        exchanged = np.where(looks < 0, looks, rng.permutation(len(ready.shared.looks))[looks])
        votes = counted(raw_votes(ready.shared, exchanged, data, sigma))
        before = before.joined(np.bincount(votes.weight).astype(np.int64), len(ready.indices))
    return before


def falsely_accepted(ready: Ready, gamma: Gamma, rng: np.random.Generator) -> int:
    """How many objects are accepted where the looks of the image were exchanged, so that nothing of it is there."""
    new = dict(
        zip(
            ready.shared.looks,
            np.array(ready.shared.looks)[rng.permutation(len(ready.shared.looks))].tolist(),
            strict=True,
        )
    )
    exchanged = Gamma(
        gamma.camera, tuple(replace(datum, type=new.get(datum.type, datum.type)) for datum in gamma.appearances)
    )
    data = data_of(exchanged.appearances, exchanged.camera, WIDTH)
    with uncollected():
        return len(perceive(Task(data, ready.kb, _models(ready), ready.dv)).accepted)


def _models(ready: Ready) -> Models:
    return Models({"oriented": OrientedModels(ready.indices, ready.shared)})


def _votes(ready: Ready, index: PairIndex, data: Data) -> Votes:
    return counted(raw_votes(index, typed_data(data, index.looks).looks, data, _search(ready, data).asked.noise.angle))


def _search(ready: Ready, data: Data) -> Search:
    search = search_of(ready.shared, data, ready.kb)
    if search is None:
        raise ValueError("no datum has an angle")
    return search


def _kind(ready: Ready, trial: Trial) -> int:
    return list(ready.indices).index(trial.truth.type)


def _found(belief: Hypothesis, trial: Trial) -> bool:
    turned, away = pose_error(belief.camera_from_object, trial.truth.camera_from_object)
    near = turned <= np.radians(5.0) and away <= 0.05 * np.linalg.norm(trial.truth.camera_from_object[:3, 3])
    return belief.object_type.name == trial.truth.type and bool(near)
