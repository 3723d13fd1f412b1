"""A table of ``plogic bench clutter``.

Who is told the type and a near pose, and refines it, in the same Γ among the same clutter.

* ``Refined``: one pose that one of the refiners came to, judged

SoftPOSIT as a refiner: from one near pose to a better one, with correspondences that nobody knows (formalism §6.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from benchmarks.clutter.pairs import refined
from benchmarks.clutter.table import share
from benchmarks.recognition.score import Found, pose_right
from benchmarks.shared.processor import processor_seconds
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from geometry.poses.softposit import Annealing, SoftPositResult, softposit
from plogic.match.gamma.data import data_of
from plogic.match.oriented.asked import poses_turned
from plogic.match.oriented.drawn import climbed
from plogic.match.oriented.oriented_models import search_of
from plogic.match.oriented.oriented_search import USUAL
from plogic.match.plain.quadruples import pairs_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from benchmarks.clutter.scenes import Case, Trial
    from plogic.match.gamma.data import Data
    from plogic.match.oriented.oriented_models import OrientedModels
    from plogic.run.perceive import Perceiver

    Floats = NDArray[np.float64]
    Refiner = Callable[[Floats, float], "Floats | None"]

TURNED, MOVED = (5.0, 10.0, 20.0, 40.0), (0.02, 0.05, 0.1)
"""Degrees about any axis, and share of the distance in any direction, by which a start is off."""
TRIALS = 20
"""Trials of a row, at most."""
NEAR_CAPTION = """\
near: told the type, and begun at the true pose turned by so many degrees about its middle and moved by so much of its distance. pose: share that
stands right then, within 5 degrees and 5 %; s: median seconds. settle: the cycle's refinement beside what is accepted, match and least squares in
turn; climb: the fast search's, on soft matches, from wide to narrow; SoftPOSIT: from a beta by how far off it is told to be, then least squares on
its matches. A start of 5 degrees and 2 or 5 % lies on the bar itself."""


@dataclass(frozen=True)
class Refined:
    """Results from a start ``turned`` (degrees) and ``moved`` (share of the distance) to a right or wrong pose."""

    case: Case
    turned: float
    moved: float
    who: str
    pose: bool
    seconds: float


def near(case: Case, posed: Trial, perceiver: Perceiver, rng: np.random.Generator) -> list[Refined]:
    """What all make of each start in one trial."""
    data, outcomes = data_of(posed.gamma.appearances, posed.gamma.camera), []
    refiners: dict[str, Refiner] = {
        "settle": partial(_settled, posed, perceiver, data),
        "climb": partial(_climbed, posed, perceiver, data),
        "SoftPOSIT": partial(_soft, posed, perceiver, data),
    }
    for turned in TURNED:
        for moved in MOVED:
            start = begun(posed, turned, moved, rng)
            off = _off(posed, turned, moved)
            for who, refine in refiners.items():
                before = processor_seconds()
                pose = refine(start, off)
                taken = processor_seconds() - before
                right = pose is not None and pose_right(Found(posed.truth.type, pose), posed.truth)
                outcomes.append(Refined(case, turned, moved, who, right, taken))
    return outcomes


def begun(posed: Trial, turned: float, moved: float, rng: np.random.Generator) -> Floats:
    """A better `camera_from_object` than `pose` (4, 4) of `points` (N, 3) m, some seen at `xy` (M, 2) = x/z, y/z."""
    truth, middle = posed.truth.camera_from_object, posed.truth.centre
    axis, way = (arrow / np.linalg.norm(arrow) for arrow in rng.normal(size=(2, 3)))
    half = np.radians(turned) / 2.0
    R = rotation_from_quat_xyzw(np.append(axis * np.sin(half), np.cos(half))) @ truth[:3, :3]
    place = truth[:3, :3] @ middle + truth[:3, 3]
    return from_rotation_translation(R, place + moved * float(np.linalg.norm(place)) * way - R @ middle)


def _off(posed: Trial, turned: float, moved: float) -> float:
    """Pixels, about, by which the object's points are off then.

    By the turn at half the picture's radius, and by the move.
    """
    radius = 0.25 * float((posed.truth.box[1] - posed.truth.box[0]).max())
    return 2.0 * radius * float(np.sin(np.radians(turned) / 2.0)) + moved * posed.gamma.camera.f


def _settled(posed: Trial, perceiver: Perceiver, data: Data, start: Floats, _: float) -> Floats:
    return perceiver.models[posed.truth.type].settle(start, data, perceiver.kb).camera_from_object


def _hand_modelled(perceiver: Perceiver) -> OrientedModels:
    return cast("OrientedModels", perceiver.models.kinds["oriented"])


def _climbed(posed: Trial, perceiver: Perceiver, data: Data, start: Floats, _: float) -> Floats | None:
    """As of a vote of the fast search, all rounds."""
    search = search_of(_hand_modelled(perceiver).shared, data, perceiver.kb)
    if search is None:
        return None
    asked = search.asked
    kind = np.array(
        [next(i for i, index in enumerate(asked.index.indices) if index.object_type.name == posed.truth.type)]
    )
    poses = poses_turned(start, asked.turn)[None]
    for each in USUAL.rounds:
        poses = climbed(asked, kind, poses, each.share, each.steps, each.squares)[0]
    return np.asarray(poses_turned(poses[0], -asked.turn))


def _soft(posed: Trial, perceiver: Perceiver, data: Data, start: Floats, off: float) -> Floats | None:
    """None where it does not converge."""
    type_index = _hand_modelled(perceiver).models.get(posed.truth.type)
    if type_index is None:
        return None
    camera, kb, pairs = data.camera, perceiver.kb, pairs_of(type_index, data)
    allowed, xy = pairs.mask(len(data.ids)), camera.normalised(data.uv)
    found = softposit_near(
        start, pairs.points, xy, off=off, allowed=allowed, noise=kb.rates.sigma, pixel=1.0 / camera.f
    )
    some = np.flatnonzero(found.matches[0] >= 0)
    return (
        refined(found.camera_from_object[0], pairs.points[some], found.matches[0][some], posed.gamma, kb)
        if found.converged[0]
        else None
    )


def near_rows(outcomes: Sequence[Refined]) -> list[dict[str, Any]]:
    """A row a case and a start: of each refiner the share of right poses, and its median seconds."""
    return [
        _row([o for o in outcomes if (o.case, o.turned, o.moved) == key])
        for key in dict.fromkeys((o.case, o.turned, o.moved) for o in outcomes)
    ]


def _row(mine: Sequence[Refined]) -> dict[str, Any]:
    names = list(dict.fromkeys(o.who for o in mine))
    first = mine[0]
    row: dict[str, Any] = {
        "case": first.case.detector.name,
        "turned": f"{first.turned:g} deg",
        "moved": f"{100 * first.moved:g} %",
    }
    row["trials"] = sum(o.who == names[0] for o in mine)
    for who in names:
        row[who] = share(o.pose for o in mine if o.who == who)
        row[f"{who} s"] = round(median(o.seconds for o in mine if o.who == who), 3)
    return row


def softposit_near(
    pose: ArrayLike,
    points: ArrayLike,
    xy: ArrayLike,
    *,
    off: float,
    allowed: ArrayLike | None = None,
    noise: float = 0.5,
    pixel: float = 1 / 600,
) -> SoftPositResult:
    """A better `camera_from_object` than `pose` (4, 4) of `points` (N, 3) m, some seen among `xy` (M, 2) = x/z, y/z.

    `off`: about how many pixels off the points are at the start; beta begins at 1 / off^2, for a smaller one forgets
    the pose that it is given.
    `allowed` (N, M): which point may be which, any if not given; `noise` of an image point, px; `pixel`, in normalised
    units: 1 / focal length.
    The result is of one start: its pose means nothing unless it `converged`, and may be wrong then (its `count` of
        matches tells).

    Raises:
        GeometryError: where `off` is not above 0, or as `softposit` does.
    """
    if not off > 0:
        raise GeometryError(f"off must be above 0 pixels, not {off}")
    usual = Annealing(noise=noise, pixel=pixel)
    setting = Annealing(beta=min(1.0 / off**2, usual.beta_final), noise=noise, pixel=pixel)
    return softposit(points, xy, np.asarray(pose, dtype=np.float64)[None], allowed=allowed, annealing=setting)
