"""The evidence for one hypothesis against clutter (§8, posterior, one claimant): the logarithm of a likelihood ratio.

Of all poses a few fit any matches, so that a fit to them is no evidence by itself. The evidence of presence is that of
all poses, not of the best (the marginal likelihood, by Laplace's method): the likelihood at the best pose, times the
share of all poses that fit about as well.

``as_fitted`` is what the program is told of a pose that was fitted to its matches: they say less than of a pose that
was known before. The posterior of an object's presence sums over all poses that it may have; a hypothesis stands for
those about its own. So its prior is the type's times that share, often below what ProbLog can read as a label. It is
told with the matches instead, of which each gives up in proportion. The log odds of a lone hypothesis are then its
type's prior, plus its evidence, plus the share.

* ``known(posed, which, data, kb)``: the places that matches fix, how sharply, and the lines that their angles lead
  along
* ``log_share(at, precision, centre, camera, across)``: the logarithm of the share, at most 0; ``share_of(information,
  ...)``, of what is known
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.camera import Camera
from geometry.poses.reprojection import WEIGHT, across, ends, information, reach
from geometry.visibility.outline import outline
from kb.clouds.cloud import KnowledgeBase, ObjectType, Rates
from plogic.base.bounds import LEAST
from plogic.base.clock import unhurried
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import distinct
from plogic.match.judged.type_models import Found, TypeModel
from plogic.measures.explanatory import explanatory_value

DEPTHS = 4.2
"""Logarithm of the ratio of the farthest to the nearest distance that is believed."""
LOOSE = (0.3, 0.35)
"""Even one appearance fixes the distance (its size) and the rotation (its angle and its lobe) so well: logarithm,
radians."""


def log_share(at: Floats, precision: Floats, centre: Floats, camera: Camera, across: Floats | None = None) -> float:
    """The share of all poses, even in image, log depth and rotation, that fit matched places as well as theirs.

    ``at`` (N, 3) metres, camera frame; ``precision`` (N,) 1/pixel²; ``centre`` (3,) of the object, before the camera;
    ``across`` (N, 2) unit vectors across the edges that sides lie anywhere along, NaN of others.
    """
    return float(share_of(information(at, centre, precision, camera, across), centre[2], camera))


def share_of(information: Floats, depth: Floats | float, camera: Camera) -> Floats:
    """The logarithm of that share, (...,): of what is known (..., 6, 6) of a step (w rad, v m) in the camera's axes.

    The step is about a middle at ``depth`` (...,) metres.
    """
    far = np.asarray(depth, float)[..., None]
    scale = np.concatenate(
        [np.ones((*far.shape[:-1], 3)), np.repeat(far, 3, axis=-1)], axis=-1
    )  # moves are counted in depths
    loose = np.array([*[LOOSE[1]] * 3, camera.width / camera.f, camera.height / camera.f, LOOSE[0]])
    sharp = information * scale[..., :, None] * scale[..., None, :] + np.diag(loose**-2.0)
    volume = 3.0 * np.log(2.0 * np.pi) - 0.5 * np.linalg.slogdet(sharp)[1]
    return np.asarray(volume - np.log(camera.width * camera.height / camera.f**2 * DEPTHS * 8.0 * np.pi**2))


class Known(NamedTuple):
    """``at`` (N, 3) m, camera frame; ``precision`` (N,) 1/pixel²; ``middle`` (3,) m of the object, camera frame.

    ``across`` (N, 2) unit vectors across the lines that a place may lie anywhere along, NaN of others; None where there
    are no lines.
    """

    at: Floats
    precision: Floats
    middle: Floats
    across: Floats | None


def known(posed: Hypothesis, which: Mask, data: Data, kb: KnowledgeBase) -> Known:
    """Of features ``which`` (F,), all matched: their places, as much as they are counted.

    And their angles, where these count.
    """
    at, sigma = posed.at[which], sigmas(posed, kb)[which]
    precision, lines = posed.counted[which] / sigma**2, None if posed.across is None else posed.across[which]
    if posed.axes is not None and kb.rates.sigma_angle is not None:
        angle = data.angle[posed.matches[which]]
        told = np.isfinite(angle)
        beyond = ends(at, posed.axes[which], at[:, 2], reach(sigma, kb.rates.sigma_angle) / data.camera.f)[told]
        lines = np.concatenate([np.full((len(at), 2), np.nan), across(angle[told])])
        at, precision = np.concatenate([at, beyond]), np.concatenate([precision, precision[told] * WEIGHT])
    return Known(at, precision, posed.middle, lines)


def sigmas(posed: Hypothesis, kb: KnowledgeBase) -> Floats:
    """Location noise (F,) of each feature, pixels."""
    return sigmas_of(posed.object_type, kb.rates) if posed.sigma is None else posed.sigma


def sigmas_of(kind: ObjectType, rates: Rates) -> Floats:
    """Location noise (F,) of the features of a type by hand, pixels, as the KB states it."""
    return np.array([rates.sigma_of(feature.type) for feature in kind.seen_features])


def pose_information(posed: Hypothesis, camera: Camera, kb: KnowledgeBase) -> Floats:
    """(6, 6) of turning about the middle, rad, and moving, m.

    Of the pixels, where a pose was moved to fit them; else of the matches, and of what is known of any pose
    (``known``).
    """
    if posed.spread is not None:
        return np.asarray(np.linalg.inv(posed.spread))
    used = np.flatnonzero(posed.candidate & posed.detected)
    precision = posed.counted[used] / sigmas(posed, kb)[used] ** 2
    across = None if posed.across is None else posed.across[used]
    depth = max(float(posed.middle[2]), 1e-6)
    wide, high = camera.width / camera.f * depth, camera.height / camera.f * depth
    loose = np.array([*[LOOSE[1]] * 3, wide, high, LOOSE[0] * depth])
    return information(posed.at[used], posed.middle, precision, camera, across) + np.diag(loose**-2.0)


def density(residual: Floats, sigma: Floats | float) -> Floats:
    """N(u; û, σ²I) per pixel² at distances ``residual`` in pixels; 0 where NaN."""
    return np.nan_to_num(np.exp(-0.5 * (residual / sigma) ** 2) / (2.0 * np.pi * sigma**2), nan=0.0)


def clutter_density(kb: KnowledgeBase, data: Data, which: Indices | None = None) -> Floats:
    """F (N,) per pixel² of some data, or of all.

    The expected number of clutter appearances of its type over the image's area.
    """
    area = float(data.camera.width * data.camera.height)
    types = data.types if which is None else [data.types[i] for i in which]
    return np.array([kb.rates.clutter.get(name, 1.0) / area for name in types])


def match_density(posed: Hypothesis, kb: KnowledgeBase) -> Floats:
    """N (F,) per pixel² of each feature's match, 0 where it has none.

    Of a learned type against clutter that looks as right, not any.
    """
    near = density(posed.residual, sigmas(posed, kb))
    return near if posed.likeness is None else near * posed.likeness


def hit_rates(posed: Hypothesis, kb: KnowledgeBase, hidden: Mask | None = None) -> Floats:
    """h_F (F,) of each feature.

    Of a learned type the measured rates, times the share of them that holds in this image (``clarity``). Of one by hand
    0 for the part of a compound that another part stands for and that was not found: a compound is missed once.
    """
    if posed.hit is not None:
        return np.clip(posed.hit * clarities(posed, hidden), LEAST_HIT, MOST_HIT)
    own = [kb.rates.hit.get(feature.type, 0.8) for feature in posed.object_type.seen_features]
    return np.where(posed.stands | posed.detected, own, 0.0)


CLEAR = 8.0
"""The prior of clarity is ∝ clarity⁸: an instance of which little shows where much should is rarely one. It counts in
what is accepted; the program has the scaled hit rates, and no prior of them."""
LEAST_CLEAR, LEAST_HIT, MOST_HIT = 0.04, 0.005, 0.98
"""Least share of the measured hit rates that an image can keep; bounds of what remains."""


def clarity(posed: Hypothesis, hidden: Mask | None = None, of: Mask | None = None) -> float:
    """Which share of the measured hit rates, of features ``of`` (F,) or of all, holds of this instance in this image.

    Light, focus, noise and a changed print cost detections.
    The most likely one: expected features that were detected, over the sum of their rates, in [``LEAST_CLEAR``, 1].
    """
    if posed.hit is None:
        return 1.0
    expected, shares = posed.expected(hidden) & (True if of is None else of), posed.counted
    hoped = float((shares * posed.hit)[expected].sum())
    return float(np.clip(shares[expected & posed.detected].sum() / hoped, LEAST_CLEAR, 1.0)) if hoped > 0.0 else 1.0


def kinds(posed: Hypothesis) -> list[Mask]:
    """Features (F,) that are seen clearly or not apart from the others.

    What is printed, and the sides of edges, which blur hurts less.
    """
    sided = np.zeros(len(posed.uv), bool) if posed.sided is None else posed.sided
    return [~sided, sided]


def clarities(posed: Hypothesis, hidden: Mask | None = None) -> Floats:
    """(F,) the clarity of each feature's kind."""
    return np.asarray(np.sum([kind * clarity(posed, hidden, kind) for kind in kinds(posed)], axis=0))


