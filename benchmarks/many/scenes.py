"""The scenes of ``plogic bench many``.

Γ of five to ten objects, partly one behind another, among clutter, with its truth.

* ``Scene``: one Γ, what stands there, and which datum is of which feature of whom
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.clutter.scenes import CAMERA, picture, surface_of, visible
from benchmarks.clutter.types import SLACK, Detector
from benchmarks.many.placing import OBJECTS, placed, visible_shares
from benchmarks.many.types import DETECTOR, frequencies
from benchmarks.recognition.score import Truth
from geometry.frames import transform_points
from geometry.visibility.rays import behind
from plogic.match.gamma.grid import screen_angle
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from benchmarks.many.placing import Placed
    from kb.clouds.cloud import KnowledgeBase

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

NOISE = 0.3
"""Share of all data that is clutter."""


@dataclass(frozen=True, eq=False)
class Scene:
    """``causes``: of a datum that is no clutter, by its id, the index of the object and of its feature."""

    gamma: Gamma
    truths: tuple[Truth, ...]
    causes: Mapping[str, tuple[int, int]]


class _Reported(NamedTuple):
    feature: Indices  # (N,), -1 for clutter
    looks: Indices  # (N,) number of the appearance type
    uv: Floats  # (N, 2) pixels
    angle: Floats  # (N,) radians


def scene(kb: KnowledgeBase, seed: int, number: tuple[int, int] = OBJECTS) -> Scene:
    """The scene of a seed; ``number``: of how many objects, at least and at most."""
    rng = np.random.default_rng([seed, len(kb.types), len(kb.appearance_types), *(number if number != OBJECTS else ())])
    return scene_of(kb, placed(kb, rng, number), rng)


def scene_of(
    kb: KnowledgeBase, objects: Sequence[Placed], rng: np.random.Generator, detector: Detector = DETECTOR
) -> Scene:
    """What the detector reports of these objects, in an order that tells nothing."""
    own = [_reported(kb, objects, which, rng, detector) for which in range(len(objects))]
    whose = [(which, int(f)) for which, reported in enumerate(own) for f in reported.feature]
    every = [*own, _clutter(kb, round(len(whose) * NOISE / (1.0 - NOISE)), rng)]
    looks, uv, angle = (
        np.concatenate([getattr(reported, name) for reported in every]) for name in ("looks", "uv", "angle")
    )
    order = rng.permutation(len(looks))
    data = tuple(
        Appearance(
            f"d{n}",
            kb.appearance_types[looks[i]],
            (float(uv[i, 0]), float(uv[i, 1])),
            "simulated",
            angle=float(angle[i]),
        )
        for n, i in enumerate(order)
    )
    causes = {f"d{n}": whose[i] for n, i in enumerate(order) if i < len(whose)}
    return Scene(Gamma(CAMERA, data), truths_of(objects), causes)


def seen(kb: KnowledgeBase, objects: Sequence[Placed], which: int) -> Indices:
    """The features of one object that the camera sees: in their lobe, hidden neither by it nor by another."""
    one = objects[which]
    at = transform_points(one.pose, one.kind.lobes.at)
    there = visible(one.kind, one.pose, kb.f_ref)
    for other in objects:
        if other is not one:
            surface = surface_of(other.kind)
            there &= ~behind(at, surface.rays, other.pose, SLACK * surface.diameter)
    return np.flatnonzero(there)


def truths_of(objects: Sequence[Placed]) -> tuple[Truth, ...]:
    """What stands there, each with the share of it that shows."""
    shares = visible_shares(objects)
    return tuple(
        Truth(
            one.kind.name,
            one.pose,
            float(share),
            np.stack(picture(surface, one.pose)),
            surface.centre,
            one.kind.symmetries,
        )
        for one, share, surface in (
            (one, share, surface_of(one.kind)) for one, share in zip(objects, shares, strict=True)
        )
    )


def _reported(
    kb: KnowledgeBase, objects: Sequence[Placed], which: int, rng: np.random.Generator, detector: Detector
) -> _Reported:
    """Of the features of one object that the camera sees; noise may lead what is near the border out of the image."""
    one, number = objects[which], {name: i for i, name in enumerate(kb.appearance_types)}
    some = seen(kb, objects, which)
    some = some[rng.random(len(some)) < detector.hit]
    at = transform_points(one.pose, one.kind.lobes.at[some])
    x_axes = np.array([one.kind.features[f].rotation[:, 0] for f in some]).reshape(-1, 3) @ one.pose[:3, :3].T
    uv = CAMERA.project(at) + rng.normal(0.0, detector.sigma, (len(some), 2))
    angle = screen_angle(x_axes, at) + rng.normal(0.0, detector.turn, len(some))
    looks = np.array([number[one.kind.lobes.types[f]] for f in some], np.intp)
    inside = CAMERA.contains(uv)
    return _Reported(some[inside], looks[inside], uv[inside], angle[inside] % (2.0 * np.pi))


def _clutter(kb: KnowledgeBase, count: int, rng: np.random.Generator) -> _Reported:
    """Anywhere, at any angle, of looks as frequent as in the vocabulary."""
    looks = rng.choice(len(kb.appearance_types), count, p=frequencies(kb))
    uv = rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5], (count, 2))
    return _Reported(np.full(count, -1), looks, uv, rng.uniform(0.0, 2.0 * np.pi, count))
