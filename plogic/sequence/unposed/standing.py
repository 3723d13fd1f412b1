"""How probable what is detected is at a pose, of a hypothesis without one and of what stands around (formalism §3.8).

A pose predicts the changes of ev: the features of others that the body would hide are not expected, nor are its own
that others hide. What is expected is reported with its hit rate, what is not by chance. So where features of y lie
together undetected the body may be before them, and where a feature of y is detected it is not; the same of its own
features that y may hide. Used of the body's own data is *which* of its features were detected, never where.

* ``Reports``: which features were detected, ``Reports(detected, hit, chance)``
* ``Stander``: a hypothesis whose pose is known, with its features that the body may hide
* ``Target``: what decides the probability of a pose
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.frames import inverse, transform_points
from geometry.visibility.outline import is_closed
from plogic.sequence.next_view.expected import Body, Cloud
from plogic.sequence.unposed.drawn import UNLIKE, At, Prior, places

INSIDE = np.array([[0.577, 0.578, 0.5771]])
"""A direction along no edge, of the rays that tell what lies inside a body."""
POINTS = 60
"""Places of a surface that must lie outside another body (A4)."""


class Reports(NamedTuple):
    """Of F features: which were ``detected``, and how surely each is, where it is seen and, by chance, where not."""

    detected: Mask
    hit: Floats
    chance: Floats

    def log_likelihood(self, hidden: Mask) -> Floats:
        """(...) of what was reported and what was not, where these (..., F) are hidden and the others expected (D7)."""
        seen = self.hit + (1.0 - self.hit) * self.chance
        return np.where(hidden, _log(self.chance, self.detected), _log(seen, self.detected)).sum(axis=-1)


def _log(p: Floats, detected: Mask) -> Floats:
    bounded = np.clip(p, 1e-9, 1.0 - 1e-9)
    return np.asarray(np.where(detected, np.log(bounded), np.log1p(-bounded)))


@dataclass(frozen=True, eq=False)
class Stander:
    """``at`` (F, 3) m, camera frame: its features that are expected where the body without a pose hides none.

    ``reports`` of them. ``rival``: neither hides anything of the other (§4.1).
    """

    body: Body
    at: Floats
    reports: Reports
    rival: bool = False


@dataclass(frozen=True, eq=False)
class Target:
    """``reports`` of the features that are expected of the body alone, and of the ``standers``', are all that speaks.

    ``inside`` (F',): which of those that face the camera are in the image; ``asked``: of which of them reports are.
    """

    prior: Prior
    opaque: bool
    inside: Mask
    asked: Indices
    reports: Reports
    standers: tuple[Stander, ...]

    @property
    def unreported(self) -> "Target":
        """The same of which nothing is reported, and nobody knows from which side it is seen."""
        none, empty = np.zeros(0, np.intp), Reports(np.zeros(0, bool), np.zeros(0), np.zeros(0))
        prior = replace(self.prior, aspect=None)
        return replace(self, prior=prior, inside=np.zeros(0, bool), asked=none, reports=empty)

    def poses(self, at: At) -> Floats:
        """(N, 4, 4) camera_from_object."""
        poses = np.zeros((len(at.middle), 4, 4))
        poses[:, :3, :3], poses[:, 3, 3] = at.rotation, 1.0
        poses[:, :3, 3] = at.middle - at.rotation @ self.prior.cloud.middle
        return poses

    def log_likelihood(self, at: At) -> Floats:
        """(N,) of all reports; minus infinity where A4 forbids the pose."""
        poses, cloud, camera = self.poses(at), self.prior.cloud, self.prior.camera
        aspect = np.zeros(cloud.lobes.features, bool) if self.prior.aspect is None else self.prior.aspect
        turned = places(cloud)[aspect] @ np.swapaxes(at.rotation, 1, 2)
        points = turned + poses[:, None, :3, 3]
        inside = camera.contains(camera.project(points.reshape(-1, 3))).reshape(points.shape[:2])
        logs = (inside != self.inside).sum(axis=1) * UNLIKE
        logs += self.reports.log_likelihood(_behind_others(self.standers, points[:, self.asked]))
        for one in self.standers:
            if self.opaque and not one.rival:
                logs += one.reports.log_likelihood(_hides(cloud, poses, at.middle, one.at))
            logs[_shares_volume(cloud, poses, at.middle, one.body)] = -np.inf
        return logs


def _behind_others(standers: tuple[Stander, ...], points: Floats) -> Mask:
    """(N, F) which of the points (N, F, 3) m an opaque body is met before."""
    hidden = np.zeros(points.shape[:2], bool)
    for body in (one.body for one in standers if not one.rival):
        rays = body.cloud.rays
        if body.opaque and rays is not None:
            n, f = np.nonzero(~hidden & _meets_ball(body.middle, body.cloud.radius, points))
            if len(n):
                frame = inverse(body.reference_from_object)
                hidden[n, f] = rays.blocks(frame[:3, 3], transform_points(frame, points[n, f]), body.cloud.slack)
    return hidden


def _hides(cloud: Cloud, poses: Floats, middle: Floats, at: Floats) -> Mask:
    """(N, P) whether the body at each pose is met before the places (P, 3) m."""
    hidden = np.zeros((len(poses), len(at)), bool)
    n, p = np.nonzero(_meets_ball(middle[:, None], cloud.radius, at[None]))
    if len(n) and cloud.rays is not None:
        rotation = poses[n, :3, :3]
        eye = -np.einsum("nji,nj->ni", rotation, poses[n, :3, 3])
        hidden[n, p] = cloud.rays.blocks(eye, np.einsum("nji,nj->ni", rotation, at[p]) + eye, cloud.slack)
    return hidden


def _meets_ball(middle: Floats, radius: float, at: Floats) -> Mask:
    """(...,) whether the segment from the camera to ``at`` (..., 3) comes near the ball around ``middle`` (..., 3)."""
    length = np.maximum(np.linalg.norm(at, axis=-1), 1e-12)
    way = at / length[..., None]
    along = np.clip((way * middle).sum(axis=-1), 0.0, length)
    return np.asarray(((middle - along[..., None] * way) ** 2).sum(axis=-1) < radius**2)


def _shares_volume(cloud: Cloud, poses: Floats, middle: Floats, body: Body) -> Mask:
    """(N,) whether places of the one's surface lie inside the other (A4); what is not closed has no inside."""
    other = body.cloud
    result = np.zeros(len(poses), bool)
    close = np.flatnonzero(np.linalg.norm(middle - body.middle, axis=1) < cloud.radius + other.radius)
    if cloud.rays is None or other.rays is None or not len(close):
        return result
    other_from_own = inverse(body.reference_from_object) @ poses[close]
    for into, frames, points in (
        (other, other_from_own, _surface(cloud)),
        (cloud, np.linalg.inv(other_from_own), _surface(other)),
    ):
        if into.rays is None or not is_closed(into.rays.triangles):
            continue
        moved = np.einsum("nij,pj->npi", frames[:, :3, :3], points) + frames[:, None, :3, 3]
        result[close] |= _inside(into, moved.reshape(-1, 3)).reshape(len(close), len(points)).any(axis=1)
    return result


def _surface(cloud: Cloud) -> Floats:
    """(P, 3) m, corners and features, a hundredth further in: what touches shares nothing."""
    vertices = cloud.rays.vertices if cloud.rays is not None else np.zeros((0, 3))
    points = np.concatenate([some[:: -(-len(some) // POINTS)] for some in (vertices, places(cloud)) if len(some)])
    return np.asarray(cloud.middle + 0.99 * (points - cloud.middle))


def _inside(cloud: Cloud, points: Floats) -> Mask:
    """(N,) whether a ray from the places (N, 3) m leaves the closed surface by the facet that it meets first."""
    rays = cloud.rays
    inside = np.asarray(((points - cloud.middle) ** 2).sum(axis=1) < cloud.radius**2)
    if rays is not None and inside.any():
        a, b, c = np.moveaxis(rays.vertices[rays.triangles], 1, 0)
        _, facet = rays.first_triangle(points[inside], INSIDE)
        inside[inside] = (facet >= 0) & (np.cross(b - a, c - a)[facet] @ INSIDE[0] > 0.0)
    return inside
