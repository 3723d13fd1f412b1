"""Links: where data have arms, two appearances that, inside one view cell, fix a whole pose (§6.3).

A *link* of the cloud is a pair of features of which one's edge ends at the other; a link of Γ is a pair of junctions of
which one's arm points at the other. Laid onto each other in a view cell, the two fix roll and scale, and the cell gives
the direction; the junctions' other arms must then lie on the features' other edges. All arms are kept as bits of a
64-bit word, relative to the link, so that millions of combinations are tested in milliseconds.

* ``linked_pairs``: of one type, in every cell; ``linked_poses``: of all types, as poses
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Columns, Data, blocks
from plogic.match.gamma.grid import wrapped
from plogic.match.hand.distance_maps import DistanceMaps
from plogic.match.hand.extend import poses_about
from plogic.match.hand.place_index import PlaceIndex
from plogic.match.hand.place_votes import LARGEST, SMALLEST
from plogic.match.hand.view_cells import ALL, LOOSE, ViewCells

if TYPE_CHECKING:
    from plogic.match.hand.hand_models import TypeIndex

ARM_TOLERANCE = np.radians(16.0)
"""How far an arm may lie from the edge that the nearest cell predicts: half a cell's width plus the detector's
error."""
MOST_PAIRS = 60_000
"""Pairs that are kept of one type."""


@dataclass(frozen=True)
class Pairs(Columns):
    """N coarse poses: cell, first and second feature and appearance, (N,) each; ``roll`` radians.

    ``scale`` pixels per metre.
    """

    cell: Indices
    feature: Indices
    datum: Indices
    other_feature: Indices
    other_datum: Indices
    roll: Floats
    scale: Floats


BINS = 64
"""Directions that an arm's angle is told apart to, 5.6° each."""
POINTING = np.radians(6.0)
"""How far a junction's arm may point past the other junction."""
ALONG_ONE_ARM = 3
"""Junctions that one arm is linked to, the nearest: an edge ends soon, but another object's outline may cross it
first."""
STRAIGHT = np.cos(np.radians(1.0))
"""An edge of the cloud ends at a feature that lies within 1° of its direction."""


@dataclass(frozen=True)
class DataLinks(Columns):
    """N links of Γ: ``first``, ``second`` (N,) data; ``angle`` (N,) of the line from first to second.

    ``length`` (N,) pixels.
    """

    first: Indices
    second: Indices
    angle: Floats
    length: Floats


def feature_links(points: Floats, arms: list[Floats]) -> Indices:
    """(N, 2) ordered pairs of features (F, 3) that an edge joins, both ways round.

    ``arms`` are each feature's edge directions.
    """
    found = set()
    for f, directions in enumerate(arms):
        for direction in directions:
            step = points - points[f]
            along, length = step @ direction, np.linalg.norm(step, axis=1)
            on = np.flatnonzero((length > 0) & (along >= STRAIGHT * length))
            end = min((int(g) for g in on if len(arms[g])), key=lambda g: length[g], default=None)
            if end is not None:
                found |= {(f, end), (end, f)}
    return np.array(sorted(found), dtype=np.intp).reshape(-1, 2)


def data_links(data: Data, check: Callable[[], None] = unhurried) -> DataLinks:
    """Every arm to the nearest junctions that it points at.

    ``check`` is called between blocks of junctions, and may raise to end it.
    """
    armed = np.flatnonzero(np.isfinite(data.arms).any(axis=1))
    found = [_links_from(armed[some], data, check) for some in blocks(len(armed), len(data.ids))]
    return DataLinks.joined(found or [_links_from(armed, data, check)])


def _links_from(junctions: Indices, data: Data, check: Callable[[], None]) -> DataLinks:
    """The links of some junctions (J,), by the first, then by the second."""
    check()
    step = data.ideal[None] - data.ideal[junctions][:, None]
    length, angle = np.hypot(step[..., 0], step[..., 1]), np.arctan2(step[..., 1], step[..., 0])
    apart = (length > 1.0) & (length < np.inf)
    pairs = set()
    for k in range(data.arms.shape[1]):
        off = np.abs(wrapped(angle - data.arms[junctions, k : k + 1]))
        rows, columns = np.nonzero((off < POINTING) & apart)
        order = np.lexsort((length[rows, columns], rows))
        near = order[(np.arange(len(rows)) - np.searchsorted(rows, rows)) < ALONG_ONE_ARM]
        pairs |= set(zip(rows[near].tolist(), columns[near].tolist(), strict=True))
    index = np.array(sorted(pairs), dtype=np.intp).reshape(-1, 2)
    row, second = index[:, 0], index[:, 1]
    return DataLinks(junctions[row], second, angle[row, second], length[row, second])


