"""What Γ says of poses, softly.

Each sight is drawn to every datum that looks like it, as much as that is likely to be its own.

The evidence of a pose is what ``plogic.match.judged.evidence`` says of it, but summed over what a datum may be of, at
all poses about it together (``plogic.match.judged.evidence``), and, to begin with, with a noise as wide as the
pose may be off: then it is smooth, and a pose can be moved towards it.

Poses climb that evidence: what draws them moves them, again and again, and the last on the way that is as good as any
is kept. Sets of four (§6.3): of all that may draw a pose some is clutter; so each four of it draw it by themselves, as
if the rest were not there. Where few data are an object's own, a pose that is drawn to the middle of right and wrong
ones climbs to neither.

* ``drawn(asked, kind, poses, share)``: of any number of poses at once
* ``shown(index, kind, poses)``: the sights that poses show: those whose lobe holds the viewpoint, of features that a
  cell near it shows
* ``climbed(asked, kind, poses, share, steps)``: any number of poses
* ``by_fours(asked, kind, poses, share)``: the poses that come of sets of four
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, lengths, summed
from geometry.frames import transform_points
from geometry.poses.reprojection import information
from kb.clouds.lobes import GRAIN
from plogic.match.gamma.data import centre_of, viewpoints_of
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.match.judged.evidence import share_of
from plogic.match.judged.expectation import AS_GOOD
from plogic.match.oriented.asked import Asked
from plogic.match.oriented.oriented_match import Held, Noise, met, refined
from plogic.match.oriented.pair_index import PairIndex
from plogic.match.oriented.pair_votes import BENT

NEAR = 3
"""Cells about a viewpoint: what any of them shows is shown, if its lobe holds the viewpoint; what a cell shows, a lobe
holds there."""


class Shown(NamedTuple):
    """S sights: ``pose`` (S,) which pose shows it, in order; ``feature`` (S,) whose it is.

    ``looks`` (S,) number of its appearance type.
    """

    pose: Indices
    feature: Indices
    looks: Indices


def shown(index: PairIndex, kind: Indices, poses: Floats) -> Shown:
    """The sights of poses (N, 4, 4) of types ``kind`` (N,)."""
    views = viewpoints_of(poses)
    along = (views - index.centres[kind]) @ index.cells[0].directions.T
    cells = np.argpartition(-along, NEAR - 1, axis=1)[:, :NEAR]
    lobes = index.lobes
    seen = np.zeros((len(kind), lobes.feature.shape[1]), bool)
    for one in np.unique(kind):
        rows, count = np.flatnonzero(kind == one), lobes.own[one]
        seen[rows, :count] = index.cells[one].visible[cells[rows].T].any(axis=0)[:, lobes.feature[one, :count]]
    pose, lobe = np.nonzero(seen)
    own = kind[pose], lobe
    feature = lobes.feature[own]
    view = views[pose] - index.points[kind[pose], feature]
    held = summed(view * lobes.axis[own]) >= lobes.cos_half[own] * lengths(view) - GRAIN
    return Shown(pose[held], feature[held], lobes.looks[own][held])


WIDE, DEVIATIONS = 0.1, 2.5
"""A share of the diameter is so many standard deviations; at ``WIDE``, the widest, angles are off by a whole cell's
``BENT``."""
WITHIN, MATCHED = 4.0, 3.0
"""Standard deviations, of places and of angles, within which a datum may be a sight's; and at the detector's own noise,
as the cycle matches."""
LEAST = 1e-3
"""Weight of a sight that draws a pose."""
NEAREST = 1e-6
"""Metres before the camera."""


class Drawn(NamedTuple):
    """Of N poses: ``held`` what draws them; ``noise`` and ``sigma`` (N,) how far off that may be.

    ``worth`` (N,) their evidence.

    ``likely`` (N,): how many sights are matched, each as much as it is likely to be.
    """

    held: Held
    noise: Noise
    sigma: Floats
    worth: Floats
    likely: Floats


class _Sights(NamedTuple):
    """S sights of N poses."""

    pose: Indices  # (S,)
    looks: Indices  # (S,)
    hit: Floats  # (S,) how often it is found
    points: Floats  # (S, 3) m, object frame
    turns: Floats  # (S, 3) x axes, object frame
    uv: Floats  # (S, 2) ideal pixels, far outside where the sight is not before the camera
    angle: Floats  # (S,) rad


class _Pairs(NamedTuple):
    """Sights and data that may be theirs."""

    sight: Indices  # (P,)
    away: Floats  # (P, 2) pixels from the sight to the datum
    bent: Floats  # (P,) rad
    likely: Floats  # (P,) h·N / f: how much likelier the datum is the sight's than clutter


def drawn(asked: Asked, kind: Indices, poses: Floats, share: float) -> Drawn:
    """Of poses (N, 4, 4) of types ``kind`` (N,), those whose sights may be off by a ``share`` of the diameter.

    And never by less than the noise.
    """
    index, camera = asked.index, asked.camera
    middle = np.einsum("nj,nj->n", poses[:, 2, :3], index.centres[kind]) + poses[:, 2, 3]
    across = np.where(middle > NEAREST, index.sights.diameter[kind] * camera.f / np.maximum(middle, NEAREST), 0.0)
    sigma = np.maximum(share * across / DEVIATIONS, asked.noise.pixels)
    noise = Noise(asked.noise.pixels, float(np.hypot(asked.noise.angle, BENT * share / WIDE)))
    sights = _sights(asked, kind, poses)
    pairs = _pairs(asked, sights, sigma, noise.angle, WITHIN if share > 0.0 else MATCHED)
    count = len(sights.pose)
    missed = 1.0 - sights.hit
    total = missed + np.bincount(pairs.sight, pairs.likely, count)
    explained = np.bincount(
        sights.pose, np.where(asked.inside(sights.uv) | (total > missed), np.log(total), 0.0), len(poses)
    )
    part = pairs.likely / total[pairs.sight]
    weight = np.bincount(pairs.sight, part, count).astype(float)
    held = _held(sights, pairs, part, weight, len(poses))
    worth = explained + _freedom(asked, kind, poses, held, noise, sigma)
    return Drawn(held, noise, sigma, worth, np.bincount(sights.pose, weight, len(poses)).astype(float))


def _sights(asked: Asked, kind: Indices, poses: Floats) -> _Sights:
    """Where the sights of the poses are on the screen, and how they are turned there."""
    index, camera = asked.index, asked.camera
    seen = shown(index, kind, poses)
    own = kind[seen.pose], seen.feature
    points, turns, rotation = index.points[own], index.turns[own], poses[seen.pose, :3, :3]
    at = np.einsum("sij,sj->si", rotation, points) + poses[seen.pose, :3, 3]
    front = at[:, 2] > NEAREST
    uv = at[:, :2] / np.where(front, at[:, 2], 1.0)[:, None] * camera.f + centre_of(camera)
    angle = screen_angle(np.einsum("sij,sj->si", rotation, turns), at)
    hit = asked.chances.hit[index.feature_types[1][own]]
    return _Sights(seen.pose, seen.looks, hit, points, turns, np.where(front[:, None], uv, -1e6), angle)


def _pairs(asked: Asked, sights: _Sights, sigma: Floats, spread: float, within: float) -> _Pairs:
    """All that are near enough; a datum is of that one of a pose's sights that it is likeliest to be of."""
    places, angles = asked.typed.places, asked.typed.angles
    sight, datum = asked.typed.of(sights.looks)
    coarse, at = (np.ascontiguousarray(rows.T, np.float32) for rows in (places, sights.uv))
    x, y = (coarse[axis][datum] - at[axis][sight] for axis in (0, 1))
    near = np.flatnonzero(x * x + y * y <= ((within * sigma[sights.pose]) ** 2).astype(np.float32)[sight])
    sight, datum = sight[near], datum[near]
    bent = wrapped(angles[datum] - sights.angle[sight])
    right = np.flatnonzero(np.abs(bent) <= within * spread)
    sight, datum, bent = sight[right], datum[right], bent[right]
    away, wide = places[datum] - sights.uv[sight], sigma[sights.pose[sight]]
    bell = np.exp(-0.5 * (summed(away * away) / wide**2 + (bent / spread) ** 2)) / (
        wide**2 * spread * np.sqrt(2.0 * np.pi)
    )
    likely = sights.hit[sight] * bell * asked.area / asked.chances.clutter[sights.looks[sight]]
    order = np.lexsort((-likely, datum, sights.pose[sight]))
    pose, of = sights.pose[sight[order]], datum[order]
    best = order[np.concatenate([np.ones(min(1, len(order)), bool), (pose[1:] != pose[:-1]) | (of[1:] != of[:-1])])]
    return _Pairs(sight[best], away[best], bent[best], likely[best])


