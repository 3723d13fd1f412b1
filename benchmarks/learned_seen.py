"""What is seen of a learned type at a pose, right or wrong, in the quantities of its likelihood.

Rows that ``learned_spreads.py`` makes figures of.

At a right pose that is what the expected features were matched with, of which a few are there by chance; at a wrong one
*clutter*: all around their places that looks as right, as the likelihood counts it. And what becomes of the poses that
are proposed in search (``worths``).
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.recognition.score import HALF
from geometry.frames import pose_error, transform_points
from kb.clouds.words import SIDE
from plogic.match.gamma import side_looks
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.match.judged.evidence import LEAST_HIT, MOST_HIT, clutter_density, hit_rates, kinds, match_density
from plogic.match.judged.rivals import distinct_poses
from plogic.match.learned import agreement, sides
from plogic.match.learned import learned_match as looks
from plogic.match.learned import learned_poses as generate
from plogic.match.learned.agreement import lobes_about, lobes_held
from plogic.match.learned.learned_match import matched, pose_of
from plogic.measures import crowding

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from benchmarks.recognition.score import Truth
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_models import LearnedIndex

    Floats = NDArray[np.float64]

FAR = 0.01
"""Features less close than this, of 1, have nothing to do with each other: what they have in common is the
picture's."""
AS_FOUND = np.radians(15.0), 0.1
"""A proposed pose is right within so many radians and this share of the distance: from there it settles to the true
one."""


@dataclass
class Seen:
    """What was seen at poses of one kind, a piece a pose.

    Under each name columns (C, N), which the functions below name.
    """

    poses: int = 0
    rows: dict[str, list[Floats]] = field(default_factory=lambda: defaultdict(list))

    def of(self, name: str) -> Floats:
        """(C, N) columns of all pieces."""
        return np.concatenate(self.rows[name], axis=1)


def look(seen: Seen, index: LearnedIndex, pose: Floats, data: Data, kb: KnowledgeBase, *, true: bool) -> None:
    """Match the type at a pose, and keep what is seen there."""
    posed = matched(index, pose_of(index, pose, data, kb), data, kb)
    of_kind = [kind & posed.candidate for kind in kinds(posed)]
    seen.poses += 1
    seen.rows["keypoints"].append(_keypoints(index, posed, data, true=true))
    seen.rows["sides"].append(_sides(index, posed, data, kb, true=true))
    seen.rows["chance"].append(_chance(index, posed, data, kb))
    seen.rows["linked"].append(_linked(posed, kb, true=true))
    seen.rows["found"].append(
        np.array([[kind.sum(), (kind & posed.detected).sum()] for kind in of_kind], float).reshape(4, 1)
    )
    for name, which in zip(("keypoint gain", "side gain"), of_kind, strict=True):
        seen.rows[name].append(_gain(posed, data, kb)[None, which])


