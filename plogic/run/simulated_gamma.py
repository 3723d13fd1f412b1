"""Γ without pixels: what detectors as good as Σ says would report of objects whose poses are known.

A feature is reported where D7 expects it: in the image, its viewpoint in one of its lobes, hidden by no opaque object,
itself among them. Of these as many as the type's hit rate says are reported, with the location noise of the type and,
where ``sigma_angle`` is stated, an angle; as one of the appearance types whose lobe holds the viewpoint, each as likely
as the others, for Σ does not say how they share. Of a feature with ``arms`` those that nothing hides are reported, too.
Clutter is as frequent as its rates, anywhere in the image, at any angle.

* ``Posed``: one object, ``Posed("box", camera_from_object)``
* ``Reported``: Γ, and which datum is of which feature of which object
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.frames import inverse
from geometry.visibility.rays import behind
from kb.clouds.lobes import in_lobe
from plogic.base.errors import InputError
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.judged.expectation import pose_of
from sensing.appearance import MAX_APPEARANCES, Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.arrays import Floats, Mask
    from geometry.camera import Camera
    from geometry.visibility.rays import RayMesh
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis

DETECTOR = "simulated"
NOISE = "noise"
"""The cause of clutter."""
SLACK = 0.004
"""Of its size, how far a body that is no type's must be before a place to hide it."""
DIGITS = 3
ALONG = 0.05
"""Of the type's size, how far along an arm it must be seen to be reported."""
READ = 10.0
"""Pixels along which a detector reads an arm: its direction is off by the location noise over this length."""
FULL = 2.0 * np.pi


class Posed(NamedTuple):
    """A type of Σ at a pose (4, 4), camera_from_object, m."""

    label: str
    camera_from_object: Floats


class Obstacle(NamedTuple):
    """A body of no type: what hides things behind it."""

    rays: RayMesh
    camera_from_object: Floats


@dataclass(frozen=True)
class Reported:
    """``causes``: by the id of each datum its feature, ``0/roof/apex`` of the first of the objects, or ``noise``."""

    gamma: Gamma
    causes: Mapping[str, str]


def check_written(kb: KnowledgeBase, labels: Sequence[str]) -> None:
    """Raise InputError for a learned type, as descriptors make its data, and for more noise than a Γ holds."""
    noise = sum(kb.rates.clutter[name] for name in kb.appearance_types)
    if noise > MAX_APPEARANCES:
        raise InputError(
            f"--gamma: detector.clutter: {noise:g} an image; a Γ holds {MAX_APPEARANCES:,} appearances at most"
        )
    for label in labels:
        if kb.type(label).learned is not None:
            raise InputError(
                f"--gamma: {label}: is learned, and its keypoints need pictures; without --gamma a picture is made"
            )


def simulated_gamma(
    kb: KnowledgeBase,
    objects: Sequence[Posed],
    camera: Camera,
    rng: np.random.Generator,
    obstacles: Sequence[Obstacle] = (),
) -> Reported:
    """What is reported of the objects before this camera, in an order that tells nothing.

    Raises InputError for a learned type.
    """
    check_written(kb, [one.label for one in objects])
    data = data_of((), camera)
    posed = [pose_of(kb.type(one.label), one.camera_from_object, data, kb) for one in objects]
    rows = [
        (f"{which}/{one.object_type.seen_features[f].name}", datum)
        for which, one in enumerate(posed)
        for f, datum in _of_one(kb, one, [other for other in posed if other is not one], obstacles, camera, rng)
    ]
    rows += [(NOISE, datum) for datum in _clutter(kb, camera, rng)]
    order = rng.permutation(len(rows))
    named = {f"a{n}": rows[i] for n, i in enumerate(order, 1)}
    data_named = tuple(
        Appearance(name, datum.type, datum.uv, DETECTOR, angle=datum.angle, arms=datum.arms)
        for name, (_, datum) in named.items()
    )
    return Reported(Gamma(camera, data_named), {name: cause for name, (cause, _) in named.items()})


class _Datum(NamedTuple):
    type: str
    uv: tuple[float, float]
    angle: float | None
    arms: tuple[float, ...]


