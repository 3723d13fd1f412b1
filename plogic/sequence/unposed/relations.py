"""The distribution over ROC-20 of a hypothesis without a pose and those around it (formalism §9.5)."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Mask
from geometry.visibility.composition import possible_triples
from geometry.visibility.occlusion import PosedSurface, drawn, occlusion
from geometry.visibility.outline import Area
from geometry.visibility.roc import Roc
from plogic.sequence.next_view.expected import Cloud
from plogic.sequence.unposed.annealed import annealed, log_sum, systematic
from plogic.sequence.unposed.drawn import At
from plogic.sequence.unposed.standing import Target

TOLD = 200
"""Poses whose relations are told, exactly by outlines and depth: shares are to half a percent."""

LEAST = 1e-6
"""Shares that are not told: a program's labels must be well above what ProbLog reads as 0."""

State = tuple[Roc, ...]
APART: Roc = "non_occludes_dc"


class Posterior(NamedTuple):
    """``poses`` (N, 4, 4) with their ``share`` (N,), which sums to 1; ``near`` (N,) others on the screen."""

    poses: Floats
    share: Floats
    near: Mask


def posterior(target: Target, seed: int = 0) -> Posterior:
    """Where the hypothesis stands, by all that is reported: at most ``TOLD`` poses near, as many apart."""
    rng = np.random.default_rng(seed)
    near, apart, beside = target.prior.strata(rng)
    found, far = annealed(target, near, rng), np.full(1, -np.inf)
    if len(apart.middle):
        far = target.log_likelihood(apart) - np.log(len(apart.middle))
    with np.errstate(divide="ignore"):
        masses = np.array([np.log(beside) + found.log_mean, np.log1p(-beside) + log_sum(far)])
    if not np.isfinite(masses).any():  # nothing goes with the reports: they say nothing
        masses = np.zeros(2)
    shares = np.exp(masses - masses.max()) / np.exp(masses - masses.max()).sum()
    some = [_chosen(found.at, np.zeros(len(found.at.middle))), _chosen(apart, far[: len(apart.middle)])]
    counts = [len(at.middle) for at in some]
    share = np.concatenate([np.full(n, p / max(n, 1)) for n, p in zip(counts, shares, strict=True)])
    poses = np.concatenate([target.poses(at) for at in some])
    return Posterior(poses, share / share.sum(), np.arange(len(share)) < counts[0])


def _chosen(at: At, logs: Floats) -> At:
    """At most ``TOLD`` of the poses, by their weights."""
    if not np.isfinite(logs).any():
        return at.take(np.zeros(0, np.intp))
    return at.take(systematic(np.exp(logs - logs.max()), min(TOLD, len(logs))))


def states(target: Target, found: Posterior) -> dict[State, float]:
    """The joint distribution of the relations to the target's standers, in their order."""
    result: defaultdict[State, float] = defaultdict(float)
    bodies = [placed(one.body.cloud, one.body.reference_from_object) for one in target.standers]
    images = [drawn(body, target.prior.camera) for body in bodies]
    for pose, share, near in zip(found.poses, found.share.tolist(), found.near.tolist(), strict=True):
        result[related(target, pose, bodies, images) if near else (APART,) * len(bodies)] += share
    known = {
        (i, j): occlusion(bodies[i], bodies[j], target.prior.camera, images=(images[i], images[j]))
        for i, j in combinations(range(len(bodies)), 2)
    }
    return lawful(result, known)


def related(target: Target, pose: Floats, bodies: Sequence[PosedSurface], images: Sequence[Area]) -> State:
    """The relations of the hypothesis at a pose (4, 4) to each of the bodies."""
    one, camera = placed(target.prior.cloud, pose), target.prior.camera
    image = drawn(one, camera)
    return tuple(occlusion(one, b, camera, images=(image, there)) for b, there in zip(bodies, images, strict=True))


def lawful(found: Mapping[State, float], known: Mapping[tuple[int, int], Roc]) -> dict[State, float]:
    """The states of x to some others that go with how these stand to each other, by the composition table (§3.7).

    ``known``: the relation of the i-th to the j-th of them. What relations exclude, tolerances of the outlines let in.
    The shares are scaled to sum to 1; where nothing is left, all are kept.
    """
    triples = possible_triples()
    kept = {
        s: p for s, p in found.items() if p > LEAST and all((s[i], r, s[j]) in triples for (i, j), r in known.items())
    }
    kept = kept or dict(found)
    total = sum(kept.values())
    return {state: share / total for state, share in sorted(kept.items(), key=lambda item: (-item[1], item[0]))}


def placed(cloud: Cloud, pose: Floats) -> PosedSurface:
    """The surface of a type at a pose (4, 4). Raises ValueError where it has none."""
    if cloud.rays is None:
        raise ValueError(f"{cloud.name} has no surface")
    return PosedSurface(cloud.rays.vertices, cloud.rays.triangles, cloud.rays, pose)
