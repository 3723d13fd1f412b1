"""What the hypotheses of Δh stand on, and how, as the program is told (formalism §9.9).

The planes are those that all proposals spoke for (``plogic.cycle.planes``). A hypothesis may stand on a plane, on one
of its faces; or on another hypothesis, whose top is under its foot, with a face as level as the likeliest plane.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import shapely

from geometry.arrays import Floats
from geometry.bodies.resting import Plane, along_plane
from geometry.bodies.standing import Known, Stands, borne, log_level, log_ratios
from geometry.frames import transform_points
from plogic.base.walk import by_key
from plogic.cycle.planes import (
    FREE,
    MOST,
    PUT,
    RAISED,
    STACKED,
    Bodies,
    Chance,
    Setting,
    Supported,
    abduced,
    bodies_of,
    with_noise,
)
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.stances import Row, Stance, Support, SupportPlane

WORTHLESS = 1e-3
"""Chance times ratio below which a way of standing is not told: beside being free it is nothing."""
HARDLY = 0.01
"""Probability below which a plane is not told."""
TOP = 0.1
"""Share of a body's height that is its top."""
SLACK = 0.01
"""Metres by which a foot may be beside a top."""


LEVEL = 1e-6
"""Length of what is left of the camera's x along a plane, below which it is at right angles to it."""


class _Way(NamedTuple):
    """A stance of a body by number, with the chance of its face alone."""

    body: int
    on: str
    face: int
    chance: float
    log_ratio: float


def support_of_view(
    posed: Mapping[str, Hypothesis], setting: Setting, told_by: Supported | None = None
) -> Support | None:
    """Of Δh, by id; None where nobody said that things rest, or how types may stand.

    ``told_by``: what all proposals told of planes, where that is known: what those tell that are not in Δh is the
    planes' prior.
    """
    rests = setting.kb.rests
    if rests is None or not setting.models:
        return None
    names = sorted(posed, key=lambda name: posed[name].status != "accepted")
    accepted = [posed[name] for name in names if posed[name].status == "accepted"]
    rivals = [posed[name] for name in names[len(accepted) :]]
    if told_by is None:
        bodies, found = abduced(accepted, rivals, setting, rests)
    else:
        bodies, found = with_noise(bodies_of(accepted, rivals, setting)), told_by
    prior = found.without({some.type for some in posed.values()})
    some = [k for k in range(len(found.planes)) if found.probability[k] > HARDLY][:MOST]
    planes = {f"s{n}": found.planes[k].known for n, k in enumerate(some, 1)}
    ways = [way for name, known in planes.items() for way in _on_plane(name, bodies.stands, known.plane)]
    if planes:
        ways += _on_others(names, posed, bodies, planes["s1"].plane)
    chances = [PUT if put else FREE for put in bodies.put]
    told = tuple(_told(name, known, float(prior[k])) for k, (name, known) in zip(some, planes.items(), strict=True))
    finds = zip(names[: len(accepted)], chances, strict=False)  # a rival is no other find
    by_chance = tuple((name, chance.on) for name, chance in finds)
    level = tuple(_level(bodies, planes, rests, list(zip(names, chances, strict=True))))
    return Support(rests, float(prior[-1]), told, tuple(_stances(names, ways, rests)), by_chance, level)


def _stances(names: list[str], ways: list[_Way], rests: float) -> Iterator[Stance]:
    """The ways, of which those on others share ``STACKED`` among them, and those on a plane have the rest.

    But for ``RAISED``.
    """
    stacked = by_key((way.body, way.on) for way in ways if way.on in names)
    for way in ways:
        others = len(set(stacked.get(way.body, ())))
        share = STACKED / others if way.on in names else 1.0 - RAISED - STACKED * bool(others)
        chance = rests * share * way.chance
        if chance * np.exp(way.log_ratio) > WORTHLESS:
            yield Stance(names[way.body], way.on, way.face, chance, way.log_ratio)


