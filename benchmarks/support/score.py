"""One picture's answers beside its truth: what is found and right, how deep, on what plane, and who stands on what.

* ``Thing``: one object that is there; ``Judged``: all of a picture
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.photos.score import depth_error
from benchmarks.photos.told import STANDS, Forecast
from benchmarks.support.said import said_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from benchmarks.photos.score import Counts, Posed, Told
    from benchmarks.photos.table import Measure
    from benchmarks.support.arranged import Kind, Stance
    from benchmarks.support.said import Said
    from benchmarks.support.scenes import Stood
    from geometry.arrays import Floats
    from geometry.bodies.resting import Plane
    from plogic.facts.document import Interpretation

TURNED, OFF = np.radians(3.0), 0.02
"""Radians, and share of the distance to where things stand, by which a plane may differ that is right."""


class Thing(NamedTuple):
    """An object that is there: its picture, group and ``kind``, what stands for it, and by how much its depth is off.

    ``says``: how it is held, as the interpretation tells; ``told``: whether that is right; None where nothing is said,
    and of what stands on a thing that is not found.
    """

    picture: str
    group: str
    kind: Kind
    row: Told
    depth: float | None
    says: Kind | None = None
    told: bool | None = None


class Judged(NamedTuple):
    """A picture's counts by group, its things, whether the first plane is right, and what is claimed, with the outcome.

    ``plane``: None where nothing is said of planes.
    """

    tilt: float
    counts: Mapping[str, Counts]
    things: tuple[Thing, ...]
    plane: bool | None
    claimed: tuple[Forecast, ...]
    seconds: float

    @property
    def standing(self) -> int:
        """How many things stand on the plane."""
        return sum(thing.kind == "standing" for thing in self.things)


def judged(
    stood: Stood,
    document: Interpretation,
    answers: Mapping[str, Posed],
    measure: Measure,
    groups: Mapping[str, Sequence[int]],
) -> Judged:
    """What a document comes to, without its seconds and the claims that are made without support.

    ``answers``: what is accepted, by the names of hypotheses; ``groups``: types by BOP number.
    """
    shown, said = stood.shown, said_of(document)
    counts: dict[str, Counts] = {}
    rows: dict[int, tuple[str, Told]] = {}
    for group, own in groups.items():
        counts[group], told = measure.counted(shown, list(answers.values()), own)
        mine = [i for i, truth in enumerate(shown.truths) if truth.obj_id in own]
        rows |= {i: (group, row) for i, row in zip(mine, told, strict=True)}
    names = [_name(rows[i][1], answers) for i in range(len(shown.truths))]
    things = []
    for i, (truth, stance) in enumerate(zip(shown.truths, stood.stances, strict=True)):
        group, row = rows[i]
        depth = depth_error(row.answer, truth, measure.models[truth.obj_id]) if row.found and row.answer else None
        says, right = _told(said, names, i, stance) if said is not None and row.found else (None, None)
        things.append(Thing(shown.name, group, stance.kind, row, depth, says, right))
    right = None if said is None else _plane_right(said, stood)
    claimed = () if said is None else tuple(_stands(said, stood, answers, names))
    tilt = float(np.degrees(np.arcsin(-stood.plane.up[2])))
    return Judged(tilt, counts, tuple(things), right, claimed, 0.0)


def same_plane(plane: Plane, true: Plane, at: Floats) -> bool:
    """Whether a plane is right where things stand, ``at`` (3,) on the true one, camera frame."""
    return bool(plane.turned(true) <= TURNED and abs(plane.height(at)) <= OFF * np.linalg.norm(at))


def feet(stood: Stood) -> Floats:
    """(3,) the mean place on the plane under what stands there, camera frame."""
    places = [
        truth.camera_from_object[:3, 3]
        for truth, stance in zip(stood.shown.truths, stood.stances, strict=True)
        if stance.kind == "standing"
    ]
    middle = np.mean(places, axis=0)
    return np.asarray(middle - stood.plane.height(middle) * stood.plane.up)


def _name(row: Told, answers: Mapping[str, Posed]) -> str | None:
    """The hypothesis that a truth is found as."""
    return next((name for name, posed in answers.items() if posed is row.answer), None) if row.found else None


def _told(said: Said, names: Sequence[str | None], i: int, stance: Stance) -> tuple[Kind, bool | None]:
    """What is said of a thing that is found, and whether it is right."""
    name, lower = names[i], None if stance.on is None else names[stance.on]
    assert name is not None  # noqa: S101 - it is found
    says, on = said.kind(name)
    if stance.kind == "stacked" and lower is None:
        return says, None
    return says, says == stance.kind and (stance.kind != "stacked" or on == lower)


def _plane_right(said: Said, stood: Stood) -> bool:
    first = next(iter(said.planes.values()), None)
    return first is not None and same_plane(first, stood.plane, feet(stood))


def _stands(said: Said, stood: Stood, answers: Mapping[str, Posed], names: Sequence[str | None]) -> list[Forecast]:
    """Of each accepted one, that it stands on the plane on which it does most probably."""
    at, claimed = feet(stood), []
    standing = {name for name, stance in zip(names, stood.stances, strict=True) if stance.kind == "standing"}
    for name in answers:
        p, plane = said.stood(name)
        true = name in standing and plane is not None and same_plane(said.planes[plane], stood.plane, at)
        claimed.append(Forecast(stood.shown.name, STANDS, min(1.0, p), true))
    return claimed