def as_counted(posed: Hypothesis, data: Data, kb: KnowledgeBase, hidden: Mask | None = None) -> tuple[Floats, Floats]:
    """Hit rates (F,) and densities (F,) of features that each say as much as they are ``counted``.

    What the program is told.

    With a share w of an observation, 1 − h becomes (1 − h)^w, and what a match says, (h·N + f − h·f) / f, that to the
    power of w.
    """
    hit, near = hit_rates(posed, kb, hidden), match_density(posed, kb)
    if posed.hit is None:
        return hit, near
    shares, found = posed.counted, posed.detected
    less = 1.0 - (1.0 - hit) ** shares
    clutter = clutter_density(kb, data, posed.matches[found])
    says = ((hit[found] * near[found] + (1.0 - hit[found]) * clutter) / clutter) ** shares[found]
    near[found] = np.maximum(says - 1.0 + less[found], 0.0) * clutter / less[found]
    return less, near


FIXED_BY = 3
"""Matches that any pose has for nothing: a pose can be laid through any three appearances."""


@dataclass(frozen=True)
class Evidence:
    """``ratio``: the log-likelihood ratio of presence against clutter at this pose.

    ``surplus``: what is left of it besides what any pose has.

    Of a type written by hand that is what is left without the ``FIXED_BY`` best matches; of a learned one, and where
    angles count, for matches say more than their places then, the ratio at all poses together (``freedom``).
    """

    ratio: float
    surplus: float


