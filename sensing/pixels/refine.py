"""A pose moved to where its pixels fit: Gauss-Newton on colours across the outline, edges and print.

First over the colours of the two sides and the print, which reach far; then over edges, which are exact. The start
itself stays a candidate, and the fit (``energy``) picks.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np

from geometry.arrays import Floats
from geometry.bodies.standing import Contact
from geometry.frames import transform_points, turn_about
from geometry.visibility.rays import RayMesh
from sensing.pixels.blocks import ALIKE, Blocks, smoothed
from sensing.pixels.crop import Crop, crop_of
from sensing.pixels.drawn import Drawn, Paint
from sensing.pixels.energy import FEWEST_LINES, Fit, choice, fit_of, spans, squares_of, trusted
from sensing.pixels.lines import SLACK, Lines, between_colours, creases_of, on_edges, outline_of
from sensing.pixels.loops import NOWHERE, of_lines, of_print, print_off
from sensing.pixels.photo import Photo

DEPTHS, TILTS = (0.06, -0.06), np.radians((18.0, -18.0))
"""Shares of the depth by which starts are moved along the line of sight, and radians by which they are tilted about
the two axes across it: print alone leaves both in doubt (``photos.md``)."""
COARSE, FINE = 64.0, 128.0
"""Pixels that an object's larger side has at most where starts are compared, and where the best of them are refined."""


class Stage(NamedTuple):
    """Weights of the parts, steps at most, and pixels along a line in which an outline is looked for (None: all)."""

    region: float
    edges: float
    print_: float
    steps: int
    reach: int | None


FIRST = Stage(1.0, 0.0, 1.0, 3, None)
"""Small, every start a little; edges would catch clutter (``photos.md``)."""


def far(trust: float) -> list[Stage]:
    """Small, the best of the starts on; ``trust``, 0 to 1: how far print counts (``energy.trusted``)."""
    return [Stage(1.0, 0.0, trust, 6, None)]


def exact(trust: float) -> list[Stage]:
    """Large: where no print is trusted, edges alone last, for paint and sides pull plain objects off."""
    return [Stage(1.0, 0.0, trust, 3, None), Stage(0.3 * trust, 1.0, trust, 6, 3)]


TURN, DEPTH, ACROSS = 0.3, 0.1, 6.0
"""Standard deviations of what a step is expected to be: radians, a share of the depth, and pixels of the photo's part
across it."""
LONGEST = 0.25
"""Radians of one step."""
LITTLE = 0.002, 0.1
"""Radians, and pixels, below which a step is the last."""
SAME = 0.04
"""Diameters: poses nearer than this to one another lead to the same one."""
KEPT, CLOSE = 3, 3.0
"""Starts that go on of those that are compared; of these the best, and what fits less well by no more than this, are
refined to the end."""
INDEPENDENT = 2.0
"""What Gauss-Newton's normal matrix tells, in independent measurements: from here on the calibration error on simulated
photos hardly falls (``python benchmarks/pose_odds.py KB DATASET``)."""
INEXACT = 1.0
"""Standard deviation of the distance, as a share, for the share of its size by which edges are off the outline. Of 0,
0.5, 1, 1.5, 2 the one of the least log loss on the simulated photos that calibrate, and on real ones (the same
script)."""
HOPELESS = 2.0, 3.0
"""Fit, small, of the best start that is not tilted, and of the best of all at the end, below which nothing is refined
further: of 128 objects that are found or right in 17 photos and 36 simulated ones 6, and 1541 of 2227 other poses
(``python benchmarks/pixel_odds.py KB DATASET``)."""


class Refined(NamedTuple):
    """A pose (4, 4) and its whole fit; ``hopeless``: nothing fits near, and it was not moved to the end.

    ``spread``: as of ``spread_of``; None of what is hopeless and has no contact. ``released`` (4, 4): where the pixels
    alone lead it from its contact, which is the pose itself where they fit better there; None without one.
    """

    pose: Floats
    fit: Fit
    hopeless: bool = False
    spread: Floats | None = None
    released: Floats | None = None


