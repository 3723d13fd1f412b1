"""Coarse poses of all types that are known by places alone, from triples of neighbours in the image (§6.3).

Each triple of appearances is laid onto every triple of features of any type that looks like it. With A the affine map
from the plane of the features to the image, the greater eigenvalue of AᵀA is the squared scale, and the lesser one's
direction and size tell the slant, up to a reflection (Huttenlocher and Ullman 1990). Of these poses those are left
whose view cell shows the three, and the other features vote.

* ``Coarse``: N poses of any types
* ``coarse_poses(index, data, ...)``: the best of them by votes
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask, lengths
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Columns, Data, blocks, centre_of, viewpoints_of
from plogic.match.gamma.grid import taken
from plogic.match.hand.distance_maps import DistanceMaps
from plogic.match.hand.place_index import FLAT, PROBES, PlaceIndex, Triples

Singles = NDArray[np.float32]

NEIGHBOURS = 24, 12
"""Nearest data among which the other two of a triple are sought: the more where all their pairs can be looked at."""
NEAREST = 1.0
"""Pixels between two of a triple at least."""
FLATTEST = np.cos(np.radians(78.0)) ** 2
"""Least foreshortening, squared: a wall seen at more than 78° shows nothing."""
MOST, MOST_OF_TYPE = 60_000, 30_000
"""Pairs of triples that are looked at, and so many more a type: half of them the rarest, the others evenly of the rest
(§5.1)."""
BLOCK = 1 << 14
"""Pairs of triples at a time: about 8 MB."""
SMALLEST, LARGEST = 12.0, 2.0
"""Pixels across, and image heights, of an object at least and at most."""
EARLY, GO_ON = 5, 0.5
"""Probes that vote first, and the share of the poses that the others vote on, too."""
REACH, SHARP = np.float32(0.1), np.float32(4.0)
"""Share of the size within which a datum is near; half of a vote is for coming so many times nearer."""
NEAREST_DEPTH = np.float32(1e-6)
"""Metres before the camera of what is seen."""
MISSED = np.float32(0.4)
"""What a feature without a datum near takes from the votes, against what one with a datum at its place gives."""


class Coarse(NamedTuple):
    """``kind`` (N,) types; ``poses`` (N, 4, 4) camera_from_object, the best by votes first."""

    kind: Indices
    poses: Singles

    def of(self, kinds: Sequence[int]) -> "Coarse":
        """Those of some types, by number, which are numbered in this order."""
        number = np.full(int(max(self.kind.max(initial=0), *kinds)) + 1, -1)
        number[list(kinds)] = np.arange(len(kinds))
        some = np.flatnonzero(number[self.kind] >= 0)
        return Coarse(number[self.kind[some]], self.poses[some])


@dataclass(frozen=True)
class _Voted(Columns):
    kind: Indices  # (N,)
    poses: Singles  # (N, 4, 4)
    votes: Singles  # (N,)


@dataclass(frozen=True)
class ImageTriples(Columns):
    """``data`` (N, 3); ``key`` (N,) as in ``Triples``; ``frame`` (N, 3, 3) turns the optical axis to the first's ray.

    ``sides`` (N, 2, 2): columns are the second and third from the first in the plane square to that ray, tangents.
    """

    data: Indices
    key: NDArray[np.int64]
    frame: Singles
    sides: Singles


def image_triples(
    index: PlaceIndex, data: Data, neighbours: int, check: Callable[[], None] = unhurried
) -> ImageTriples:
    """The triples of so many neighbouring data that some feature looks like, by their looks in increasing order.

    ``check`` is called between blocks of them, and may raise to end it.
    """
    names, which = data.by_look
    looks = np.array([index.number_of.get(name, -1) for name in names], np.intp)[which]
    members = np.argsort(looks, kind="stable")[np.count_nonzero(looks < 0) :]
    three, count = _neighbouring(data.ideal[members], neighbours, check), len(index.looks)
    rays = np.concatenate(
        [(data.ideal[members] - centre_of(data.camera)) / data.camera.f, np.ones((len(members), 1))], axis=1
    )[three]
    rays /= lengths(rays)[..., None]
    frame = turn_z_to(rays[:, 0])
    local = np.einsum("nji,nkj->nki", frame, rays[:, 1:])
    return ImageTriples(
        members[three],
        looks[members[three]] @ np.array([count * count, count, 1]),
        frame.astype(np.float32),
        np.swapaxes(local[..., :2] / local[..., 2:], 1, 2).astype(np.float32),
    )


def _neighbouring(places: Floats, neighbours: int, check: Callable[[], None]) -> Indices:
    """(N, 3) numbers of neighbouring places (M, 2), increasing, no slivers."""
    near = np.zeros((len(places), max(0, min(neighbours, len(places) - 1))), np.intp)
    for some in blocks(len(places), len(places)):
        check()
        step = places[None] - places[some][:, None]
        near[some] = np.argsort(np.hypot(step[..., 0], step[..., 1]), axis=1, kind="stable")[:, 1 : neighbours + 1]
    one, other = np.array(list(combinations(range(near.shape[1]), 2)), dtype=np.intp).reshape(-1, 2).T
    first = np.repeat(np.arange(len(places)), len(one))
    three = np.unique(np.sort(np.column_stack([first, near[:, one].ravel(), near[:, other].ravel()]), axis=1), axis=0)
    u, v = (places[three[:, k]] - places[three[:, 0]] for k in (1, 2))
    size = lengths(u) * lengths(v)
    wide = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) >= FLAT * size
    return np.asarray(three[wide & (np.minimum(lengths(u), lengths(v)) > NEAREST)])


def turn_z_to(ray: Floats) -> Floats:
    """(N, 3, 3) smallest rotations that take the optical axis to unit rays (N, 3) in front of the camera."""
    x, y, z = ray.T
    k = 1.0 / (1.0 + z)
    rows = [[1.0 - k * x * x, -k * x * y, x], [-k * x * y, 1.0 - k * y * y, y], [-x, -y, z]]
    return np.moveaxis(np.array(rows), 2, 0)


def coarse_poses(
    index: PlaceIndex, data: Data, maps: DistanceMaps, most: int, check: Callable[[], None] = unhurried
) -> Coarse:
    """The ``most`` poses of all types that the data vote for.

    ``maps`` of the index's sets of looks (``PlaceIndex.allowed``). ``check`` is called between blocks, and may raise to
    end it.
    """
    table, budget = index.triples, MOST + MOST_OF_TYPE * len(index.indices)
    for neighbours in NEIGHBOURS:
        image = image_triples(index, data, neighbours, check)
        low, high = (np.searchsorted(table.key, image.key, side) for side in ("left", "right"))
        if (high - low).sum() <= budget:
            break
    some = _rarest(high - low, budget)
    row, entry = taken(low[some][:, None], high[some][:, None])
    row = some[row]
    best = _Voted(np.zeros(0, np.intp), np.zeros((0, 4, 4), np.float32), np.zeros(0, np.float32))
    for start in range(0, len(row), BLOCK):
        check()
        found = _voted(
            index, data, maps, *_poses(index, image, row[start : start + BLOCK], entry[start : start + BLOCK], data)
        )
        best = _Voted.joined([best, found])
        best = best.take(np.argsort(-best.votes, kind="stable")[:most])
    return Coarse(best.kind, best.poses)


def _rarest(count: Indices, most: int) -> Indices:
    """Those of triples that find so many (N,) each, in order, ``most`` pairs in all."""
    order = np.argsort(count, kind="stable")
    whole = int(np.searchsorted(np.cumsum(count[order]), most if count.sum() <= most else most // 2, "right"))
    rest = np.sort(order[whole:])
    step = int(np.ceil(count[rest].sum() / max(1, most // 2))) or 1
    return np.sort(np.concatenate([order[:whole], rest[step // 2 :: step]]))


class _Laid(NamedTuple):
    """N triples of the index laid onto triples of the image."""

    kind: Indices  # (N,)
    row: Indices  # (N,) of the image
    entry: Indices  # (N,) of the index
    affine: Singles  # (N, 2, 2) from the plane, m, to tangents
    depth: Singles  # (N,) m, of the first
    slant: Singles  # (2, N) how the plane's axes lie along the ray, up to a common sign
    facing: Singles  # (N,) and how its normal does

    def take(self, some: Indices) -> "_Laid":
        """Some of them."""
        kind, row, entry, affine, depth, slant, facing = self
        return _Laid(kind[some], row[some], entry[some], affine[some], depth[some], slant[:, some], facing[some])


def _laid(index: PlaceIndex, image: ImageTriples, row: Indices, entry: Indices, data: Data) -> _Laid:
    """Those that are no steeper than ``FLATTEST``, and of a size that is believed."""
    kind = index.triples.kind[entry]
    affine = image.sides[row] @ index.triples.flat[entry]
    (a, b), (c, d) = np.moveaxis(affine, 0, 2)
    one, both, other = a * a + c * c, a * b + c * d, b * b + d * d
    middle, root = (one + other) / 2, np.hypot((one - other) / 2, both)
    square = np.maximum(middle + root, np.float32(1e-18))
    slant = np.sqrt(np.maximum(1 - np.stack([one, other]) / square, 0))
    slant[1] *= np.where(both > 0, -1, 1)
    size = np.sqrt(square) * (data.camera.f * index.diameters).astype(np.float32)[kind]
    good = (middle - root > FLATTEST * square) & (size > SMALLEST) & (size < LARGEST * data.camera.height)
    found = _Laid(kind, row, entry, affine, 1 / np.sqrt(square), slant, (a * d - b * c) / square)
    return found.take(np.flatnonzero(good))


def _poses(
    index: PlaceIndex, image: ImageTriples, row: Indices, entry: Indices, data: Data
) -> tuple[Indices, Indices, Indices, Singles]:
    """Types, view cells, entries (N,) and poses (N, 4, 4) of those of both reflections whose cell shows the three."""
    both = _laid(index, image, row, entry, data)
    found = [_shown(index, image, both, np.float32(sign)) for sign in (1.0, -1.0)]
    kinds, cells, entries, poses = (np.concatenate(columns) for columns in zip(*found, strict=True))
    return kinds, cells, entries, poses


def _shown(
    index: PlaceIndex, image: ImageTriples, laid: _Laid, sign: np.float32
) -> tuple[Indices, Indices, Indices, Singles]:
    """Those of one reflection."""
    table, kind = index.triples, laid.kind
    last = np.stack([*(sign * laid.slant), laid.facing], axis=1)
    back = np.einsum("nj,njk->nk", last, table.axes[laid.entry])
    view = table.first[laid.entry] - back * laid.depth[:, None] - index.middles[:, kind].T
    cell, three = index.cells_of(view.T), table.features[laid.entry]
    shown = index.visible[kind, cell, three[:, 0]]
    for k in (1, 2):
        shown &= index.visible[kind, cell, three[:, k]]
    here = np.flatnonzero(shown)
    some = laid.take(here)
    return some.kind, cell[here], some.entry, _posed(table, image, some, last[here])


def _posed(table: Triples, image: ImageTriples, laid: _Laid, last: Singles) -> Singles:
    """(N, 4, 4) poses; ``last`` (N, 3) how the plane's axes lie along the ray."""
    columns = np.concatenate([laid.affine * laid.depth[:, None, None], last[:, None, :2]], axis=1)
    plane = np.concatenate([columns, np.cross(columns[:, :, 0], columns[:, :, 1])[:, :, None]], axis=2)
    frame, poses = image.frame[laid.row], np.zeros((len(last), 4, 4), np.float32)
    poses[:, :3, :3] = frame @ plane @ table.axes[laid.entry]
    poses[:, :3, 3] = frame[:, :, 2] * laid.depth[:, None]
    poses[:, :3, 3] -= np.einsum("nij,nj->ni", poses[:, :3, :3], table.first[laid.entry])
    poses[:, 3, 3] = 1
    return poses


