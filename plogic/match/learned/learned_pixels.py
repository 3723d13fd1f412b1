"""What a photo's pixels say of a learned type at a pose, and poses moved to where they fit best (formalism §9.10).

A pixel counts once, for what stands in front: a hypothesis behind an accepted object is told with that masked.

* ``by_pixels``: of the poses of a search those that the pixels speak for, as hypotheses
* ``looked_beside``: a hypothesis told anew what its pixels say, beside others
* ``pictured``: told what they say by who of others is present, and how surely its pose is right
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from geometry.bodies.standing import Contact
from geometry.frames import transform_points
from geometry.visibility.rays import RayMesh, depth_of
from plogic.facts.pixel_table import MOST_BEFORE, PixelTable
from plogic.match.judged.evidence import evidence
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import Places, apart_on_screen, distinct, overlap, same_place

if TYPE_CHECKING:
    from geometry.arrays import Floats, Mask
    from geometry.bodies.standing import Known
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.judged.type_models import Request
    from plogic.match.learned.learned_models import LearnedIndex
    from sensing.pixels.drawn import Paint
    from sensing.pixels.energy import Fit
    from sensing.pixels.photo import Photo
    from sensing.pixels.refine import Refined

Before: TypeAlias = tuple[RayMesh, np.ndarray]
"""A surface that may hide pixels, and its pose (4, 4)."""
SCREENED, FITTED, FITTED_SEEN, FITTED_ON = 6, 2, 3, 4
"""Poses of a type whose pixels are looked at; those that are moved to where the pixels fit best; and of those that
views suggest, anywhere and on a plane."""
NO_POSES = np.zeros((0, 4, 4))


class Seen(NamedTuple):
    """Poses (N, 4, 4) that views of a type suggest, the best first, and what the views tell of each (N,), nats."""

    poses: Floats
    told: Floats

    def some(self, which: Mask) -> Seen:
        """Those of which (N,) is true."""
        return Seen(self.poses[which], self.told[which])


NOT_SEEN = Seen(NO_POSES, np.zeros(0))
PROMISING = 4.0
"""Fit, in ``sensing.pixels.energy``, that few poses of absent types have (``python benchmarks/pixel_odds.py``): one
that has it is refined whatever its keypoints say."""
FAINT = 1.0
"""Fit of poses that views suggest below which none is moved (``sensing.pixels.refine.HOPELESS`` says of what)."""
CLEAR = 3.0
"""The same of poses on tops, and of types with print on a plane, of which there are many: in a trace of ten rendered
scenes all eleven that were right had more, and 162 of 769 others."""
TOO = 0.05
"""What a unit of what views tell is worth beside what pixels tell (``python benchmarks/view_seeds.py``)."""
WORTHY = 25.0
"""Worth of a pose that is refined whatever its pixels say."""


def by_pixels(
    index: LearnedIndex,
    best: Floats,
    worth: Floats,
    data: Data,
    kb: KnowledgeBase,
    *,
    before: Sequence[Before] = (),
    seen: Seen = NOT_SEEN,
    contact: Contact | None = None,
) -> list[tuple[float, Hypothesis]]:
    """Of refined poses (N, 4, 4), best first, those that the pixels speak for, moved to where these fit best.

    ``seen``: poses that keypoints say nothing of; ``contact``: what all of them stand on.
    """
    from sensing.pixels.refine import CLOSE, refined

    photo, paint = data.photo, index.paint
    assert photo is not None  # noqa: S101 - the caller looked
    assert paint is not None  # noqa: S101
    by_keypoints = [
        row for row in screened(index, best, worth, data, before, SCREENED) if row[0] >= PROMISING or row[2] >= WORTHY
    ]
    looked = by_odds(photo, paint, seen, before)
    most = FITTED_SEEN if contact is None else FITTED_ON
    many = contact is not None and (contact.known.area is not None or not index.plain)
    by_views = [row for row in looked if row[0] >= (CLEAR if many else FAINT)][:most]
    if contact is not None and not many:  # and the first on a plane by its views
        left = [row for row in looked[most:] if not any(row is one for one in by_views)]
        by_views += [row for row in left if np.array_equal(row[1], seen.poses[0])]
    starts = [(*row[:2], True) for row in by_keypoints[:FITTED]] + [(*row[:2], False) for row in by_views]
    found: list[tuple[float, Hypothesis]] = []
    tried: list[tuple[float, Floats]] = []
    hopeless: list[Refined] = []
    for score, pose, matched in starts:
        if any(score < other - CLOSE and _in_one_place(paint, pose, there) for other, there in tried):
            continue
        tried.append((score, pose))
        start = index.settle(pose, data, kb, rounds=2).camera_from_object if matched else pose
        at = refined(photo, paint, start, before, contact)
        if at is not None and at.hopeless:
            hopeless.append(at)
        elif at is not None:
            turned = index.plain and at.fit.odds > 0.0 and contact is None
            found += _told(index, _of_half_turns(index, at, photo, before) if turned else at, data, kb)
    if not found and hopeless and not many:  # the best of a type is told, whatever it is worth
        found = _told(index, max(hopeless, key=lambda at: at.fit.odds), data, kb)
    return distinct(found, index.object_type)


def _of_half_turns(index: LearnedIndex, at: Refined, photo: Photo, before: Sequence[Before]) -> Refined:
    """The best of a pose and of what its half turns, where the type looks different, are refined to."""
    from sensing.pixels.refine import half_turns, refined

    assert index.paint is not None  # noqa: S101 - it was refined
    other = [pose for pose in half_turns(at.pose, index.paint) if not same_place(index.object_type, pose, at.pose)]
    found = [refined(photo, index.paint, pose, before) for pose in other]
    return max([at, *(some for some in found if some is not None)], key=lambda some: some.fit.odds)


def _told(index: LearnedIndex, at: Refined, data: Data, kb: KnowledgeBase) -> list[tuple[float, Hypothesis]]:
    """The hypothesis of a refined pose, with its log-likelihood ratio; none where too little of it is detected."""
    moved = index.settle(at.pose, data, kb, rounds=0).told(pixels=at.fit.odds, spread=at.spread, released=at.released)
    enough = (moved.candidate & moved.detected).sum() >= FEWEST
    return [(evidence(moved, data, kb).ratio, moved)] if enough else []


def screened(
    index: LearnedIndex, poses: Floats, worth: Floats, data: Data, before: Sequence[Before], most: int
) -> list[tuple[float, Floats, float]]:
    """How well the first ``most`` of poses (N, 4, 4) that are not in one place fit, with their worth; best first."""
    photo, paint = data.photo, index.paint
    assert photo is not None  # noqa: S101 - the caller looked
    assert paint is not None  # noqa: S101
    rows: list[tuple[float, Floats, float]] = []
    places = Places(index.object_type)
    for pose, value in zip(poses, worth, strict=True):
        if len(rows) == most:
            break
        if places.add(pose):
            fit = _coarse(photo, paint, pose, before)
            rows.append((-np.inf if fit is None else fit.score, pose, float(value)))
    return sorted(rows, key=lambda row: -row[0])


def by_odds(photo: Photo, paint: Paint, seen: Seen, before: Sequence[Before] = ()) -> list[tuple[float, Floats]]:
    """How well poses fit that views suggest; first those of which the pixels tell most, and the views a little."""
    fits = [
        (_coarse(photo, paint, pose, before, whole=True), pose, TOO * told) for pose, told in zip(*seen, strict=True)
    ]
    rows = [(fit.odds + more, fit.score, pose) for fit, pose, more in fits if fit is not None]
    return [(score, pose) for _, score, pose in sorted(rows, key=lambda row: -row[0])]


def _coarse(photo: Photo, paint: Paint, pose: Floats, before: Sequence[Before], *, whole: bool = False) -> Fit | None:
    """How well a pose (4, 4) fits, small; None where it is not in the photo."""
    from sensing.pixels.crop import crop_of
    from sensing.pixels.energy import fit_of
    from sensing.pixels.refine import COARSE

    crop = crop_of(photo, paint, pose, COARSE, before)
    return None if crop is None else fit_of(crop, paint, pose, whole=whole)


def _in_one_place(paint: Paint, pose: Floats, other: Floats) -> bool:
    """Whether the middles of two poses (4, 4) are so near that only one of them can be."""
    apart = transform_points(pose, paint.middle[None]) - transform_points(other, paint.middle[None])
    return float(np.linalg.norm(apart)) < 0.5 * paint.diameter


def hiding(others: Sequence[Hypothesis]) -> list[Before]:
    """The surfaces of opaque hypotheses, and their poses."""
    return [
        (other.object_type.surface.rays, other.camera_from_object)
        for other in others
        if other.opaque and other.object_type.surface is not None
    ]


def looked_beside(index: LearnedIndex, posed: Hypothesis, others: Sequence[Hypothesis], data: Data) -> Hypothesis:
    """The hypothesis told anew what its pixels say, where others stand near it on the screen and do not exclude it."""
    near = [
        other
        for other in others
        if other is not posed and not apart_on_screen(posed, other, data.camera.f, 0.0) and not overlap(posed, other)
    ]
    before = hiding(near)
    if posed.pixels is None or data.photo is None or index.paint is None or not before:
        return posed
    from sensing.pixels.crop import crop_of
    from sensing.pixels.energy import fit_of
    from sensing.pixels.refine import FINE

    crop = crop_of(data.photo, index.paint, posed.camera_from_object, FINE, before)
    if crop is None:
        return posed
    return posed.told(pixels=fit_of(crop, index.paint, posed.camera_from_object, whole=True).odds)


def stood(
    index: LearnedIndex,
    posed: Hypothesis,
    known: Known,
    others: Sequence[Hypothesis],
    request: Request,
) -> Hypothesis:
    """The hypothesis moved to where its pixels and contact with a plane agree; as it was where no photo was asked."""
    data, kb = request.data, request.kb
    if posed.pixels is None or data.photo is None or index.paint is None:
        return posed
    from sensing.pixels.crop import crop_of
    from sensing.pixels.energy import fit_of, trusted
    from sensing.pixels.refine import FINE, exact, ordered, settled, spread_of

    near = [other for other in others if not apart_on_screen(posed, other, data.camera.f, 0.0)]
    crop = crop_of(data.photo, index.paint, posed.camera_from_object, FINE, hiding(near))
    if crop is None:
        return posed
    here, contact = posed.camera_from_object, Contact(known, index.resting)
    fit = fit_of(crop, index.paint, here)
    moved = settled(crop, index.paint, here, exact(trusted([fit])), contact)
    there = fit_of(crop, index.paint, moved, whole=True)
    if ordered([here, moved], [fit, there], index.paint, contact)[0][0][0] is not moved:
        return posed
    beyond = {**posed.beyond(), "pixels": there.odds, "spread": spread_of(crop, index.paint, moved, there)}
    return index.settle(moved, data, kb, rounds=0).told(**posed.verdict(), **beyond)


def pictured(index: LearnedIndex, posed: Hypothesis, others: Mapping[str, Hypothesis], data: Data) -> Hypothesis:
    """The hypothesis with its ``pixel_table`` and ``pose_probability``, where its pixels were asked.

    ``others``, by id, are those that can be present beside it; what of them is accepted may hide some of it.
    """
    table = _looked_among(index, posed, others, data)
    if table is None:
        return posed
    from sensing.pixels.sureness import sureness

    assert data.photo is not None  # noqa: S101 - else there were no table
    assert index.paint is not None  # noqa: S101
    before = hiding([others[name] for name in table.names if others[name].status == "accepted"])
    symmetries = index.object_type.symmetries
    sure = sureness(data.photo, index.paint, posed.camera_from_object, symmetries, before)
    return posed.told(pixel_table=table, pose_probability=sure)


def _looked_among(
    index: LearnedIndex, posed: Hypothesis, others: Mapping[str, Hypothesis], data: Data
) -> PixelTable | None:
    """What its pixels say by who of others, by id, is present; None where they were not asked.

    Those count that are before some of it; where there are none, what it was told already holds.
    """
    if posed.pixels is None or data.photo is None or index.paint is None:
        return None
    alone = PixelTable((), (posed.pixels + 0.0,))
    near = {name: other for name, other in others.items() if not apart_on_screen(posed, other, data.camera.f, 0.0)}
    before = {name: body for name, other in near.items() for body in hiding([other])}
    from sensing.pixels.crop import clear, crop_of
    from sensing.pixels.energy import fit_of
    from sensing.pixels.lines import SLACK
    from sensing.pixels.refine import FINE

    pose, paint = posed.camera_from_object, index.paint
    crop = crop_of(data.photo, paint, pose, FINE) if before else None
    if crop is None:
        return alone
    drawn, slack = paint.drawn(pose, crop.K, crop.shape), SLACK * paint.diameter
    masked = {name: replace(crop, before=depth_of(*body, crop.K, crop.shape)) for name, body in before.items()}
    hides = {name: int((drawn.mask & ~clear(some, drawn, slack)).sum()) for name, some in masked.items()}
    names = [name for name in sorted(hides, key=lambda name: -hides[name]) if hides[name]]
    if not names:
        return alone
    some = names[:MOST_BEFORE]
    odds = []
    for row in range(2 ** len(some)):
        present = [masked[name].before for i, name in enumerate(some) if row >> i & 1]
        beside = replace(crop, before=np.min([crop.before, *present], axis=0))
        odds.append(fit_of(beside, paint, pose, whole=True).odds + 0.0)
    return PixelTable(tuple(some), tuple(odds), tuple(names[MOST_BEFORE:]))
