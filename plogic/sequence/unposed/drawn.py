"""Poses of a type of which nobody knows where it stands (formalism §9.5): the prior, and poses drawn from it.

The prior is the one that hypotheses are judged with (``plogic.match.judged.evidence``): even in the image, in log depth
and in rotation, between so many times nearer and farther than what is beside it. What is known of the hypothesis is
which of its features are expected of it alone (in the image, in a lobe, not Behind its own host): that tells from which
side it is seen, and nothing of where it stands. So directions of view are even over those that lead to expect these.

Places are of two strata: *near* others (the balls around both meet on the screen), and apart from all, where nothing
hides anything.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.camera import Camera
from geometry.cones import even_directions
from kb.clouds.lobes import in_lobe
from plogic.sequence.next_view.expected import Body, Cloud

BEYOND = float(np.e)
"""How many times nearer or farther than all others it may be."""
PLACES = 40_000
"""Places from which both strata are taken: the share that is near is known to half a percent."""
NEAR, APART = 4000, 400
"""Poses of each stratum."""
DIRECTIONS, POOL = 1024, 32_000
"""Cells of the sphere of directions, 6 degrees across, and directions of which poses take theirs."""
UNLIKE = float(np.log(0.05 / 0.95))
"""Log-odds that geometry says another thing of a feature, of the body alone, than what was judged of it."""


class At(NamedTuple):
    """N poses: ``rotation`` (N, 3, 3) camera_from_object and ``middle`` (N, 3) m of the body, camera frame."""

    rotation: Floats
    middle: Floats

    def take(self, which: Indices) -> "At":
        """Those at the indices."""
        return At(self.rotation[which], self.middle[which])


@dataclass(frozen=True, eq=False)
class Prior:
    """Where a type may be beside ``others``.

    ``aspect`` (F,): the features that are in a lobe and not Behind their own host, the side that it shows; None where
    nobody knows.
    """

    cloud: Cloud
    aspect: Mask | None
    others: tuple[Body, ...]
    camera: Camera

    @cached_property
    def depth(self) -> tuple[float, float]:
        """Least and greatest depth of its middle, m; beside nobody, from where its picture fills the image."""
        least = 1.05 * self.cloud.radius
        if not self.others:
            near = 2.0 * self.cloud.radius * self.camera.f / max(self.camera.width, self.camera.height)
            return max(near, least), max(near, least) * BEYOND**2
        beside = [float(body.middle[2]) for body in self.others]
        return max(min(beside) / BEYOND, least), max(max(beside) * BEYOND, 1.5 * least)

    @cached_property
    def directions(self) -> Floats:
        """(D, 3) unit, evenly over the sphere."""
        return even_directions(DIRECTIONS)

    @cached_property
    def _cells(self) -> Any:  # noqa: ANN401 - scipy ships no types
        from scipy.spatial import cKDTree

        return cKDTree(self.directions)

    @cached_property
    def seen_from(self) -> Floats:
        """(D,) log-probability of each direction, from the middle to the camera, by what is expected of it alone."""
        if self.aspect is None:
            return np.full(DIRECTIONS, -np.log(DIRECTIONS))
        distance = max(float(np.sqrt(self.depth[0] * self.depth[1])), 2.0 * self.cloud.radius)
        seen = _in_view(self.cloud, self.cloud.middle + distance * self.directions)
        wrong = (seen != self.aspect).sum(axis=1)
        logs = wrong * UNLIKE
        return np.asarray(logs - np.log(np.exp(logs - logs.max()).sum()) - logs.max())

    def log_direction(self, at: At) -> Floats:
        """(N,) log-probability of the direction that each pose is seen from."""
        to_camera = -at.middle / np.linalg.norm(at.middle, axis=1, keepdims=True)
        inward = np.einsum("nji,nj->ni", at.rotation, to_camera)
        return np.asarray(self.seen_from[self._cells.query(inward)[1]])

    def near(self, middle: Floats) -> Mask:
        """(N,) whether the balls around it, at the middles (N, 3), and around another meet on the screen."""
        distance = np.linalg.norm(middle, axis=1)
        own = np.arcsin(np.minimum(self.cloud.radius / distance, 1.0))
        result = np.zeros(len(middle), bool)
        for body in self.others:
            there = float(np.linalg.norm(body.middle))
            angle = np.arccos(np.clip(middle @ body.middle / (distance * there), -1.0, 1.0))
            result |= angle < own + np.arcsin(min(body.cloud.radius / there, 1.0)) + 1.0 / self.camera.f
        return result

    def allows_near(self, middle: Floats) -> Mask:
        """(N,) whether the middles (N, 3) are of the stratum near others."""
        z = middle[:, 2]
        inside = (z > self.depth[0]) & (z < self.depth[1]) & self.camera.contains(self.camera.project(middle))
        return np.asarray(inside & self.near(middle))

    def strata(self, rng: np.random.Generator) -> tuple[At, At, float]:
        """Poses near others and poses apart, and the share of those near."""
        camera = self.camera
        uv = rng.uniform(-0.5, [camera.width - 0.5, camera.height - 0.5], (PLACES, 2))
        z = np.exp(rng.uniform(np.log(self.depth[0]), np.log(self.depth[1]), PLACES))
        middle = np.concatenate([camera.normalised(uv), np.ones((PLACES, 1))], axis=1) * z[:, None]
        near = self.near(middle)
        return self._at(middle[near][:NEAR], rng), self._at(middle[~near][:APART], rng), float(near.mean())

    def _at(self, middle: Floats, rng: np.random.Generator) -> At:
        pool = rng.normal(size=(POOL, 3))
        pool /= np.linalg.norm(pool, axis=1, keepdims=True)
        share = np.exp(self.seen_from[self._cells.query(pool)[1]])
        direction = pool[rng.choice(POOL, len(middle), p=share / share.sum())]
        return At(_turned(direction, middle, rng.uniform(0.0, 2.0 * np.pi, len(middle))), middle)


def _in_view(cloud: Cloud, viewpoints: Floats) -> Mask:
    """(V, F) which features are in a lobe and not Behind their own host, from viewpoints (V, 3) m, object frame.

    Of lobes the direction alone counts: nobody knows the distance.
    """
    table = cloud.lobes
    order = np.argsort(table.feature, kind="stable")
    first = np.flatnonzero(np.r_[True, np.diff(table.feature[order]) > 0])[: len(order)]
    held = np.zeros((len(viewpoints), table.features), bool)
    if len(order):
        inside = in_lobe(table, viewpoints)[:, order]
        held[:, table.feature[order][first]] = np.logical_or.reduceat(inside, first, axis=1)
    if cloud.rays is not None and not cloud.measured:
        which, feature = np.nonzero(held)
        held[which, feature] = ~cloud.rays.blocks(viewpoints[which], places(cloud)[feature], cloud.slack)
    return held


def places(cloud: Cloud) -> Floats:
    """(F, 3) m, object frame."""
    at = np.zeros((cloud.lobes.features, 3))
    at[cloud.lobes.feature] = cloud.lobes.at
    return at


def _turned(direction: Floats, middle: Floats, roll: Floats) -> Floats:
    """camera_from_object (N, 3, 3) by which the directions (N, 3) point from the middles (N, 3) to the camera."""
    to_camera = -middle / np.linalg.norm(middle, axis=1, keepdims=True)
    about = np.zeros((len(roll), 3, 3))
    about[:, 0, 0] = about[:, 1, 1] = np.cos(roll)
    about[:, 1, 0], about[:, 0, 1], about[:, 2, 2] = np.sin(roll), -np.sin(roll), 1.0
    return np.asarray(_frames(to_camera) @ about @ np.swapaxes(_frames(direction), 1, 2))


def _frames(z: Floats) -> Floats:
    """(N, 3, 3) right-handed, the third axes the unit ``z`` (N, 3)."""
    helper = np.where(np.abs(z[:, :1]) < 0.8, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)
