"""Δh of all types at once: pairs vote, the fullest boxes are laid onto Γ as whole clouds, the best that are apart are refined on what agrees."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.inference.clock import unhurried
from plogic.search.alike import apart
from plogic.search.angles import screen_angle
from plogic.search.data import centre_of
from plogic.search.extend import poses_about
from plogic.search.oriented.pair_votes import BENT, counted, raw_votes
from plogic.search.oriented.refinement import Held, Noise, refined
from plogic.search.oriented.single_votes import FEWEST, HIT, single_votes
from plogic.search.oriented.typed_data import typed_data
from plogic.search.projection import viewpoints_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.oriented.pair_index import PairIndex
    from plogic.search.oriented.pair_votes import Raw, Votes
    from plogic.search.oriented.typed_data import TypedData

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

ALIKE = float(np.radians(15.0)), 0.08
"""Two poses of a type are alike that differ by less, radians, and share of the distance."""
SHARES = 0.10, 0.05, 0.025, 0.0
"""How far off a sight may be in each round, in diameters on the screen, and never less than the noise allows."""
DEVIATIONS = 2.5
"""Standard deviations within which a datum is a sight's."""
STEPS = 8
"""Steps of a round of refinement."""
ROBUST = 3.0
"""Standard deviations of a place beyond which a match weighs less."""
TILTED, TILTS, TILT = 3, 8, np.radians(20.0)
"""Poses that are tried with other tilts, the best; in how many directions, and by how much, radians."""
MORE_TILTS = np.radians([8.0, 20.0, 40.0])
"""By how much one is tilted before it is accepted, radians."""
TILTS_KEPT = 2
"""Of what comes of these, so many are judged."""


class Width(NamedTuple):
    """How many go on: the heaviest votes, whose clouds are ``laid`` onto Γ; the best poses, no two alike, that are ``refined``; and in ``rounds``."""

    laid: int
    refined: int
    rounds: tuple[int, int, int, int]


USUAL, DEEP = Width(2000, 40, (24, 16, 12, 12)), Width(20_000, 400, (240, 160, 120, 12))
"""With the votes of pairs; and with those of single data, where pairs led to nothing."""
BLOCK = 2000
"""Clouds that are laid onto Γ at a time."""


class Proposal(NamedTuple):
    """``kind`` number of the type in the index; ``pose`` (4, 4) camera_from_object; ``worth`` about ln of how much likelier Γ is with it."""

    kind: int
    pose: Floats
    worth: float


class _Match(NamedTuple):
    points: Floats  # (N, V, 3) m, object frame
    turns: Floats  # (N, V, 3) x axes of the features, object frame
    datum: Indices  # (N, V), −1 for none
    worth: Floats  # (N,)

    def take(self, which: list[int]) -> _Match:
        """Those of some poses."""
        return _Match(self.points[which], self.turns[which], self.datum[which], self.worth[which])


class Search:
    """The search for all types in one Γ: its pairs vote once, and what is claimed later is no longer counted.

    ``check`` is called between its stages, and may raise to end it; ``laid``: how many votes were laid onto Γ at a time, at most; ``unasked``: types
    of which single data were not asked, for there were too many.
    """

    def __init__(self, index: PairIndex, data: Data, noise: Noise, check: Callable[[], None] = unhurried) -> None:
        self.index, self.data, self.noise, self.check = index, data, noise, check
        self.laid, self.unasked = USUAL.laid, 0
        self._deep = False

    @property
    def deepened(self) -> bool:
        """Whether single data were asked, or are next."""
        return self.laid >= DEEP.laid

    def deepen(self) -> None:
        """Ask single data in place of pairs, the next time."""
        self._deep, self.laid = True, DEEP.laid

    @cached_property
    def raw(self) -> Raw:
        """The votes of all pairs of Γ."""
        return raw_votes(self.index, typed_data(self.data, self.index.looks).looks, self.data, self.noise.angle)

    def proposals(self, left: Data) -> list[Proposal]:
        """The best poses of all types, refined, best first, in what is ``left`` of the data."""
        taken = np.ones(len(self.data.ids), bool)
        taken[left.rows] = False
        self.check()
        raw = self.raw.without(taken) if taken.any() else self.raw
        self.check()
        votes = counted(raw)
        if not self._deep:
            return _proposals(self.index, left, self.noise, votes, USUAL, self.check)
        self._deep = False
        types = _by_votes(votes, len(self.index.indices))
        votes, asked = single_votes(self.index, left, self.noise, types, DEEP.laid, self.check)
        self.unasked = len(types) - asked
        return _proposals(self.index, left, self.noise, votes, DEEP, self.check)

    def tilted(self, name: str, pose: Floats, left: Data) -> list[Floats]:
        """The best poses (4, 4) that come of a type's pose at other tilts, refined on what is ``left`` of the data."""
        kind = next(i for i, index in enumerate(self.index.indices) if index.object_type.name == name)
        poses = np.concatenate([_tilted(self.index, np.array([kind]), pose[None], tilt) for tilt in MORE_TILTS])
        typed = typed_data(left, self.index.looks)
        _, poses = _narrowed(self.index, np.full(len(poses), kind), poses, typed, left, self.noise, _rounds(USUAL)[1:], self.check)
        return list(poses[:TILTS_KEPT])


def _by_votes(votes: Votes, types: int) -> Indices:
    """All types (T,), those first that pairs vote for most."""
    most = np.zeros(types, np.intp)
    np.maximum.at(most, votes.kind, votes.weight)
    return np.argsort(-most, kind="stable")