def refined(
    photo: Photo,
    paint: Paint,
    pose: Floats,
    before: Sequence[tuple[RayMesh, Floats]] = (),
    contact: Contact | None = None,
) -> Refined | None:
    """The best-fitting pose from a start and from starts beside it; None if it is not in sight.

    ``before``: the surfaces of what stands there for sure, and its poses; ``contact``: what it stands on.
    """
    small, large = (crop_of(photo, paint, pose, size, before) for size in (COARSE, FINE))
    if small is None or large is None:
        return None
    starts, coarse, fits = starts_about(pose, paint), list[Floats](), list[Fit]()
    for some in (starts[: 1 + len(DEPTHS)], starts[1 + len(DEPTHS) :]):  # what is tilted last
        new = [settled(small, paint, start, [FIRST], contact) for start in some]
        coarse, fits = coarse + new, fits + fits_of(small, paint, new)
        found, trust = ordered(coarse, fits, paint, contact)
        if max(choice(fits)[1]) < HOPELESS[0]:
            return _at(large, paint, found[0][0], trust, contact, hopeless=True)
    coarse = [settled(small, paint, some, far(trust), contact) for some, _ in found[:KEPT]]
    fits = fits_of(small, paint, coarse)
    found, trust = ordered(coarse, fits, paint, contact)
    if max(choice(fits)[1]) < HOPELESS[1]:
        return _at(large, paint, found[0][0], trust, contact, hopeless=True)
    best = different([some for some, score in found if score >= found[0][1] - CLOSE], paint)
    poses = [pose, *(settled(large, paint, some, exact(trust), contact) for some in best)]
    chosen = ordered(poses, fits_of(large, paint, poses), paint, contact)[0][0][0]
    return _at(large, paint, chosen, trust, contact)


def _at(
    crop: Crop, paint: Paint, pose: Floats, trust: float, contact: Contact | None, *, hopeless: bool = False
) -> Refined:
    fit, released = fit_of(crop, paint, pose, whole=True), None
    if contact is not None:
        released = settled(crop, paint, pose, exact(trust))
        there = fit_of(crop, paint, released, whole=True)
        if there.odds > fit.odds:
            pose, fit = released, there
    spread = spread_of(crop, paint, pose, fit) if contact is not None or not hopeless else None
    return Refined(pose, fit, hopeless, spread, released)


def spread_of(crop: Crop, paint: Paint, pose: Floats, fit: Fit) -> Floats | None:
    """(6, 6) covariance of a pose by its pixels: its turn about the middle, rad, and the middle, m, camera's frame.

    None where too little of it is seen. As far as edges are off the outline, its size and so its distance is unsure.
    """
    known = normal(crop, paint, pose, exact(trusted([fit]))[-1])
    if known is None:
        return None
    expected, told, _ = known
    result, middle = np.linalg.inv(expected + INDEPENDENT * told), pose[:3, :3] @ paint.middle + pose[:3, 3]
    result[3:, 3:] += (INEXACT * fit.inexact) ** 2 * np.outer(middle, middle)
    return np.asarray(result)


def fits_of(crop: Crop, paint: Paint, poses: Sequence[Floats]) -> list[Fit]:
    """How well each of poses (4, 4) fits."""
    return [fit_of(crop, paint, pose) for pose in poses]


def ordered(
    poses: Sequence[Floats], fits: list[Fit], paint: Paint, contact: Contact | None = None
) -> tuple[list[tuple[Floats, float]], float]:
    """Poses with their scores, the best-fitting first; and how far their print is trusted."""
    scores = choice(fits)[1]
    if contact is not None:
        scores = [s + contact.log_density(p, paint.middle) for s, p in zip(scores, poses, strict=True)]
    return [(poses[k], scores[k]) for k in np.argsort(-np.array(scores), kind="stable")], trusted(fits)


def different(poses: Sequence[Floats], paint: Paint) -> list[Floats]:
    """Those of poses, in their order, whose surface is not where that of one before is."""
    corners = paint.middle + 0.5 * paint.diameter * np.concatenate([np.eye(3), -np.eye(3)])
    kept: list[Floats] = []
    for pose in poses:
        off = [np.linalg.norm(transform_points(pose, corners) - transform_points(old, corners), axis=1) for old in kept]
        if all(one.mean() > SAME * paint.diameter for one in off):
            kept.append(pose)
    return kept


def starts_about(pose: Floats, paint: Paint) -> list[Floats]:
    """A pose, and those beside it where print fits nearly as well."""
    middle = pose[:3, :3] @ paint.middle + pose[:3, 3]
    sight = middle / np.linalg.norm(middle)
    one = np.cross(sight, np.eye(3)[np.argmin(np.abs(sight))])
    one /= np.linalg.norm(one)
    steps = [np.zeros(6), *(np.concatenate([np.zeros(3), share * middle]) for share in DEPTHS)]
    steps += [np.concatenate([angle * way, np.zeros(3)]) for way in (one, np.cross(sight, one)) for angle in TILTS]
    return [moved(pose, paint.middle, step) for step in steps]


def half_turns(pose: Floats, paint: Paint) -> list[Floats]:
    """The pose (4, 4) turned about each of the object's own axes: outlines are often nearly the same then."""
    return [moved(pose, paint.middle, np.concatenate([np.pi * axis, np.zeros(3)])) for axis in pose[:3, :3].T]


def moved(pose: Floats, middle: Floats, step: Floats) -> Floats:
    """A pose after a step (6,): turned about the object's ``middle`` by a vector, radians, then moved, m."""
    angle = float(np.linalg.norm(step[:3]))
    turn = turn_about(step[:3] / angle, angle) if angle > 0.0 else np.eye(3)
    result = pose.copy()
    result[:3, :3] = turn @ pose[:3, :3]
    result[:3, 3] = pose[:3, :3] @ middle + pose[:3, 3] + step[3:] - result[:3, :3] @ middle
    return result