def _held(sights: _Sights, pairs: _Pairs, part: Floats, weight: Floats, poses: int) -> Held:
    """Where each sight is drawn to: the mean of its data, each ``part`` (P,) as much as it is likely.

    Padded, a row a pose.
    """
    count = len(weight)
    some = np.flatnonzero(weight > LEAST)
    right, down, bent = (
        np.bincount(pairs.sight, part * off, count)[some] * (1.0 / weight[some]) for off in (*pairs.away.T, pairs.bent)
    )
    row = sights.pose[some]
    each = np.bincount(row, minlength=poses)
    column = np.arange(len(some)) - np.repeat(np.cumsum(each) - each, each)

    def padded(values: Floats) -> Floats:
        table = np.zeros((poses, max(1, int(each.max(initial=0))), *values.shape[1:]))
        table[row, column] = values
        return table

    uv, angle = sights.uv[some] + np.column_stack([right, down]), sights.angle[some] + bent
    return Held(*map(padded, (sights.points[some], sights.turns[some], uv, angle, weight[some])))


def _freedom(asked: Asked, kind: Indices, poses: Floats, held: Held, noise: Noise, sigma: Floats) -> Floats:
    """(N,) the logarithm of the share of all poses that fit about as well."""
    points, _, weight, across = met(poses, held, noise, asked.camera, sigma)
    at = transform_points(poses, points)
    middle = np.einsum("nij,nj->ni", poses[:, :3, :3], asked.index.centres[kind]) + poses[:, :3, 3]
    at[weight <= 0.0] = [0.0, 0.0, 1.0]
    middle[:, 2] = np.maximum(middle[:, 2], NEAREST)
    return share_of(information(at, middle, weight, asked.camera, across), middle[:, 2], asked.camera)