def evidence(posed: Hypothesis, data: Data, kb: KnowledgeBase, hidden: Mask | None = None) -> Evidence:
    """Σ over E∧D of ln((h·N + f − h·f) / f), in densities, plus Σ over E∧¬D of ln(1 − h) (§8), as ``counted``.

    ``hidden`` (F,) are the features that accepted opaque objects hide: not expected.
    """
    expected, shares = posed.expected(hidden), posed.counted
    hit = hit_rates(posed, kb, hidden)
    found = expected & posed.detected
    clutter = clutter_density(kb, data, posed.matches[found])
    gain = shares[found] * np.log(
        (hit[found] * match_density(posed, kb)[found] + (1.0 - hit[found]) * clutter) / clutter
    )
    ratio = float(gain.sum() + (shares * np.log(1.0 - hit))[expected & ~posed.detected].sum())
    if posed.hit is None and posed.axes is None:
        ratio += posed.stance
        return Evidence(ratio, ratio - float(np.sort(gain)[-FIXED_BY:].sum()))
    if posed.hit is not None:
        ratio += CLEAR * float(np.sum([np.log(clarity(posed, hidden, kind)) for kind in kinds(posed)]))
    owed = _owed(posed, found, data, kb)
    told = _by_pixels(posed, ratio + owed) + posed.stance
    return Evidence(ratio + told, ratio + owed + told)


