"""What may stand where, and what each world of it leads to expect from a camera (D7).

Expected is every feature that is in the image, in a lobe, and not Behind what stands there.

* ``Cloud``: how a type is seen, ``Cloud("t2", features=("roof/apex", ...), kinds=("apex", ...), lobes=table, hit=[0.95,
  ...], rays=..., ...)``
* ``Body``: one hypothesis, ``Body("h2", cloud, reference_from_object, opaque=True)``
* ``Prospect``: bodies, worlds over them with their probabilities, and the detector, ``Prospect(bodies, present,
  probability, ...)``
* ``Sightings``: the N features of all bodies that would be expected if their body stood alone, with what may hide them

The *reference* frame is any one in which bodies and candidate cameras are both told: the present camera's, or the
world's.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from geometry.visibility.rays import RayMesh, behind
from kb.clouds.lobes import LobeTable, in_lobe
from plogic.facts.hypothesis import Seen, expected


@dataclass(frozen=True, eq=False)
class Cloud:
    """How a type is seen: F ``features`` by id, their ``kinds`` (types), L lobes (§2.7), and hit rates ``hit`` (L,).

    ``rays``: its surface, None where it has none. ``middle`` (3,) and ``radius``, m, object frame. ``slack``, m: how
    far before a feature the surface must be met to hide it (§3.4); ``measured``: lobes were measured on the body
    itself, which then hides nothing more of its own.
    """

    name: str
    features: tuple[str, ...]
    kinds: tuple[str, ...]
    lobes: LobeTable
    hit: Floats
    rays: RayMesh | None
    middle: Floats
    radius: float
    slack: float
    measured: bool = False


@dataclass(frozen=True, eq=False)
class Body:
    """One hypothesis at ``reference_from_object`` (4, 4), m."""

    id: str
    cloud: Cloud
    reference_from_object: Floats
    opaque: bool

    @property
    def middle(self) -> Floats:
        """(3,) m, reference frame."""
        return transform_points(self.reference_from_object, self.cloud.middle[None])[0]


@dataclass(frozen=True, eq=False)
class Prospect:
    """B bodies and W worlds: ``present`` (W, B), ``probability`` (W,) that sums to 1 over those that are listed.

    ``rivals``: unordered pairs of ids that never hide each other (§4.1). ``clutter``: expected data of noise an image,
    by appearance type, of any
    other type one. ``tolerance``: pixels (D8). ``f_ref``: pixels (§2.7).
    """

    bodies: tuple[Body, ...]
    present: Mask
    probability: Floats
    rivals: frozenset[frozenset[str]]
    clutter: Mapping[str, float]
    tolerance: float
    f_ref: float

    @property
    def marginals(self) -> Floats:
        """(B,) P(present) of each body over the listed worlds."""
        return np.asarray(self.probability @ self.present)

    @property
    def middle(self) -> Floats | None:
        """(3,) m, reference frame: the middle of what may be there, by its probability; None where nothing is."""
        weights = self.marginals
        if not len(weights) or weights.sum() <= 0.0:
            return None
        return np.asarray(weights @ np.array([body.middle for body in self.bodies]) / weights.sum())

    @property
    def radius(self) -> float:
        """M from the middle within which everything is that may be there; 0 where nothing is."""
        middle = self.middle
        if middle is None:
            return 0.0
        some = [body for body, weight in zip(self.bodies, self.marginals, strict=True) if weight > 0.0]
        return max(float(np.linalg.norm(body.middle - middle)) + body.cloud.radius for body in some)


@dataclass(frozen=True, eq=False)
class Sightings:
    """N features: ``body`` (N,) and ``feature`` (N,) which; ``uv`` (N, 2) pixels.

    ``looks`` (N, T) the types that lobes report from here.

    ``hit`` (N,): the greatest rate of a lobe that holds the camera. ``hidden`` (N, B): Behind which other bodies it is,
    transparent ones and rivals left out. ``names`` (T,): the types.
    """

    body: Indices
    feature: Indices
    uv: Floats
    looks: Mask
    hit: Floats
    hidden: Mask
    names: tuple[str, ...]

    def expected(self, present: Mask) -> Mask:
        """(W, N) Expected in each world (D7), where all are Expected alone: ``present`` (W, B)."""
        veiled = present.astype(np.float64) @ self.hidden.T.astype(np.float64) > 0.0
        everywhere = np.ones(len(self.body), bool)
        alone = Seen(everywhere, everywhere, ~everywhere)
        return np.asarray(present[:, self.body] & expected(alone, opaque=False, hidden=veiled))


class _Alone(NamedTuple):
    """Of one body: expected features (M,), their places (M, 3) in the camera frame, looks (M, T), rates (M,)."""

    feature: Indices
    at: Floats
    looks: Mask
    hit: Floats


def sightings(prospect: Prospect, camera: Camera, reference_from_camera: Floats) -> Sightings:
    """What would be seen of each body from a camera there, whose own pose in the world does not matter."""
    camera_from_reference = inverse(reference_from_camera)
    names = tuple(sorted({name for body in prospect.bodies for name in body.cloud.lobes.types}))
    poses = [camera_from_reference @ body.reference_from_object for body in prospect.bodies]
    parts = [
        _alone(body, pose, camera, camera.f / prospect.f_ref, names)
        for body, pose in zip(prospect.bodies, poses, strict=True)
    ]
    hidden = [_hidden(i, part.at, poses, prospect) for i, part in enumerate(parts)]
    at = np.concatenate([part.at for part in parts]) if parts else np.zeros((0, 3))
    return Sightings(
        body=np.repeat(np.arange(len(parts)), [len(part.feature) for part in parts]),
        feature=np.concatenate([part.feature for part in parts]) if parts else np.zeros(0, np.intp),
        uv=camera.project(at),
        looks=np.concatenate([part.looks for part in parts]) if parts else np.zeros((0, 0), bool),
        hit=np.concatenate([part.hit for part in parts]) if parts else np.zeros(0),
        hidden=np.concatenate(hidden) if hidden else np.zeros((0, 0), bool),
        names=names,
    )


def _alone(body: Body, pose: Floats, camera: Camera, granularity: float, names: tuple[str, ...]) -> _Alone:
    """Of a body at camera_from_object: in the image, in a lobe, and not Behind its own host where that is opaque."""
    cloud, table = body.cloud, body.cloud.lobes
    held = np.flatnonzero(in_lobe(table, inverse(pose)[:3, 3], granularity)[0])
    place = {name: i for i, name in enumerate(names)}
    looks, hit = np.zeros((table.features, len(names)), bool), np.zeros(table.features)
    looks[table.feature[held], [place[table.types[lobe]] for lobe in held]] = True
    np.maximum.at(hit, table.feature[held], cloud.hit[held])
    first = np.full(table.features, -1)
    first[table.feature[::-1]] = np.arange(len(table.feature))[::-1]
    feature = np.flatnonzero(looks.any(axis=1))
    at = transform_points(pose, table.at[first[feature]])
    own = np.zeros(len(at), bool)
    if body.opaque and cloud.rays is not None and not cloud.measured:
        own = behind(at, cloud.rays, pose, cloud.slack)
    shown = expected(Seen(camera.contains(camera.project(at)), np.ones(len(at), bool), own), body.opaque)
    return _Alone(feature[shown], at[shown], looks[feature[shown]], hit[feature[shown]])


def _hidden(which: int, at: Floats, poses: list[Floats], prospect: Prospect) -> Mask:
    """(M, B) which other opaque bodies the features (M, 3) of one lie Behind.

    Rivals hide nothing of each other (§4.1).
    """
    bodies = prospect.bodies
    hidden = np.zeros((len(at), len(bodies)), bool)
    for other, body in enumerate(bodies):
        rays, pair = body.cloud.rays, frozenset((bodies[which].id, body.id))
        if (
            other == which
            or not body.opaque
            or rays is None
            or not len(at)
            or pair in prospect.rivals
            or _beside(body.cloud, poses[other], at)
        ):
            continue
        hidden[:, other] = behind(at, rays, poses[other], body.cloud.slack)
    return hidden


def _beside(cloud: Cloud, pose: Floats, at: Floats) -> bool:
    """Whether no line of sight to the features (M, 3) comes near the ball around a body.

    Then there is nothing to cast.
    """
    middle = transform_points(pose, cloud.middle[None])[0]
    length = np.linalg.norm(at, axis=1)
    along = np.clip(at @ middle / np.maximum(length, 1e-12), 0.0, length)
    nearest = np.linalg.norm(middle - at * (along / np.maximum(length, 1e-12))[:, None], axis=1)
    return bool((nearest > cloud.radius).all())


class Sites(NamedTuple):
    """S sites: ``of`` (N,) the site of each sighting; ``expected`` (W, N) the sightings in each world.

    ``report`` (W, S) P(a datum there | w).
    """

    of: Indices
    expected: Mask
    report: Floats


def sites(seen: Sightings, prospect: Prospect, camera: Camera) -> Sites:
    """In world w a site reports with probability 1 − (1 − c) Π (1 − h) over the features that are Expected there in w.

    c: the probability of clutter of one of its types within the tolerance's area.
    """
    of, count = _merged(seen, prospect.tolerance)
    expected = seen.expected(prospect.present)
    miss = np.zeros((len(prospect.present), count))
    logs = np.log1p(-np.minimum(seen.hit, 1.0 - 1e-9))
    for n, site in enumerate(of):
        miss[:, site] += np.where(expected[:, n], logs[n], 0.0)
    return Sites(of, expected, -np.expm1(miss - _clutter(seen, of, count, prospect, camera)))


def _merged(seen: Sightings, tolerance: float) -> tuple[Indices, int]:
    """The site (N,) of each sighting, and their number.

    Whatever lies near and shares a type, and what lies near that, in no order.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    number = len(seen.uv)
    if not number:
        return np.zeros(0, np.intp), 0
    pairs = cKDTree(seen.uv).query_pairs(tolerance, output_type="ndarray")
    alike = (
        pairs[(seen.looks[pairs[:, 0]] & seen.looks[pairs[:, 1]]).any(axis=1)] if len(pairs) else pairs.reshape(0, 2)
    )
    graph = coo_matrix((np.ones(len(alike)), (alike[:, 0], alike[:, 1])), shape=(number, number))
    count, of = connected_components(graph, directed=False)
    return np.asarray(of, np.intp), int(count)


def _clutter(seen: Sightings, of: Indices, count: int, prospect: Prospect, camera: Camera) -> Floats:
    """(S,) the expected number of data of clutter within the tolerance of a site, of the types it may report."""
    looks = np.zeros((count, len(seen.names)), bool)
    np.logical_or.at(looks, of, seen.looks)
    density = np.array([prospect.clutter.get(name, 1.0) for name in seen.names]) / float(camera.width * camera.height)
    return np.asarray(looks @ density * np.pi * prospect.tolerance**2)