def settled(crop: Crop, paint: Paint, pose: Floats, stages: Sequence[Stage], contact: Contact | None = None) -> Floats:
    """The pose after all stages."""
    for stage in stages:
        for _ in range(stage.steps):
            step = _step(crop, paint, pose, stage, contact)
            if step is None:
                return pose
            pose = moved(pose, paint.middle, step)
            scale = paint.diameter / crop.size
            if np.abs(step[:3]).max() < LITTLE[0] and np.abs(step[3:]).max() < LITTLE[1] * scale:
                break
    return pose


def _step(crop: Crop, paint: Paint, pose: Floats, stage: Stage, contact: Contact | None) -> Floats | None:
    """One of Gauss-Newton; None where too little of the object is seen."""
    known = normal(crop, paint, pose, stage)
    if known is None:
        return None
    expected, told, slope = known
    if contact is not None:
        held, aim = contact.normal(pose, paint.middle)
        told, slope = told + held / INDEPENDENT, slope + aim / INDEPENDENT
    step = np.linalg.solve(expected + told, slope)
    return np.asarray(step * min(1.0, LONGEST / max(float(np.linalg.norm(step[:3])), 1e-9)))


def normal(crop: Crop, paint: Paint, pose: Floats, stage: Stage) -> tuple[Floats, Floats, Floats] | None:
    """Gauss-Newton's normal matrix (6, 6): that of what is expected of a step, and that of the photo; its slope (6,).

    None where too little of the object is seen.
    """
    drawn, slack = paint.drawn(pose, crop.K, crop.shape), SLACK * paint.diameter
    lines = outline_of(crop, drawn, slack)
    if len(lines) < FEWEST_LINES:
        return None
    middle = pose[:3, :3] @ paint.middle + pose[:3, 3]
    scale = paint.diameter / crop.size
    expected = np.diag(1.0 / np.array([TURN] * 3 + [ACROSS * scale] * 2 + [DEPTH * middle[2]]) ** 2)
    told, slope = np.zeros((6, 6)), np.zeros(6)
    for part in _parts(crop, drawn, lines, middle, slack, stage):
        told += part[0]
        slope += part[1]
    return expected, told, slope


def _parts(
    crop: Crop, drawn: Drawn, lines: Lines, middle: Floats, slack: float, stage: Stage
) -> Iterator[tuple[Floats, Floats]]:
    """(6, 6) and (6,) of each part of the energy."""
    length, widest = spans(crop)
    reach = widest if stage.reach is None else min(stage.reach, widest)
    if stage.region:
        told = between_colours(crop, lines, length, reach)
        even = reach * (reach + 1) / 3.0
        weight = np.clip(1.0 / (told.variance + 0.25) - 1.0 / (even + 0.25), 0.0, 2.0) * np.clip(4.0 * told.apart, 0, 1)
        yield _of_lines(crop, lines, middle, told.off, stage.region * weight / 3.0)
    if stage.edges:
        for some in (lines, creases_of(crop, drawn, slack)):
            if len(some):
                off = on_edges(crop, some, reach)
                found = off < NOWHERE
                weight = stage.edges * found / (1.0 + (np.where(found, off, 0.0) / 1.5) ** 2) ** 2 / 3.0
                yield _of_lines(crop, some, middle, np.where(found, off, 0.0), weight)
    if stage.print_:
        blocks = squares_of(crop, drawn, slack, max(6, round(crop.size / 5.0)), 5)
        if len(blocks.count):
            yield _of_print(crop, drawn, blocks, middle, stage.print_)


def _of_lines(crop: Crop, lines: Lines, middle: Floats, off: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """Lines that ought to be ``off`` (N,) pixels farther along, of a weight (N,) each."""
    return of_lines(lines.at, lines.across, lines.depth, crop.K, middle, off, weight)


ODD = 1.5
"""Standard deviations beyond which a pixel's print counts less."""


def _of_print(crop: Crop, drawn: Drawn, blocks: Blocks, middle: Floats, weight: float) -> tuple[Floats, Floats]:
    """The print's: the drawn moves over the photo, with a gain and an offset of each square."""
    shown = smoothed(crop, drawn)
    slopes = np.stack([cv2.Scharr(shown, cv2.CV_32F, *way) / 32.0 for way in ((1, 0), (0, 1))])
    scale = crop.K, np.ascontiguousarray(blocks.gains)
    off = print_off(blocks.which, crop.lab, shown, slopes, drawn.depth, scale, middle)
    n = blocks.count[:, None]
    variance = np.maximum((n * blocks.left).sum(axis=0) / n.sum(), 2.0)
    told, slope = of_print(blocks.which, off, blocks.count, variance, ODD**2)
    return weight / ALIKE * told, weight / ALIKE * slope
