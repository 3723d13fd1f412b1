"""Support planes: where bodies may stand, the plane that several agree on, and what one tells of it (formalism §9.9).

A body that stands on one of its faces fixes a plane: two tilts, about as well as its own turn is known, and a height at
its foot, about as well as its distance is. What several bodies tell of one plane is put together by least squares. How
much likelier a body's pose is, where it stands on a plane, than where it is free is ρ: the density of its two tilts and
its height against the plane, over that of a free body, whose way down is even over the directions that a camera can
see planes in from above, and whose height is even in the logarithm.

* ``Stands``: N ways in which bodies may stand, as arrays; ``ways(...)`` those of one body, ``joined`` those of several
* ``Contact``: what a body stands on, and how exactly: what moves its pose there
* ``Known``: a plane with its covariance (3, 3): of the tilts about two axes along it, rad, and of its height, m; where
  something is there in a part of it alone, a top, with that ``Area``
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints, Mask
from geometry.bodies.resting import Plane, RestingFaces

FAR = float(np.log(100.0))
"""Logarithm of the ratio of the greatest to the least height of a camera above what it looks at."""
LOOSE = 1.0
"""Standard deviations, of tilts (rad) and of the height's logarithm, of a plane of which nothing is known."""


GRAZING = 0.08
"""Sine of the angle at which a plane is seen, at the least."""
ALIKE_UP, ALIKE_HEIGHT = 0.1, 0.05
"""Planes are alike whose normals differ by less (rad), and whose heights by less than this share."""


def alike(one: Plane, other: Plane, share: float = 1.0) -> bool:
    """Whether two planes, both below the camera, are nearly the same, within a ``share`` of what is alike."""
    turned, higher = one.turned(other), abs(np.log(one.offset / other.offset))
    return bool(turned < share * ALIKE_UP and higher < share * ALIKE_HEIGHT)


class Stands(NamedTuple):
    """``body``, ``face`` (N,): whose ways, and on which faces; ``chance`` (N,) of the face, of those seen from above.

    ``up`` (N, 3) the plane's normal, ``foot`` (N, 3) m its place under the body's middle, both in the camera's frame;
    ``tilt`` (N,) rad and ``high`` (N,) m: standard deviations. The body is ``tall`` and ``wide`` (N,) m there.
    ``noise`` (N,): which of ``NOISES`` is in them, -1 where none is.
    """

    body: Ints
    face: Ints
    chance: Floats
    up: Floats
    foot: Floats
    tilt: Floats
    high: Floats
    tall: Floats
    wide: Floats
    noise: Ints


class Noise(NamedTuple):
    """Standard deviations by which true bodies are off the planes that they stand on, for meshes are not exact.

    ``tilt``: rad; ``level``: of the height, a share of the distance; ``share``: of the bodies that are so.
    """

    tilt: float
    level: float
    share: float = 1.0


NOISES = Noise(0.005, 0.001, 0.45), Noise(0.035, 0.005, 0.45), Noise(0.12, 0.009, 0.1)
"""Those of what is drawn from its mesh, of scans, and of what stands otherwise than its mesh would: rendered bodies
are of the first, in photos nearly all of ``ycb`` of the second, and a fifth of ``lmo`` of the third. With the mean
shares of the three sets true poses of ``lmo`` speak for their planes by 465 nats, of ``ycb`` by 55; with one noise for
all bodies, the best of each set, by 449 and 56 (``python benchmarks/planes.py KB DATASET``)."""


class Area(NamedTuple):
    """What of a plane is within ``wide`` m of the place above or below ``at`` (3,), camera's frame."""

    at: Floats
    wide: float


class Known(NamedTuple):
    """A ``plane``, and the ``covariance`` (3, 3) of its tilts about ``plane.along``, rad, and of its height, m.

    ``noise``: that of the bodies that stand on it; ``area``: where there is something to stand on, None for all of it.
    """

    plane: Plane
    covariance: Floats
    noise: Noise = NOISES[1]
    area: Area | None = None

    def over(self, places: Floats, beside: Floats | float = 0.0) -> Mask:
        """(N,) which of places (N, 3) are above or below what is there, or so many metres ``beside`` it."""
        if self.area is None:
            return np.ones(len(places), bool)
        off = places - self.area.at
        return np.asarray(np.linalg.norm(off @ self.plane.along, axis=1) < self.area.wide + beside)

    def same(self, other: "Known", share: float = 1.0) -> bool:
        """Whether two are nearly the same, within a ``share`` of what is alike, and in nearly the same place."""
        if self.area is None or other.area is None:
            return self.area is other.area and alike(self.plane, other.plane, share)
        return alike(self.plane, other.plane, share) and bool(self.over(other.area.at[None], -0.5 * self.area.wide)[0])