def _off(
    index: LearnedIndex, posed: Hypothesis, data: Data, lobe: NDArray[np.intp], datum: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """(7, N) ``turned, colours, contrast, mean, varied, usual, fit`` of sides of edges, matched or around.

    They face about right and have any colours.
    """
    at = posed.at[index.cloud.feature[lobe]]
    grown = np.log(index.cloud.size[lobe] * data.camera.f / np.maximum(at[:, 2], 1e-6) / data.scale[datum])
    turn = screen_angle(index.cloud.up[lobe] @ posed.camera_from_object[:3, :3].T, at)
    return wrapped(turn - data.angle[datum]), grown


def _near(uv: Floats, which: NDArray[np.bool_], data: Data, reach: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """All pairs of a place (Q, 2), pixels, and a datum of ``which`` (A,), at most ``reach`` pixels apart.

    Indices of places and of data.
    """
    datum = np.flatnonzero(which)
    pairs = cKDTree(uv.reshape(-1, 2)).sparse_distance_matrix(cKDTree(data.uv[datum]), reach, output_type="coo_matrix")
    return pairs.row, datum[pairs.col]


def _keypoints(index: LearnedIndex, posed: Hypothesis, data: Data, *, true: bool) -> Floats:
    """(3, N) ``turned, grown, apart`` of keypoints that look right, matched or around expected features."""
    features = np.flatnonzero(posed.candidate & ~index.sided)
    pairs = looks.right_pairs(
        index, posed, data, lobes_about(index, posed.camera_from_object), features, data.described, looks.AROUND
    )
    kept = (posed.matches[pairs.feature] == pairs.datum) | (not true)
    return np.stack([*_off(index, posed, data, pairs.best, pairs.datum), pairs.apart])[:, kept]


def _chance(index: LearnedIndex, posed: Hypothesis, data: Data, kb: KnowledgeBase) -> Floats:
    """(4, 1) of appearances and keypoints around them: how many pairs, of right angle and size, of one word, both."""
    assert kb.words is not None  # noqa: S101 - a learned KB has words
    lobes = lobes_held(index, posed.camera_from_object, data.camera.f / kb.f_ref)
    lobes = lobes[~index.cloud.sided[lobes] & posed.candidate[index.cloud.feature[lobes]]]
    uv = posed.uv[index.cloud.feature[lobes]]
    place, datum = _near(uv, data.described, data, looks.AROUND)
    turned, grown = _off(index, posed, data, lobes[place], datum)
    right = (np.abs(turned) < agreement.ANGLES) & (np.abs(grown) < agreement.SIZES)
    word = np.array(kb.words.names)[index.cloud.lobe_word[lobes[place]]] == np.array(data.types)[datum]
    return np.array([[len(right)], [right.sum()], [word.sum()], [(right & word).sum()]], float)


def _sides(index: LearnedIndex, posed: Hypothesis, data: Data, kb: KnowledgeBase, *, true: bool) -> Floats:
    """(7, N) ``turned, colours, contrast, mean, varied, usual, fit`` of sides of edges, matched or around.

    They face about right and have any colours.

    ``mean`` and ``varied`` are the contrast of the appearance and its standard deviation, ``usual`` the density of the
    one seen among the image's edges, ``fit`` what ``looks_fit`` makes of it all; of several appearances of a match the
    likeliest counts.
    """
    cloud, pose = index.cloud, posed.camera_from_object
    lobes = lobes_held(index, pose, data.camera.f / kb.f_ref)
    lobes = lobes[cloud.sided[lobes] & posed.candidate[cloud.feature[lobes]]]
    feature = cloud.feature[lobes]
    angle = screen_angle(cloud.up[lobes] @ pose[:3, :3].T, posed.at[feature])
    place, datum = _near(posed.uv[feature], data.sided, data, sides.AROUND)
    turned = wrapped(data.angle[datum] - angle[place])
    kept = (np.abs(turned) < sides.TURNED) & ((posed.matches[feature[place]] == datum) | (not true))
    place, datum, turned = place[kept], datum[kept], turned[kept]
    mine, its = index.looks[lobes[place]], data.looks[datum]
    colours = side_looks.colours_off(mine, its, coloured=data.coloured)
    fit = np.maximum(side_looks.looks_fit(mine, its, colours, data.contrasts), 1e-9)
    usual = data.contrasts[its[:, SIDE - 1]]
    rows = np.stack(
        [turned, colours, its[:, SIDE - 1] - 128.0, mine[:, SIDE - 1] - 128.0, mine[:, SIDE], usual, fit]
    ).astype(float)
    if not true:
        return rows
    order = np.lexsort((0.5 * (turned / sides.TURNS) ** 2 - np.log(fit), feature[place]))
    return rows[:, order[np.unique(feature[place][order], return_index=True)[1]]]


def _gain(posed: Hypothesis, data: Data, kb: KnowledgeBase) -> Floats:
    """(F,) logarithm of the likelihood ratio of each feature, were it expected, at its measured rate: no clarity."""
    assert posed.hit is not None  # noqa: S101 - of a learned type it was measured
    hit, found = np.clip(posed.hit, LEAST_HIT, MOST_HIT), posed.detected
    ratio = 1.0 - hit
    ratio[found] += hit[found] * match_density(posed, kb)[found] / clutter_density(kb, data, posed.matches[found])
    return np.asarray(np.log(ratio))


def _linked(posed: Hypothesis, kb: KnowledgeBase, *, true: bool) -> Floats:
    """(8, 1) of pairs of expected features, of keypoints and then with a side.

    Σ closeness · deviations, Σ closeness², Σ far, number far.

    Closeness, up to 1, is as in ``crowding``; deviations are by how much each was found more than it should be, in its
    standard deviations: by the rates at a right pose, at a wrong one by the share of its kind that was found there.
    """
    assert posed.turn is not None and posed.sided is not None  # noqa: S101, PT018 - so it is of a learned type
    own = [
        float(posed.detected[kind & posed.candidate].mean()) if (kind & posed.candidate).any() else 0.0
        for kind in kinds(posed)
    ]
    rate = hit_rates(posed, kb) if true else np.clip(np.where(posed.sided, own[1], own[0]), LEAST_HIT, MOST_HIT)
    some = np.flatnonzero(posed.candidate)
    deviation = ((posed.detected - rate) / np.sqrt(rate * (1.0 - rate)))[some]
    one, other = np.triu_indices(len(some), 1)
    close, both = _closeness(posed.uv[some], posed.turn[some], one, other), deviation[one] * deviation[other]
    sided = posed.sided[some][one] | posed.sided[some][other]
    sums = [
        ((close * both)[of].sum(), (close[of] ** 2).sum(), both[of & (close < FAR)].sum(), (of & (close < FAR)).sum())
        for of in (~sided, sided)
    ]
    return np.array(sums, float).reshape(8, 1)


def _closeness(uv: Floats, turn: Floats, one: NDArray[np.intp], other: NDArray[np.intp]) -> Floats:
    """(N,) in (0, 1] of pairs of features at uv (F, 2) pixels, with turn (F,) across their edges.

    ``crowding.shares`` has it before ``LINKED``.
    """
    apart, bent = uv[other] - uv[one], (turn[other] - turn[one] + np.pi / 2) % np.pi - np.pi / 2
    mean, square = turn[one] + bent / 2.0, (apart**2).sum(axis=1)
    across = apart[:, 0] * np.cos(mean) + apart[:, 1] * np.sin(mean)
    line = (across / crowding.CROWDED) ** 2 + (square - across**2) / crowding.ALONG**2 + (bent / crowding.BENT) ** 2
    return np.asarray(np.exp(-0.5 * np.minimum(line, square / crowding.CROWDED**2)))


def worths(index: LearnedIndex, data: Data, kb: KnowledgeBase, truths: Sequence[Truth]) -> Iterator[tuple[bool, float]]:
    """Poses of a type as ``generate`` comes to them before it settles them, none given up for its worth.

    Whether each is right, and its worth.

    Of each true object the best right one; all of a type that is not in the scene are wrong.
    """
    best, worth = generate.proposed(index, data, kb)
    kept = distinct_poses(index.object_type, best, generate.VERIFIED)
    values = [float(worth[(best == pose).all(axis=(1, 2))].max()) for pose in kept]
    if not truths:
        yield from ((False, value) for value in values)
    for truth in truths:
        right = [
            value for pose, value in zip(kept, values, strict=True) if truth.fraction >= HALF and _as_found(pose, truth)
        ]
        if right:
            yield True, max(right)


def _as_found(pose: Floats, truth: Truth) -> bool:
    """Whether a pose is near enough to settle to the true one."""
    middles = [transform_points(T, truth.centre[None])[0] for T in (pose, truth.camera_from_object)]
    near = np.linalg.norm(middles[0] - middles[1]) <= AS_FOUND[1] * np.linalg.norm(middles[1])
    return bool(near and pose_error(pose, truth.camera_from_object, truth.symmetries)[0] <= AS_FOUND[0])