def linked_pairs(
    cells: ViewCells,
    links: Indices,
    allowed: Mask,
    data: Data,
    scales: tuple[float, float],
    check: Callable[[], None] = unhurried,
) -> Pairs:
    """Every link of the cloud on every link of Γ, in every cell that shows both features.

    Those whose arms fit best, at most ``MOST_PAIRS``.

    ``links`` (N, 2) as from ``feature_links``; ``allowed`` (F, A) the compatible types; ``scales`` the range of pixels
    a metre; ``check`` is called between blocks, and may raise to end it.
    """
    found = data_links(data, check)
    cell, link = np.nonzero(cells.visible[:, links[:, 0]] & cells.visible[:, links[:, 1]])
    f, g = links[link, 0], links[link, 1]
    step = cells.xy[cell, g] - cells.xy[cell, f]
    length, angle = np.hypot(step[:, 0], step[:, 1]), np.arctan2(step[:, 1], step[:, 0])
    ends = [
        (
            feature,
            datum,
            _words(cells.arms[cell, feature] - angle[:, None]),
            _bins(data.arms[datum] - found.angle[:, None]),
        )
        for feature, datum in ((f, found.first), (g, found.second))
    ]
    row, column, score = np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0, np.int8)
    for some in blocks(len(cell), len(found.first)):
        check()
        scale = _scales(found.length, length[some])
        legal = (scale > scales[0]) & (scale < scales[1])
        for feature, datum, _, _ in ends:
            legal &= allowed[feature[some]][:, datum]
        more, beside = np.nonzero(legal)
        more, fits = more + some.start, np.zeros(len(more), np.int8)
        for _, _, masks, bins in ends:
            hits, enough = _agreement(masks, bins, more, beside)
            more, beside, fits = more[enough], beside[enough], (fits + hits)[enough]
        row, column, score = (np.concatenate(both) for both in ((row, more), (column, beside), (score, fits)))
        if len(row) > MOST_PAIRS:
            best = np.sort(np.argsort(-score, kind="stable")[:MOST_PAIRS])
            row, column, score = row[best], column[best], score[best]
    roll, scale = wrapped(found.angle[column] - angle[row]), _scales(found.length[column], length[row], each=True)
    return Pairs(cell[row], f[row], found.first[column], g[row], found.second[column], roll, scale.astype(float))


def _scales(image: Floats, cloud: Floats, *, each: bool = False) -> NDArray[np.float32]:
    """Pixels a metre of lengths in the image (D,) by those of the cloud (M,).

    Of all (M, D), or of ``each`` two (D,).
    """
    cloud = np.maximum(cloud, 1e-9)
    return np.asarray((image / cloud if each else image[None] / cloud[:, None]).astype(np.float32))


def _agreement(
    masks: NDArray[np.uint64], bins: NDArray[np.int64], row: Indices, column: Indices
) -> tuple[NDArray[np.int8], Mask]:
    """How many arms of datum ``column`` (N,) lie on edges of feature ``row`` (N,), (N,), and whether they are enough.

    All arms of an L must fit, all but one of three or four, three of five: detectors lose arms, and texture adds some.
    ``bins`` (D, K) are arms' bins, ``masks`` (M,) words of edges.
    """
    words, hits = masks[row], np.zeros(len(row), dtype=np.int8)
    for k in range(bins.shape[1]):
        shift = np.where(bins[:, k] >= 0, bins[:, k], 0).astype(np.uint64)
        there = (bins[:, k] >= 0).astype(np.uint64)
        hits += ((words >> shift[column]) & there[column]).astype(np.int8)
    number = (bins >= 0).sum(axis=1)
    return hits, hits >= np.maximum(np.minimum(number, 2), np.ceil(0.6 * number)).astype(np.int8)[column]


def _bins(angles: Floats) -> NDArray[np.int64]:
    """The bin of each angle, −1 for none."""
    index = np.floor(np.nan_to_num(angles, nan=0.0) / (2.0 * np.pi) * BINS + 0.5).astype(np.int64) % BINS
    return np.where(np.isnan(angles), -1, index)