def _of_one(
    kb: KnowledgeBase,
    one: Hypothesis,
    others: Sequence[Hypothesis],
    obstacles: Sequence[Obstacle],
    camera: Camera,
    rng: np.random.Generator,
) -> list[tuple[int, _Datum]]:
    """(feature, datum) of those that are reported; noise may lead what is near the border out of the image."""
    kind, table = one.object_type, one.object_type.lobes
    hidden = _hidden(one.at, others, obstacles)
    viewpoint = inverse(one.camera_from_object)[:3, 3]
    held = in_lobe(table, viewpoint[None], camera.f / kb.f_ref)[0]
    found = []
    for f in np.flatnonzero(one.expected(hidden)).tolist():
        feature = kind.seen_features[f]
        looks = sorted({table.types[lobe] for lobe in np.flatnonzero(held & (table.feature == f))})
        hit, look = rng.random() < kb.rates.hit[feature.type], looks[rng.integers(len(looks))]
        uv = one.uv[f] + rng.normal(0.0, kb.rates.sigma_of(feature.type), 2)
        angle, arms = _angle(kb, one, f, rng), _arms(kb, one, f, [one, *others], obstacles, rng)
        if hit and bool(camera.contains(uv)):
            found.append((f, _Datum(look, _rounded(uv), angle, arms)))
    return found


def _hidden(at: Floats, bodies: Sequence[Hypothesis], obstacles: Sequence[Obstacle]) -> Mask:
    """(N,) which places (N, 3) m, camera frame, opaque bodies hide."""
    opaque = [(one.object_type.surface, one.camera_from_object) for one in bodies if one.opaque]
    shapes = [(surface.rays, pose, surface.diameter) for surface, pose in opaque if surface is not None]
    hidden = np.zeros(len(at), bool)
    for rays, pose, size in [*shapes, *((rays, pose, rays.size) for rays, pose in obstacles)]:
        hidden |= behind(at, rays, pose, SLACK * size)
    return hidden


def _arms(
    kb: KnowledgeBase,
    one: Hypothesis,
    f: int,
    bodies: Sequence[Hypothesis],
    obstacles: Sequence[Obstacle],
    rng: np.random.Generator,
) -> tuple[float, ...]:
    """How the arms of a feature that are seen lie on the screen, radians, ascending."""
    feature, surface = one.object_type.seen_features[f], one.object_type.surface
    if not len(feature.arms) or surface is None:
        return ()
    arms = feature.arms @ one.camera_from_object[:3, :3].T
    seen = ~_hidden(one.at[f] + ALONG * surface.diameter * arms, bodies, obstacles)
    turned = screen_angle(arms, one.at[f]) + rng.normal(0.0, kb.rates.sigma_of(feature.type) / READ, len(arms))
    return _directions(turned[seen])


def _directions(angles: Floats) -> tuple[float, ...]:
    """Angles (N,) as a detector reports arms."""
    return tuple(sorted(round(float(angle), DIGITS + 1) for angle in angles % FULL))


def _angle(kb: KnowledgeBase, one: Hypothesis, f: int, rng: np.random.Generator) -> float | None:
    """How the feature's x axis lies on the screen, radians, where Σ says that angles tell that."""
    if kb.rates.sigma_angle is None:
        return None
    x_axis = one.camera_from_object[:3, :3] @ one.object_type.seen_features[f].rotation[:, 0]
    turned = float(screen_angle(x_axis, one.at[f])) + rng.normal(0.0, kb.rates.sigma_angle)
    return round(float(turned % FULL), DIGITS + 1)


def _clutter(kb: KnowledgeBase, camera: Camera, rng: np.random.Generator) -> list[_Datum]:
    """What nothing causes; of a look that some feature with arms has, with as many arms as such features have."""
    corner = np.array([camera.width, camera.height]) - 0.5
    armed: dict[str, list[int]] = {}
    for feature in (f for kind in kb.types for f in kind.seen_features if len(f.arms)):
        for name in {appearance.type for appearance in feature.appearances}:
            armed.setdefault(name, []).append(len(feature.arms))

    def arms(name: str) -> tuple[float, ...]:
        if name not in armed:
            return ()
        most = armed[name][rng.integers(len(armed[name]))]
        return _directions(rng.uniform(0.0, FULL, rng.integers(min(2, most), most, endpoint=True)))

    return [
        _Datum(name, _rounded(rng.uniform(-0.5, corner)), _any_angle(kb, rng), arms(name))
        for name in kb.appearance_types
        for _ in range(rng.poisson(kb.rates.clutter[name]))
    ]


def _any_angle(kb: KnowledgeBase, rng: np.random.Generator) -> float | None:
    return None if kb.rates.sigma_angle is None else round(float(rng.uniform(0.0, 2.0 * np.pi)), DIGITS + 1)


def _rounded(uv: Floats) -> tuple[float, float]:
    return round(float(uv[0]), DIGITS), round(float(uv[1]), DIGITS)