def _level(
    bodies: Bodies, planes: Mapping[str, Known], rests: float, chances: Sequence[tuple[str, Chance]]
) -> Iterator[tuple[str, str, float]]:
    """By how much likelier each is where it is free, for it may rest level above each plane on something unknown.

    Over what is not there, and is level by chance. ``chances``: of the bodies, with their names.
    """
    if rests == 1.0:
        return
    for plane, known in planes.items():
        ratios = bodies.stands.chance * np.exp(log_level(bodies.stands, known.plane))
        for (name, chance), one in zip(chances, np.bincount(bodies.stands.body, ratios, len(chances)), strict=True):
            above = one * rests * RAISED / (1.0 - rests)
            if above > WORTHLESS:
                yield name, plane, float(np.log1p(above) - np.log1p(chance.level * (one - 1.0)))


def _on_plane(name: str, stands: Stands, plane: Plane) -> Iterator[_Way]:
    """Each way once, by all that it may be off."""
    from scipy.special import logsumexp

    ratios = log_ratios(stands, plane)
    of = by_key(
        ((int(body), int(face)), k) for k, (body, face) in enumerate(zip(stands.body, stands.face, strict=True))
    )
    for (body, face), rows in of.items():
        chance = float(stands.chance[rows].sum())
        if chance > 0.0:
            ratio = logsumexp(ratios[rows], b=stands.chance[rows]) - np.log(chance)
            yield _Way(body, name, face, chance, float(ratio))


def _on_others(names: list[str], posed: Mapping[str, Hypothesis], bodies: Bodies, plane: Plane) -> Iterator[_Way]:
    """On what has its middle below, and its top under the foot."""
    axes, feet = plane.along, bodies.stands.foot
    middles = [float(plane.height(posed[name].middle)) for name in names]
    for k, name in enumerate(names):
        surface = posed[name].object_type.surface
        if surface is None:
            continue
        places = transform_points(posed[name].camera_from_object, surface.vertices)
        heights = plane.height(places)
        top = float(heights.max())
        area = shapely.MultiPoint(places[heights > top - TOP * np.ptp(heights)] @ axes).convex_hull.buffer(SLACK)
        on = shapely.contains_xy(area, *(feet @ axes).T)
        over = on & (np.array(middles)[bodies.stands.body] > middles[k]) & (bodies.stands.body != k)
        raised = Plane(plane.up, plane.offset - top)
        if over.any() and raised.offset > 0.0:
            own = np.flatnonzero(bodies.stands.body == k)
            some = Stands(*(part[over] for part in bodies.stands))
            if len(own):
                way = own[np.argmax((bodies.stands.chance * np.exp(log_level(bodies.stands, plane)))[own])]
                some = borne(some, bodies.stands, int(way))
            yield from _on_plane(name, some, raised)


def _told(name: str, known: Known, prior: float) -> SupportPlane:
    """The plane as the program is told: its tilts are those about level axes."""
    rows = tuple(_row(row) for row in _about_level_axes(known))
    return SupportPlane(name, _row(known.plane.up), -known.plane.offset, (rows[0], rows[1], rows[2]), prior)


def _about_level_axes(known: Known) -> Floats:
    """(3, 3) over turns about the camera's x, made level, and about what is level at right angles to it; and n·x."""
    up = known.plane.up
    first = np.eye(3)[0] - up[0] * up
    first = first / np.linalg.norm(first) if np.linalg.norm(first) > LEVEL else along_plane(up)[:, 0]
    second = np.cross(up, first)
    # a turn about the first moves the normal along -second, one about the second along the first
    to = np.zeros((3, 3))
    to[:2, :2] = np.stack([-second, first]) @ along_plane(up)
    to[2, 2] = -1.0
    return np.asarray(to @ known.covariance @ to.T)


def _row(values: Floats) -> Row:
    x, y, z = (float(value) for value in values)
    return x, y, z