def as_fitted(posed: Hypothesis, data: Data, kb: KnowledgeBase, hidden: Mask | None = None) -> tuple[Floats, Floats]:
    """Hit rates (F,) and densities (F,) per pixel².

    Of expected matches such that Π (h·N + f − h·f) / f is that at the best pose times the share.

    Each match gives up in proportion to how much better it is than a miss, ln(1 + h·N / (f − h·f)); where that is less
    in all than the pose owes, the matches count as misses. What a photo's pixels tell is no part of it, for the program
    has a factor of its own for that (formalism §9.10); but where they were asked, what is missed costs no more than
    what is found brings (``SUREST_MISSED``). ``hidden`` (F,) are the features that accepted opaque
    objects hide: not expected.
    """
    hit, near = as_counted(posed, data, kb, hidden)
    found = posed.expected(hidden) & posed.detected
    if found.any():
        h = np.clip(hit[found], LEAST, 1.0 - LEAST)
        missed = (1.0 - h) * clutter_density(kb, data, posed.matches[found])
        better = np.log1p(h * near[found] / missed)
        more = _owed(posed, found, data, kb)
        if posed.pixels is not None:
            more += _waived(evidence(posed.told(pixels=None, stance=0.0), data, kb, hidden).surplus)
        kept = max(LEAST, 1.0 + more / max(float(better.sum()), LEAST))
        near[found] = np.expm1(kept * better) * missed / h
    return hit, near


SUREST_MISSED = 0.0
"""Least evidence of Γ where pixels were looked at."""


def _by_pixels(posed: Hypothesis, surplus: float) -> float:
    """What pixels add to a ``surplus`` of evidence."""
    return 0.0 if posed.pixels is None else posed.pixels + _waived(surplus)


def _waived(surplus: float) -> float:
    """What of a ``surplus`` of evidence is not counted where pixels were looked at: they tell what else is missed.

    Features that are expected and not found cost no more than those that are found bring: print that is there and was
    not detected is seen in the pixels, and print that is not there as well.
    """
    return max(0.0, SUREST_MISSED - surplus)


def _owed(posed: Hypothesis, found: Mask, data: Data, kb: KnowledgeBase) -> float:
    """The logarithm of the share of all poses that fit the matches as well as this one."""
    at, precision, middle, across = known(posed, found, data, kb)
    return log_share(at, precision, middle, data.camera, across)


def nothing_hidden(posed: Hypothesis) -> Mask:
    """(F,) none of the features: nothing is accepted that may hide any."""
    return np.zeros(len(posed.uv), bool)


def verified(
    model: TypeModel,
    poses: Iterable[Floats],
    data: Data,
    kb: KnowledgeBase,
    hidden_of: Callable[[Hypothesis], Mask] = nothing_hidden,
    check: Callable[[], None] = unhurried,
    rounds: int = 1,
) -> Found:
    """Poses (4, 4) matched and settled: the distinct ones with their log-likelihood ratios against clutter, best first.

    ``hidden_of`` tells (F,) which features of a hypothesis accepted objects hide; ``check`` is called before each pose,
    and may raise to end it.
    """
    found = []
    for pose in poses:
        check()
        posed = model.settle(pose, data, kb, rounds=0)
        hidden = hidden_of(posed)
        posed = model.settle(pose if hidden.any() else posed, data, kb, hidden=hidden, rounds=rounds)
        if (posed.expected(hidden) & posed.detected).sum() >= FEWEST:
            found.append((evidence(posed, data, kb, hidden).ratio, posed))
    return distinct(found, model.object_type)


def judged(
    posed: Hypothesis, data: Data, kb: KnowledgeBase, dv: Mapping[str, float], hidden: Mask | None = None
) -> Hypothesis:
    """The hypothesis with its evidence, and its ev alone and beside the accepted opaque objects before it.

    They hide the features ``hidden`` (F,).
    """
    found = evidence(posed, data, kb, hidden)
    ev = explanatory_value(posed.support(), dv)
    again = ev if hidden is None else explanatory_value(posed.support(hidden), dv)
    return posed.told(worth=found.ratio, surplus=found.surplus, ev=ev, ev_reconsidered=again, hidden=hidden)


def outline_rings(posed: Hypothesis, camera: Camera) -> list[list[list[float]]]:
    """Exterior rings of the projected outline, pixels to two decimals; empty for a type without a surface."""
    surface = posed.object_type.surface
    if surface is None:
        return []
    shape = outline(surface.vertices, surface.triangles, posed.camera_from_object, camera)
    return [
        np.round(np.array(p.exterior.coords), 2).tolist() for p in getattr(shape, "geoms", [shape]) if not p.is_empty
    ]
