"""Δh of all types at once: pairs vote, full boxes are laid onto Γ as clouds, and the best apart climb.

* ``Search``: that in one Γ, again and again, on what is not claimed yet
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices
from plogic.match.gamma.data import Columns, Data
from plogic.match.hand.extend import poses_about
from plogic.match.judged.rivals import apart
from plogic.match.oriented.asked import Asked, poses_turned
from plogic.match.oriented.drawn import by_fours, climbed
from plogic.match.oriented.pair_index import PairIndex
from plogic.match.oriented.pair_votes import Raw, Votes, counted, raw_votes
from plogic.match.oriented.single_votes import FEWEST, single_votes

ALIKE = float(np.radians(15.0)), 0.08
"""Two poses of a type are alike that differ by less, radians, and share of the distance."""
TILTS, TILT = 8, np.radians(20.0)
"""In how many directions a pose is tilted, and by how much, radians."""
MORE_TILTS = np.radians([8.0, 20.0, 40.0])
"""By how much one is tilted before it is accepted, radians."""
TILTS_KEPT = 2
"""Of what comes of these, so many are judged."""


class Round(NamedTuple):
    """How far off a sight may be, as a share of the diameter; how many steps a pose climbs.

    And how many poses, no two alike, go on.

    ``squares``: of least squares a step; one leads on while all is coarse, more of them home.
    """

    share: float
    steps: int
    most: int
    squares: int = 1


def _home(most: int) -> tuple[Round, ...]:
    """The last rounds, down to the noise of the detector, and until a pose moves no more."""
    return Round(0.008, 3, most), Round(0.003, 3, most), Round(0.0, 10, most, 3)


class Width(NamedTuple):
    """How many go on: the heaviest votes, whose clouds are ``laid`` onto Γ, of these the ``best``, in rounds.

    Of the last, so many are ``tilted``.

    ``fours``: how many of the last, and of what comes of all sets of four that draw them.
    """

    laid: int
    best: int
    rounds: tuple[Round, ...]
    tilted: int
    fours: int = 0


USUAL = Width(2000, 300, (Round(0.1, 2, 100), Round(0.05, 3, 40), Round(0.02, 4, 16), *_home(12)), 3)
"""With the votes of pairs."""
DEEP = Width(
    60_000,
    8000,
    (Round(0.1, 2, 3000), Round(0.06, 3, 1500), Round(0.035, 4, 600), Round(0.02, 5, 300), *_home(300)),
    20,
    300,
)
"""With those of single data, where pairs led to nothing."""
FOURS, FEW = Round(0.05, 0, 600), Round(0.0, 10, 100, 3)
"""How far off what makes a four may be, and how many go on; how these climb, and how many are judged."""
TILTED = Round(0.05, 3, 0), Round(0.02, 3, 0), Round(0.006, 3, 0), Round(0.0, 10, 0, 3)
"""How what was tilted climbs again."""


class Proposal(NamedTuple):
    """``kind`` number of the type in the index; ``pose`` (4, 4) camera_from_object.

    ``worth`` its evidence, at all poses about it together.
    """

    kind: int
    pose: Floats
    worth: float


@dataclass(frozen=True)
class _Posed(Columns):
    """N poses of types ``kind`` (N,), of ``worth`` (N,).

    ``likely`` (N,) how many of their sights are matched, about.
    """

    kind: Indices
    poses: Floats
    worth: Floats
    likely: Floats


class Search:
    """The search for all types in one Γ: its pairs vote once, and what is claimed later is no longer counted.

    It works on Γ turned upright.

    ``unasked``: types of which single data were not asked, for there were too many.
    """

    def __init__(self, asked: Asked) -> None:
        self.asked, self.index = asked.upright(), asked.index
        self.deepened, self.unasked = False, 0
        self._deep = False

    def deepen(self) -> None:
        """Ask single data in place of pairs, the next time."""
        self._deep = self.deepened = True

    @cached_property
    def raw(self) -> Raw:
        """The votes of all pairs of Γ."""
        return raw_votes(self.index, self.asked.typed.looks, self.asked.data, self.asked.noise.angle)

    def proposals(self, left: Data) -> list[Proposal]:
        """The best poses of all types, best first, in what is ``left`` of the data."""
        taken = np.ones(len(self.asked.data.ids), bool)
        taken[left.rows] = False
        left = self.asked.data.only(~taken)
        self.asked.check()
        raw = self.raw.without(taken) if taken.any() else self.raw
        self.asked.check()
        votes, asked, width = counted(raw), self.asked.of(left), USUAL
        if self._deep:
            self._deep, width = False, DEEP
            types = _by_votes(votes, len(self.index.indices))
            votes, answered = single_votes(self.index, left, asked.noise, types, width.laid, asked.check)
            self.unasked = len(types) - answered
        found = _proposals(asked, votes, width)
        return [one._replace(pose=poses_turned(one.pose, -asked.turn)) for one in found]

    def tilted(self, name: str, pose: Floats, left: Data) -> list[Floats]:
        """The best poses (4, 4) that come of a type's pose at other tilts, in what is ``left`` of the data."""
        kind = next(i for i, index in enumerate(self.index.indices) if index.object_type.name == name)
        asked = self.asked.of(self.asked.data.only(np.isin(np.arange(len(self.asked.data.ids)), left.rows)))
        found = _tilted(asked, np.array([kind]), poses_turned(pose, asked.turn)[None], MORE_TILTS)
        return list(poses_turned(found.take(_apart(self.index, found, TILTS_KEPT)).poses, -self.asked.turn))