BLOCK, PAIRS, LEAST_DATA = 2000, 4_000_000, 16
"""Poses at a time, and sights and data that are compared, about; a sight is as much as so many data at least."""
STILL = 1e-8
"""Metres, and entries of the rotation, by which a pose moves that has arrived."""


def climbed(
    asked: Asked, kind: Indices, poses: Floats, share: float, steps: int, squares: int = 1
) -> tuple[Floats, Floats, Floats]:
    """Poses (N, 4, 4) of types ``kind`` (N,) after so many steps or fewer.

    Their evidence (N,), and how many sights are likely matched (N,).

    Their sights may be off by a ``share`` of the diameter. A step is so many ``squares``, steps of least squares,
    towards what draws the pose.
    """
    each = asked.index.sights.looks.shape[2] * max(LEAST_DATA, int(asked.typed.count.max(initial=0)))
    wide = max(1, min(BLOCK, PAIRS // max(1, each)))
    blocks = [(poses[:0], np.zeros(0), np.zeros(0))]
    for start in range(0, len(kind), wide):
        asked.check()
        blocks.append(_block(asked, kind[start : start + wide], poses[start : start + wide], share, steps, squares))
    moved, worth, likely = (np.concatenate(rows) for rows in zip(*blocks, strict=True))
    return moved, worth, likely


def _block(
    asked: Asked, kind: Indices, poses: Floats, share: float, steps: int, squares: int
) -> tuple[Floats, Floats, Floats]:
    best, worth, likely = poses.copy(), np.full(len(poses), -np.inf), np.zeros(len(poses))
    most, going = worth.copy(), np.arange(len(poses))
    for step in range(steps + 1):
        here = drawn(asked, kind[going], poses, share)
        better = here.worth > most[going] - AS_GOOD
        most[going] = np.maximum(most[going], here.worth)
        at = going[better]
        best[at], worth[at], likely[at] = poses[better], here.worth[better], here.likely[better]
        if step == steps:
            break
        moved = refined(poses, here.held, here.noise, asked.camera, steps=squares, sigma=here.sigma)
        further = np.abs(moved - poses).max(axis=(1, 2)) > STILL
        poses, going = moved[further], going[further]
        if not len(going):
            break
    return best, worth, likely


OF = 7
"""Fours are of so many sights of a pose, the likeliest."""
LIKELY = 0.005
"""How likely a sight is matched at least."""
STEPS = 6
"""Of least squares."""
FOURS_BLOCK = 500
"""Poses at a time."""
_FOURS = np.array(list(combinations(range(OF), 4)))


def by_fours(asked: Asked, kind: Indices, poses: Floats, share: float) -> tuple[Indices, Floats]:
    """Types (M,) and poses (M, 4, 4), M ≤ 35 N, of poses (N, 4, 4) of types ``kind`` (N,).

    Their sights may be off by a ``share`` of the diameter.
    """
    blocks = [
        _block_of_fours(asked, kind[start : start + FOURS_BLOCK], poses[start : start + FOURS_BLOCK], share)
        for start in range(0, len(kind), FOURS_BLOCK)
    ]
    return np.concatenate([kind[:0], *(own for own, _ in blocks)]), np.concatenate([poses[:0], *(p for _, p in blocks)])


def _block_of_fours(asked: Asked, kind: Indices, poses: Floats, share: float) -> tuple[Indices, Floats]:
    asked.check()
    held = drawn(asked, kind, poses, share).held
    weight = np.pad(held.weight, ((0, 0), (0, max(0, OF - held.weight.shape[1]))))
    column = np.argsort(-weight, axis=1, kind="stable")[:, _FOURS]  # (N, 35, 4)
    some = (weight[np.arange(len(kind))[:, None, None], column] > LIKELY).all(axis=2)
    of, four = np.nonzero(some)[0], column[some]
    if not len(of):
        return kind[:0], poses[:0]
    rows = of[:, None], four
    alone = Held(held.points[rows], held.turns[rows], held.uv[rows], held.angle[rows], np.ones(four.shape))
    return kind[of], refined(poses[of], alone, asked.noise, asked.camera, steps=STEPS)