def _voted(
    index: PlaceIndex, data: Data, maps: DistanceMaps, kind: Indices, cell: Indices, entry: Indices, poses: Singles
) -> _Voted:
    """The poses with the votes of their cells' probes, but for the three that made them.

    What the first few of these vote for least is left out.
    """

    def voted(some: Indices, first: int, last: int) -> Singles:
        probe, three = index.probes[kind[some], cell[some], first:last], index.triples.features[entry[some]]
        asked = (probe >= 0) & (probe != three[:, :1]) & (probe != three[:, 1:2]) & (probe != three[:, 2:])
        return votes_of(index, data, maps, kind[some], poses[some], probe, asked)

    early = voted(np.arange(len(kind)), 0, EARLY)
    best = np.sort(np.argsort(-early, kind="stable")[: int(np.ceil(GO_ON * len(early)))])
    return _Voted(kind[best], poses[best], early[best] + voted(best, EARLY, PROBES))


def votes_of(
    index: PlaceIndex,
    data: Data,
    maps: DistanceMaps,
    kind: Indices,
    poses: Singles,
    features: Indices,
    asked: Mask,
) -> Singles:
    """(N,) of ``features`` (N, K), where they are ``asked``: how many have a datum near, less what is missed."""
    at = index.at[:, kind[:, None], features]
    (x, y, z), focal = (_along(poses[:, k], at) for k in range(3)), np.float32(data.camera.f)
    scale = focal / np.where(z > NEAREST_DEPTH, z, np.float32(np.inf))
    middle = centre_of(data.camera).astype(np.float32)
    places = np.stack([x * scale + middle[0], y * scale + middle[1]], axis=-1)
    distance, covered = maps.seen_at(places, index.shown[kind[:, None], features])
    depth = _along(poses[:, 2], index.middles[:, kind][..., None])
    distance = np.where((z > NEAREST_DEPTH) & (depth > NEAREST_DEPTH), distance, np.float32(np.inf))
    sharper = np.maximum(depth, NEAREST_DEPTH) / (REACH * focal * index.diameters.astype(np.float32)[kind][:, None])
    share = np.minimum(distance * sharper, 1)
    vote = 1 - share + np.maximum(1 - SHARP * share, 0)
    return np.asarray(((vote * ((1 + MISSED) / 2) - MISSED) * (asked & ~covered)).sum(axis=1))


def _along(row: Singles, at: Singles) -> Singles:
    """(N, K) one coordinate in the camera's frame of places (3, N, K), by a row (N, 4) of each pose."""
    a, b, c, d = (row[:, k, None] for k in range(4))
    x, y, z = at
    return np.asarray(a * x + b * y + c * z + d)


def pose_votes(index: PlaceIndex, data: Data, maps: DistanceMaps, kind: Indices, poses: Floats) -> Singles:
    """(N,) the votes of all features that the view cells of poses (N, 4, 4) show."""
    cell = index.cells_of((viewpoints_of(poses) - index.centres[kind]).T)
    every = np.broadcast_to(np.arange(index.own.shape[1]), (len(kind), index.own.shape[1]))
    return votes_of(index, data, maps, kind, poses.astype(np.float32), every, index.visible[kind, cell])