def _by_votes(votes: Votes, types: int) -> Indices:
    """All types (T,), those first that pairs vote for most."""
    most = np.zeros(types, np.intp)
    np.maximum.at(most, votes.kind, votes.weight)
    return np.argsort(-most, kind="stable")


def _proposals(asked: Asked, votes: Votes, width: Width) -> list[Proposal]:
    """The best poses of all types, best first, that ``votes`` lead to."""
    asked.check()
    votes = votes.take(np.argsort(-votes.weight, kind="stable")[: width.laid])
    found = _climbed(
        asked, votes.kind, coarse_poses(asked.index, votes, asked.data), Round(width.rounds[0].share, 0, 0)
    )
    found = found.take(np.argsort(-found.worth, kind="stable")[: width.best])
    for each in width.rounds:
        found = _climbed(asked, found.kind, found.poses, each)
        found = found.take(_apart(asked.index, found, each.most))
    best = found.take(slice(width.tilted))
    found = _Posed.joined([found, _tilted(asked, best.kind, best.poses, [TILT])])
    found = found.take(_apart(asked.index, found, len(found.kind)))
    if width.fours:
        found = _with_fours(asked, found, width.fours)
    sure = found.take(found.likely > FEWEST - 1)
    return [Proposal(*row) for row in zip(sure.kind.tolist(), sure.poses, sure.worth.tolist(), strict=True)]


def _climbed(asked: Asked, kind: Indices, poses: Floats, each: Round) -> _Posed:
    return _Posed(kind, *climbed(asked, kind, poses, each.share, each.steps, each.squares))


def _tilted(asked: Asked, kind: Indices, poses: Floats, tilts: Floats | list[float]) -> _Posed:
    """Of each pose (N, 4, 4) what comes of it at other tilts, radians.

    What is nearly flat, or far away, fits several.
    """
    poses = np.concatenate([turned_about(asked.index, kind, poses, tilt) for tilt in tilts])
    kind = np.tile(np.repeat(kind, TILTS), len(tilts))
    found = _Posed(kind, poses, np.zeros(len(kind)), np.zeros(len(kind)))
    for each in TILTED:
        found = _climbed(asked, found.kind, found.poses, each)
    return found


def _with_fours(asked: Asked, found: _Posed, most: int) -> _Posed:
    """The best of some poses and of what comes of all sets of four that may draw the first of them."""
    of = found.take(slice(most))
    fours = _climbed(asked, *by_fours(asked, of.kind, of.poses, FOURS.share), Round(0.0, FOURS.steps, 0))
    fours = fours.take(np.argsort(-fours.worth, kind="stable")[: FOURS.most])
    found = _Posed.joined([found, _climbed(asked, fours.kind, fours.poses, FEW)])
    return found.take(_apart(asked.index, found, FEW.most))


def turned_about(index: PairIndex, kind: Indices, poses: Floats, tilt: float) -> Floats:
    """(N · TILTS, 4, 4) each pose, tilted about its middle in so many directions."""
    from scipy.spatial.transform import Rotation

    around = 2.0 * np.pi * np.arange(TILTS) / TILTS
    turns = Rotation.from_rotvec(tilt * np.column_stack([np.cos(around), np.sin(around), np.zeros(TILTS)])).as_matrix()
    centres = np.repeat(index.centres[kind], TILTS, axis=0)
    other = np.repeat(poses, TILTS, axis=0)
    middle = np.einsum("nij,nj->ni", other[:, :3, :3], centres) + other[:, :3, 3]
    other[:, :3, :3] = np.tile(turns, (len(poses), 1, 1)) @ other[:, :3, :3]
    other[:, :3, 3] = middle - np.einsum("nij,nj->ni", other[:, :3, :3], centres)
    return other


def coarse_poses(index: PairIndex, votes: Votes, data: Data) -> Floats:
    """(N, 4, 4) camera_from_object: the cell's rotation and roll, about the ray through the object's centre."""
    own = index.cells[0].cell_from_object[votes.cell]  # the same of all types
    return poses_about(votes.centre, votes.roll, votes.scale, own, index.centres[votes.kind], data)


def _apart(index: PairIndex, found: _Posed, most: int) -> list[int]:
    """The best, of finite worth, no two of a type alike."""
    some = np.flatnonzero(np.isfinite(found.worth))
    kind, poses = found.kind[some], found.poses[some]
    middles = np.einsum("nij,nj->ni", poses[:, :3, :3], index.centres[kind]) + poses[:, :3, 3]
    return some[apart(poses, middles, found.worth[some], most, ALIKE, kind)].tolist()