def _words(angles: Floats) -> NDArray[np.uint64]:
    """(M,) words with the bits set that lie within ``ARM_TOLERANCE`` of one of the angles (M, P)."""
    spread = int(ARM_TOLERANCE / (2.0 * np.pi) * BINS + 0.5)
    words = np.zeros(len(angles), dtype=np.uint64)
    middle = _bins(angles)
    for offset in range(-spread, spread + 1):
        bits = np.where(middle >= 0, np.uint64(1) << ((middle + offset) % BINS).astype(np.uint64), np.uint64(0))
        words |= np.bitwise_or.reduce(bits, axis=1) if bits.shape[1] else np.uint64(0)
    return words


def places_of(pairs: Pairs, cells: ViewCells, data: Data, features: Indices | slice = ALL) -> NDArray[np.float32]:
    """(N, F, 2) ideal pixels where each coarse pose puts each of ``features``.

    The cell's picture, turned, scaled and laid on the first datum.
    """
    at = cells.xy[pairs.cell, pairs.feature].astype(np.float32)[:, None]
    x, y = np.moveaxis(cells.xy.astype(np.float32)[:, features][pairs.cell] - at, -1, 0)
    cos = (pairs.scale * np.cos(pairs.roll)).astype(np.float32)[:, None]
    sin = (pairs.scale * np.sin(pairs.roll)).astype(np.float32)[:, None]
    places = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    return places + data.ideal[pairs.datum].astype(np.float32)[:, None]


def votes(
    pairs: Pairs,
    cells: ViewCells,
    maps: DistanceMaps,
    weights: Floats,
    data: Data,
    sets: Indices,
    features: Indices | slice = ALL,
) -> Floats:
    """(N,) Σ weight of the visible ``features``, each by how near its nearest datum is, over their whole weight.

    ``sets`` (F,) as what they look.
    """
    value = (cells.visible * weights).astype(np.float32)[:, features]
    distance = maps.seen_at(places_of(pairs, cells, data, features), sets[features])[0].astype(np.float32)
    near = np.maximum(0.0, 1.0 - distance / (LOOSE * cells.diameter * pairs.scale).astype(np.float32)[:, None])
    whole = np.maximum(value.sum(axis=1), 1e-12)
    return np.asarray((value[pairs.cell] * near).sum(axis=1) / whole[pairs.cell], dtype=float)


def linked_poses(
    index: PlaceIndex, data: Data, maps: DistanceMaps, most: int, check: Callable[[], None] = unhurried
) -> tuple[Indices, Floats]:
    """Types (N,) and poses (N, 4, 4) of the links of all types on those of Γ.

    Of each type the ``most`` that the anchors vote for.

    ``check`` is called between types, and blocks, and may raise to end it.
    """
    kinds, poses = [np.zeros(0, np.intp)], [np.zeros((0, 4, 4))]
    if np.isfinite(data.arms).any():
        allowed = index.allowed(data)
        for kind, each in enumerate(index.indices):
            if each.cells.arms.shape[2] and len(each.links):
                poses.append(_of_type(each, index.shown[kind], allowed, data, maps, most, check))
                kinds.append(np.full(len(poses[-1]), kind))
    return np.concatenate(kinds), np.concatenate(poses)


def _of_type(
    each: "TypeIndex",
    sets: Indices,
    allowed: Mask,
    data: Data,
    maps: DistanceMaps,
    most: int,
    check: Callable[[], None],
) -> Floats:
    """Links have anchors at both ends, and data that these look like."""
    own = allowed[sets[: len(each.points)]]
    anchored = np.asarray(own[each.anchors].any(axis=0))
    some, columns = data.only(anchored), np.flatnonzero(anchored)
    scales = SMALLEST / each.cells.diameter, LARGEST * data.camera.height / each.cells.diameter
    found = linked_pairs(each.cells, each.links, own[:, columns], some, scales, check)
    check()
    worth = votes(found, each.cells, maps, each.weights, some, sets, each.anchors)
    return coarse_poses(found.take(np.sort(np.argsort(-worth, kind="stable")[:most])), each.cells, some)


def coarse_poses(pairs: Pairs, cells: ViewCells, data: Data) -> Floats:
    """(N, 4, 4) camera_from_object of coarse pairs.

    The cell's rotation and roll, about the ray through the object's centre.
    """
    local = -cells.xy[pairs.cell, pairs.feature]
    cos, sin = np.cos(pairs.roll), np.sin(pairs.roll)
    turned = np.stack([cos * local[:, 0] - sin * local[:, 1], sin * local[:, 0] + cos * local[:, 1]], axis=1)
    centre = data.ideal[pairs.datum] + pairs.scale[:, None] * turned
    return poses_about(centre, pairs.roll, pairs.scale, cells.cell_from_object[pairs.cell], cells.centre, data)