def _rounds(width: Width) -> tuple[tuple[float, int], ...]:
    """Of each round how far off a sight may be, and how many poses go on; what was refined before needs the later ones only."""
    return tuple(zip(SHARES, width.rounds, strict=True))


def _proposals(index: PairIndex, data: Data, noise: Noise, votes: Votes, width: Width, check: Callable[[], None]) -> list[Proposal]:
    """The best poses of all types, refined, best first, that ``votes`` lead to."""
    check()
    typed = typed_data(data, index.looks)
    votes = votes.take(np.argsort(-votes.weight, kind="stable")[: width.laid])
    kind, poses = votes.kind, coarse_poses(index, votes, data)
    worth = np.zeros(len(kind))
    for start in range(0, len(kind), BLOCK):
        check()
        some = slice(start, start + BLOCK)
        worth[some] = _laid(index, kind[some], poses[some], typed, data, SHARES[0], noise).worth
    best = _apart(index, kind, poses, worth, width.refined)
    kind, poses = _narrowed(index, kind[best], poses[best], typed, data, noise, _rounds(width), check)
    tilted = np.concatenate([poses, _tilted(index, kind[:TILTED], poses[:TILTED])])
    kind = np.concatenate([kind, np.repeat(kind[:TILTED], TILTS)])
    kind, poses = _narrowed(index, kind, tilted, typed, data, noise, _rounds(USUAL)[1:], check)
    worth = _laid(index, kind, poses, typed, data, 0.0, noise).worth
    best = _apart(index, kind, poses, worth, len(poses))
    return [Proposal(int(kind[i]), poses[i], float(worth[i])) for i in best]


def _narrowed(
    index: PairIndex,
    kind: Indices,
    poses: Floats,
    typed: TypedData,
    data: Data,
    noise: Noise,
    rounds: tuple[tuple[float, int], ...],
    check: Callable[[], None],
) -> tuple[Indices, Floats]:
    """Matched and refined in rounds of shrinking tolerance, the best that are apart going on."""
    for share, most in rounds:
        check()
        match = _laid(index, kind, poses, typed, data, share, noise)
        best = _apart(index, kind, poses, match.worth, most)
        kind, poses, match = kind[best], poses[best], match.take(best)
        if not len(poses):
            break
        found = match.datum >= 0
        held = Held(match.points, match.turns, data.uv[match.datum], data.angle[match.datum], found.astype(float))
        poses = refined(poses, held, noise, data.camera, steps=STEPS, robust=ROBUST)
    return kind, poses


def _tilted(index: PairIndex, kind: Indices, poses: Floats, tilt: float = TILT) -> Floats:
    """(N · TILTS, 4, 4) each pose, turned about its middle: what is nearly flat, or far away, fits several tilts."""
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


def _laid(index: PairIndex, kind: Indices, poses: Floats, typed: TypedData, data: Data, share: float, noise: Noise) -> _Match:
    """What agrees with poses (N, 4, 4) of types ``kind`` (N,), of the sights that the nearest cell shows."""
    sights, centres = index.sights, index.centres[kind]
    towards = viewpoints_of(poses) - centres
    cell = (towards @ index.cells[0].directions.T).argmax(axis=1)
    feature, looks = sights.feature[kind, cell].astype(np.intp), sights.looks[kind, cell].astype(np.intp)
    points, turns = index.points[kind[:, None], feature], index.turns[kind[:, None], feature]
    at = np.einsum("nij,nvj->nvi", poses[:, :3, :3], points) + poses[:, None, :3, 3]
    front = at[..., 2] > 1e-6
    depth = np.where(front, at[..., 2], 1.0)
    uv = at[..., :2] / depth[..., None] * data.camera.f + centre_of(data.camera)
    angle = screen_angle(np.einsum("nij,nvj->nvi", poses[:, :3, :3], turns), at)
    middle = np.maximum(np.einsum("nj,nj->n", poses[:, 2, :3], centres) + poses[:, 2, 3], 1e-6)
    within = np.maximum(share * sights.diameter[kind] * data.camera.f / middle, DEVIATIONS * noise.pixels)
    sigma, spread = within[:, None] / DEVIATIONS, float(np.hypot(noise.angle, BENT * share / SHARES[0]))
    datum, off, bent = typed.nearest(uv, looks, angle, within, DEVIATIONS * spread)
    datum[(looks < 0) | ~front] = -1
    inside = (looks >= 0) & front & (uv >= 0.0).all(axis=2) & (uv[..., 0] < data.camera.width) & (uv[..., 1] < data.camera.height)
    bell = np.exp(-0.5 * ((off / sigma) ** 2 + (bent / spread) ** 2)) / (2.0 * np.pi * sigma**2 * np.sqrt(2.0 * np.pi) * spread)
    clutter = np.maximum(typed.count[looks], 1) / (data.camera.width * data.camera.height * 2.0 * np.pi)
    gain = np.where(datum >= 0, np.log1p(HIT * (bell / clutter - 1.0)), np.where(inside, np.log1p(-HIT), 0.0))
    worth = np.where((datum >= 0).sum(axis=1) >= FEWEST, gain.sum(axis=1), -np.inf)
    return _Match(points, turns, datum, worth)


def _apart(index: PairIndex, kind: Indices, poses: Floats, worth: Floats, most: int) -> list[int]:
    """The best, of finite worth, no two of a type alike."""
    some = np.flatnonzero(np.isfinite(worth))
    middles = np.einsum("nij,nj->ni", poses[some, :3, :3], index.centres[kind[some]]) + poses[some, :3, 3]
    return some[apart(poses[some], middles, worth[some], most, ALIKE, kind[some])].tolist()