def ways(body: int, faces: RestingFaces, pose: Floats, middle: Floats, tilt: float, spread: Floats) -> Stands:
    """How a body at ``pose`` (4, 4) may stand, of those planes that the camera sees from above.

    ``middle`` (3,) m of the body, its frame; its turn is known to ``tilt`` rad, its place to ``spread`` (3, 3) m².
    """
    up, offset = faces.planes(pose)
    here = pose[:3, :3] @ middle + pose[:3, 3]
    seen = offset > GRAZING * np.linalg.norm(here)
    up, offset, chance = up[seen], offset[seen], faces.weight[seen]
    foot = here - (up @ here + offset)[:, None] * up
    high = np.sqrt(np.einsum("ni,ij,nj->n", up, spread, up))
    number = len(up)
    total = chance.sum()
    return Stands(
        np.full(number, body),
        np.flatnonzero(seen),
        chance / total if total > 0.0 else chance,
        up,
        foot,
        np.hypot(tilt, faces.bent[seen]),
        high,
        faces.tall[seen],
        faces.wide[seen],
        np.full(number, -1),
    )


def noisy(stands: Stands) -> Stands:
    """The same of bodies that are off what they stand on as well, each by one of ``NOISES``."""
    return joined(
        [off_by(stands, noise)._replace(noise=np.full(len(stands.body), k)) for k, noise in enumerate(NOISES)]
    )


def off_by(stands: Stands, noise: Noise) -> Stands:
    """The same of those that are off by one noise."""
    far, chance = np.linalg.norm(stands.foot, axis=1), noise.share * stands.chance
    tilt, high = np.hypot(stands.tilt, noise.tilt), np.hypot(stands.high, noise.level * far)
    return stands._replace(chance=chance, tilt=tilt, high=high)


def noise_of(stands: Stands, share: Floats) -> Noise:
    """By how much those are off that stand on a plane, each counted by its ``share`` (N,)."""
    known = stands.noise >= 0
    told = np.bincount(stands.noise[known], share[known], minlength=len(NOISES))
    squares = np.array([(noise.tilt**2, noise.level**2) for noise in NOISES])
    if not told.sum() > 0.0:
        return NOISES[1]
    tilt, level = np.sqrt(told @ squares / told.sum())
    return Noise(float(tilt), float(level))


_NO, _NONE, _NOWHERE = np.zeros(0, np.intp), np.zeros(0), np.zeros((0, 3))
_NOTHING = Stands(_NO, _NO, _NONE, _NOWHERE, _NOWHERE, _NONE, _NONE, _NONE, _NONE, _NO)


def joined(some: Sequence[Stands]) -> Stands:
    """Those of all."""
    return Stands(*(np.concatenate(part) for part in zip(_NOTHING, *some, strict=True)))


def log_free(offset: Floats | float) -> Floats:
    """Ln of the density, per steradian and metre, of tilts and heights of a free body against planes so far below."""
    return np.asarray(-np.log(2.0 * np.pi * FAR * np.asarray(offset)))


def borne(stands: Stands, by: Stands, way: int) -> Stands:
    """The same on the top of a body that stands in a way of its own, and is as far off there as that tells."""
    return stands._replace(tilt=np.hypot(stands.tilt, by.tilt[way]), high=np.hypot(stands.high, by.high[way]))


def top_of(stands: Stands, way: int, known: Known, high: float) -> Known:
    """The top of a body that stands so, its foot ``high`` m above a plane."""
    plane = Plane(known.plane.up, known.plane.offset - high - float(stands.tall[way]))
    return known._replace(plane=plane, area=Area(stands.foot[way], float(stands.wide[way])))


def off(stands: Stands, plane: Plane) -> tuple[Floats, Floats]:
    """(N, 2) rad by which each is tilted against a plane, about its axes, and (N,) m by which it is above."""
    side = stands.up @ plane.along
    angle = np.arccos(np.clip(stands.up @ plane.up, -1.0, 1.0))
    length = np.linalg.norm(side, axis=1)
    return side * (angle / np.maximum(length, 1e-12))[:, None], plane.height(stands.foot)


def log_ratios(stands: Stands, plane: Plane) -> Floats:
    """(N,) ln ρ of each way of standing on a plane."""
    tilted, above = off(stands, plane)
    squares = (tilted**2).sum(axis=1) / stands.tilt**2 + (above / stands.high) ** 2
    return np.asarray(-0.5 * squares - _volumes(stands) - log_free(plane.offset))


