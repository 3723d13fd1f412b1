"""The distribution over ROC-20 of a hypothesis without a pose and those around it (formalism §9.5)."""

from collections import Counter

import numpy as np

from geometry.arrays import Floats
from geometry.visibility.occlusion import PosedSurface, drawn, occlusion
from geometry.visibility.roc import Roc
from plogic.sequence.next_view.expected import Cloud
from plogic.sequence.unposed.annealed import annealed, log_sum, systematic
from plogic.sequence.unposed.standing import Target

TOLD = 200
"""Poses whose relations are told, exactly by outlines and depth: shares are to half a percent."""

States = dict[tuple[Roc, ...], float]
"""The relations to each of the others, in their order, with their probability."""


def states(target: Target, seed: int = 0) -> States:
    """The joint distribution of the relations to the target's standers, in their order."""
    rng = np.random.default_rng(seed)
    near, apart, share = target.prior.strata(rng)
    found = annealed(target, near, rng)
    far = log_sum(target.log_likelihood(apart)) - np.log(len(apart.middle)) if len(apart.middle) else -np.inf
    with np.errstate(divide="ignore"):
        masses = np.array([np.log(share) + found.log_mean, np.log1p(-share) + far])
    beside, away = np.exp(masses - masses.max()) / np.exp(masses - masses.max()).sum()
    result: Counter[tuple[Roc, ...]] = Counter()
    result[("non_occludes_dc",) * len(target.standers)] += float(away)
    count = len(found.at.middle)
    chosen = found.at.take(systematic(np.ones(count), min(TOLD, count))) if count else found.at
    for relations in _related(target, target.poses(chosen)):
        result[relations] += float(beside) / len(chosen.middle)
    return dict(result)


def _related(target: Target, poses: Floats) -> list[tuple[Roc, ...]]:
    """The relations at each pose (N, 4, 4)."""
    camera = target.prior.camera
    others = [_surface(one.body.cloud, one.body.reference_from_object) for one in target.standers]
    images = [drawn(other, camera) for other in others]
    found: list[tuple[Roc, ...]] = []
    for pose in poses:
        one = _surface(target.prior.cloud, pose)
        image = drawn(one, camera)
        found.append(
            tuple(
                occlusion(one, other, camera, images=(image, there))
                for other, there in zip(others, images, strict=True)
            )
        )
    return found


def _surface(cloud: Cloud, pose: Floats) -> PosedSurface:
    if cloud.rays is None:
        raise ValueError(f"{cloud.name} has no surface")
    return PosedSurface(cloud.rays.vertices, cloud.rays.triangles, cloud.rays, pose)