def log_level(stands: Stands, plane: Plane) -> Floats:
    """(N,) ln of how much likelier each way is of a body that is level above a plane, at any height up to the camera.

    Over a free one.
    """
    tilted, above = off(stands, plane)
    squares = (tilted**2).sum(axis=1) / stands.tilt**2
    level = -0.5 * squares - np.log(2.0 * np.pi) - 2.0 * np.log(stands.tilt) - np.log(plane.offset)
    return np.where(above > -2.0 * stands.high, level - log_free(plane.offset), -np.inf)


def log_peaks(stands: Stands) -> Floats:
    """(N,) ln ρ of each way of standing on the very plane that it fixes."""
    offset = np.maximum(-(stands.up * stands.foot).sum(axis=1), 1e-9)
    return np.asarray(-_volumes(stands) - log_free(offset))


def _volumes(stands: Stands) -> Floats:
    return np.asarray(1.5 * np.log(2.0 * np.pi) + 2.0 * np.log(stands.tilt) + np.log(stands.high))


def fitted(stands: Stands, share: Floats, plane: Plane, level: Floats | float = 0.0) -> Known:
    """The plane near one on which these stand, each counted by its ``share`` (N,); or ``level`` (N,) above it."""
    tilted, above = off(stands, plane)
    axes = plane.along
    by_tilt, by_height = (share + level) / stands.tilt**2, share / stands.high**2
    # a plane of the steps (a, b, c) has the normal up + a·first + b·second and is c higher
    slope = np.column_stack([stands.foot @ axes, np.ones(len(share))])
    told = (slope * by_height[:, None]).T @ slope + np.diag([by_tilt.sum(), by_tilt.sum(), 0.0])
    told += np.diag(LOOSE * np.array([1.0, 1.0, plane.offset]) ** -2.0)
    aim = -slope.T @ (by_height * above)
    aim[:2] += (by_tilt[:, None] * tilted).sum(axis=0)
    step = np.linalg.solve(told, aim)
    up = plane.up + axes @ step[:2]
    length = float(np.linalg.norm(up))
    new = Plane(up / length, (plane.offset + float(step[2])) / length)
    return Known(new, np.asarray(np.linalg.inv(told)))


TIPPED = 0.6
"""Radians beyond which a face is not what a body stands on."""


class Contact(NamedTuple):
    """What is ``known`` of a plane, and the ``faces`` of a body that stands on it."""

    known: Known
    faces: RestingFaces

    def normal(self, pose: Floats, middle: Floats) -> tuple[Floats, Floats]:
        """(6, 6) and (6,): what contact tells of a step (w rad, v m) about the ``middle`` (3,) of a body, its frame.

        Nothing where none of its faces is near the plane.
        """
        found = self._off(pose, middle)
        if found is None:
            return np.zeros((6, 6)), np.zeros(6)
        up, off, sigma = found
        slope = np.zeros((3, 6))
        slope[:2, :3] = np.cross(up, self.known.plane.along.T)
        slope[2, 3:] = self.known.plane.up
        weighed = slope / sigma[:, None] ** 2
        return weighed.T @ slope, -weighed.T @ off

    def log_density(self, pose: Floats, middle: Floats) -> float:
        """Ln of how likely a body that stands there is so far off, over the most that can be."""
        found = self._off(pose, middle)
        return (
            -0.5 * (TIPPED / self.known.noise.tilt) ** 2
            if found is None
            else -0.5 * float(((found[1] / found[2]) ** 2).sum())
        )

    def _off(self, pose: Floats, middle: Floats) -> tuple[Floats, Floats, Floats] | None:
        """The normal (3,) of the face nearest to the plane; two tilts and a height (3,), and how well each is known."""
        if not len(self.faces.reach):
            return None
        plane, covariance, noise = self.known[:3]
        ups = -self.faces.down @ pose[:3, :3].T
        face = int(np.argmax(ups @ plane.up))
        if ups[face] @ plane.up < np.cos(TIPPED):
            return None
        axes, here = plane.along, pose[:3, :3] @ middle + pose[:3, 3]
        high = float(plane.height(here)) - float(self.faces.reach[face] - self.faces.down[face] @ middle)
        slope = np.append(here @ axes, 1.0)
        level = np.hypot(noise.level * np.linalg.norm(here), np.sqrt(slope @ covariance @ slope))
        tilted = np.sqrt(noise.tilt**2 + self.faces.bent[face] ** 2 + np.diag(covariance)[:2])
        return ups[face], np.append(ups[face] @ axes, high), np.append(tilted, level)
