"""Abduce the planes that things stand on, and tell each hypothesis what standing on one is worth (formalism §9.9).

Each proposal of each type, in each of its stable poses, is in favour of a plane. A plane is likely on which proposals
of several types stand that their pixels and places make likely. None of them need be accepted: the sum over types of
how likely it is that one of it is there, and stands or is free, tells a plane from others, and from none.

* ``Bodies``: the proposals, as arrays: their types, what speaks for each, and the ways in which each may stand
* ``Believed``: one plane, ``Believed(known, log_prior, factors)``; ``Supported``: all of an image
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from geometry.arrays import Floats, Ints, Mask
from geometry.bodies.resting import Plane, RestingFaces
from geometry.bodies.standing import (
    Known,
    Stands,
    alike,
    borne,
    fitted,
    joined,
    log_free,
    log_level,
    log_peaks,
    log_ratios,
    noise_of,
    noisy,
    top_of,
    ways,
)
from geometry.camera import Camera
from kb.clouds.cloud import KnowledgeBase
from plogic.facts.hypothesis import Hypothesis
from plogic.match.judged.evidence import pose_information
from plogic.match.judged.rivals import overlap
from plogic.match.judged.type_models import TypeModel

NONE = 0.2
"""P(nothing says where things stand), before a picture is seen: assumed."""
TILT, DEPTH, ASIDE = 0.12, 0.03, 0.01
"""Standard deviations of a pose by pixels: its tilt, rad, and shares of its distance along the sight and across;
assumed, a little more than what outlines leave free."""
STANDS = 0.5
"""Probability from which something is told to stand on a plane."""


class Chance(NamedTuple):
    """P(a proposal of what is not there stands ``on`` what others do, or ``level`` above a plane)."""

    on: float
    level: float


FREE, PUT = Chance(0.03, 0.05), Chance(0.4, 0.2)
"""Of a free search, and of what was looked for on a plane and released from there: many stay. Of 69 and 30 proposals of
the first kind that are wrong, in photos of ``lmo`` and ``ycb``, the likeliest shares are 0.00 and 0.00, level 0.02 and
0.03 (so few do not rule out 0.03 and 0.05); of 55 and 79 of the second 0.41 and 0.42, level 0.12 and 0.26, by ``python
benchmarks/planes.py KB DATASET`` while PUT was 0.3 and 0.1; of 81 of ``ycb`` since 0.38 and 0.28.
"""
STACKED = 0.2
"""P(what rests stands on another of Δh), where there is one that it may stand on: assumed."""
RAISED = 0.1
"""P(what rests stands on something that nobody knows, level above the plane): assumed."""
LEAST = 0.2
"""Probability from which what stands on a plane may carry others."""
STOREYS = 2
"""Of things that stand on one another, above what stands on a plane: what is higher is on something unknown."""
MOST = 4
"""Planes that are told of in one image."""
STARTS = 16
"""Ways of standing that planes are sought from, the likeliest."""
EXACT = 1.0
"""What a way of standing may be less likely on a plane than on its own, in logarithms, so that it leads there again."""
ROUNDS, STILL = 6, 0.002
"""Times that a plane is fitted at most; what it moves by less than is no move (rad, and a share of its height)."""


class Bodies(NamedTuple):
    """B hypotheses, at most one of each ``kind`` (B,), a number, is there; ``odds`` (B,): logarithms, by all else.

    ``names`` (B) of their types; ``stands``: the ways in which each may stand; ``put`` (B,): whether it was looked for
    on a plane, where it would be whether it is there or not.
    """

    names: tuple[str, ...]
    kind: Ints
    odds: Floats
    stands: Stands
    put: Mask

    @property
    def present(self) -> Floats:
        """(B,) P(it is there)."""
        weight = np.exp(np.clip(self.odds, -50.0, 50.0))
        return np.asarray(weight / (1.0 + self.sums(weight))[self.kind])

    def sums(self, value: Floats) -> Floats:
        """(K,) of each kind."""
        return np.asarray(np.bincount(self.kind, value, minlength=int(self.kind.max(initial=-1)) + 1), float)


class Believed(NamedTuple):
    """A plane, ln of its prior share, and by how much likelier each of B bodies' poses is where it holds.

    ``by_chance``: the same of bodies that are not there. ``by``: the types of those that are there and stand on it,
    more likely than not.
    """

    known: Known
    log_prior: float
    factors: Floats
    by_chance: Floats
    by: tuple[str, ...]


class Supported(NamedTuple):
    """The planes of an image, best first, and the ``probability`` (P + 2,) of each, of another one, and of none.

    ``worth`` (B,): what standing there, or not, adds to the log-odds of each body, given all others. Logarithms:
    ``prior`` (P + 2,), and ``told`` (P + 2, K), what each kind of bodies, of ``types`` (K), tells of each.
    """

    planes: tuple[Believed, ...]
    probability: Floats
    worth: Floats
    prior: Floats
    told: Floats
    types: tuple[str, ...]

    def without(self, types: Collection[str]) -> Floats:
        """(P + 2,) the probability of each by all that is not of these types."""
        others = [k for k, name in enumerate(self.types) if name not in types]
        logs = self.prior + self.told[:, others].sum(axis=1)
        weight = np.exp(logs - logs.max())
        return np.asarray(weight / weight.sum())


def nothing_known(_: Hypothesis) -> float:
    """The log-odds of what is as likely there as not, before its pixels."""
    return 0.0


class Setting(NamedTuple):
    """What poses are judged by: the types' models by name, the camera, and the knowledge base.

    ``before``: the log-odds that it is there, of a hypothesis whose pixels were looked at, before they were.
    """

    models: Mapping[str, TypeModel]
    camera: Camera
    kb: KnowledgeBase
    before: Callable[[Hypothesis], float] = nothing_known


def abduced(
    accepted: Sequence[Hypothesis], proposed: Sequence[Hypothesis], setting: Setting, rests: float
) -> tuple[Bodies, Supported]:
    """Those of Δi and proposals, and their planes."""
    bodies = with_noise(bodies_of(accepted, proposed, setting))
    return bodies, supported(bodies, rests)


def with_noise(bodies: Bodies) -> Bodies:
    """Bodies whose poses alone are in doubt, off what they stand on as well."""
    return bodies._replace(stands=noisy(bodies.stands))


def bodies_of(accepted: Sequence[Hypothesis], proposed: Sequence[Hypothesis], setting: Setting) -> Bodies:
    """Those of Δi, each there for itself or a rival in its place, and proposals, of a type one at most besides."""
    some = [*accepted, *proposed]
    kinds = [f"{k} " for k in range(len(accepted))]
    for posed in proposed:
        rivals = (k for k, other in zip(kinds, accepted, strict=False) if overlap(other, posed))
        kinds.append(next(rivals, posed.type))
    number = {name: k for k, name in enumerate(dict.fromkeys(kinds))}
    odds = [posed.surplus - posed.stance + setting.before(posed) for posed in some]
    stands = [_ways(k, posed, setting) for k, posed in enumerate(some)]
    return Bodies(
        tuple(posed.type for posed in some),
        np.array([number[name] for name in kinds], np.intp),
        np.array(odds, float),
        joined(stands),
        np.array([posed.released is not None for posed in some], bool),
    )


class Standing(Protocol):
    """What can stand: a ``TypeModel``, or a body without one."""

    @property
    def centre(self) -> Floats:
        """(3,) m, its middle, object frame."""
        ...

    @property
    def resting(self) -> RestingFaces:
        """The faces that it stands on."""
        ...


def _ways(number: int, posed: Hypothesis, setting: Setting) -> Stands:
    model, pose = setting.models[posed.type], posed.camera_from_object if posed.released is None else posed.released
    if posed.pixels is not None and posed.spread is None:
        return roughly(number, model, pose)
    told = np.asarray(np.linalg.inv(pose_information(posed, setting.camera, setting.kb)))
    tilt = float(np.sqrt(np.trace(told[:3, :3]) / 3.0))
    return ways(number, model.resting, pose, model.centre, tilt, told[3:, 3:])


def roughly(number: int, model: Standing, pose: Floats) -> Stands:
    """How a body may stand whose pose (4, 4) is known as well as pixels tell it."""
    here = pose[:3, :3] @ model.centre + pose[:3, 3]
    far = float(np.linalg.norm(here))
    sight = here / far
    spread = far**2 * (ASIDE**2 * np.eye(3) + (DEPTH**2 - ASIDE**2) * np.outer(sight, sight))
    return ways(number, model.resting, pose, model.centre, TILT, spread)


def supported(bodies: Bodies, rests: float) -> Supported:
    """The planes that the bodies speak for, where a thing ``rests`` with that chance, and what standing is worth."""
    from scipy.special import logsumexp

    number = len(bodies.kind)
    planes = _abduced(bodies, rests) if number and rests else []
    if not planes:
        nothing = np.array([1.0 - NONE, NONE])
        return Supported((), nothing, np.zeros(number), np.log(nothing), np.zeros((2, 0)), ())
    shares = np.array([plane.log_prior for plane in planes])
    elsewhere = np.log(max(1.0 - NONE - float(np.exp(shares).sum()), 1e-12))
    prior = np.array([*shares, elsewhere, np.log(NONE)])
    elsewhere_too = np.where(bodies.put, 1.0 - rests, 1.0 - rests + rests * RAISED)  # or level above that plane
    factors = np.stack([*(plane.factors for plane in planes), elsewhere_too, np.ones(number)])
    by_chance = np.stack([*(plane.by_chance for plane in planes), *np.ones((2, number))])
    there, less = bodies.present, np.where(bodies.put, by_chance, 1.0)  # what was put is there whether it holds or not
    of_kind = 1.0 - bodies.sums(there) + np.stack([bodies.sums(there * row) for row in factors / less])
    logs = prior + np.log(of_kind).sum(axis=1)
    probability = np.exp(logs - logsumexp(logs))
    without = logs[:, None] - np.log(of_kind)[:, bodies.kind]  # (P + 2, B) by all other types
    present, absent = (logsumexp(without + np.log(some), axis=0) for some in (factors / less, by_chance / less))
    worth = present - absent
    first = np.unique(bodies.kind, return_index=True)[1]
    types = tuple(bodies.names[body] for body in first)
    return Supported(tuple(planes), probability, worth, prior, np.log(of_kind), types)


def _abduced(bodies: Bodies, rests: float) -> list[Believed]:
    """The planes found from each likely way of standing, the likeliest first, no two alike."""
    stands, there = bodies.stands, bodies.present
    likely = there[stands.body] * stands.chance
    found: list[tuple[float, Believed]] = []
    exact, peaks = np.zeros(len(likely), bool), log_peaks(stands)
    likely[stands.noise > 0] = 0.0  # a way that is in it several times starts once
    for start in np.argsort(-likely, kind="stable")[:STARTS]:
        up = stands.up[start]
        known = None if exact[start] else _settled(bodies, Plane(up, -float(up @ stands.foot[start])), start, rests)
        if known is not None:
            found.append(_weighed(bodies, known, there, rests))
            exact |= log_ratios(stands, known.plane) > peaks - EXACT
    kept: list[Believed] = []
    for _, plane in sorted(found, key=lambda row: -row[0]):
        if not any(alike(plane.known.plane, other.known.plane) for other in kept):
            kept.append(plane)
    return kept


def _settled(bodies: Bodies, plane: Plane, start: int, rests: float) -> Known | None:
    """The plane from one way of standing on, fitted to all that stand on it; None where the camera comes below it."""
    there = bodies.present
    share = np.zeros(len(bodies.stands.body))
    share[start] = 1.0
    known = fitted(bodies.stands, share, plane)
    for _ in range(ROUNDS):
        before = known.plane
        if before.offset <= 0.0:
            return None
        share, level = _shares(bodies, before, there, rests)
        known = fitted(bodies.stands, share, before, level)
        if np.abs(known.plane.up - before.up).max() < STILL and abs(known.plane.offset / before.offset - 1.0) < STILL:
            break
    return known if known.plane.offset > 0.0 else None


class _Factors(NamedTuple):
    """(B,) how much likelier each pose is where a plane holds: if it is there, and if it is not.

    (N,) each way's part of the first: on the plane, and above it.
    """

    present: Floats
    by_chance: Floats
    on: Floats
    above: Floats

    def plus(self, told: Floats, bodies: Bodies, rests: float) -> "_Factors":
        """With (B,) how much likelier each is, if it is there, for what else it may stand on."""
        chance = np.where(bodies.put, PUT.on, FREE.on) * told / rests
        return self._replace(present=self.present + told, by_chance=self.by_chance + chance)


def _factors(bodies: Bodies, plane: Plane, rests: float) -> _Factors:
    both = np.exp(np.minimum([log_ratios(bodies.stands, plane), log_level(bodies.stands, plane)], 50.0))
    ways = bodies.stands.chance * both
    there = np.array([[1.0 - RAISED], [RAISED]]) * rests * ways
    told = [np.bincount(bodies.stands.body, row, minlength=len(bodies.kind)) for row in (there.sum(axis=0), *ways)]
    on, level = np.where(bodies.put, np.array(PUT)[:, None], np.array(FREE)[:, None])
    return _Factors(np.asarray(1.0 - rests + told[0]), 1.0 - on - level + on * told[1] + level * told[2], *there)


def standing_on(bodies: Bodies, plane: Plane, rests: float) -> Floats:
    """(B,) P(each stands on a plane, given that it is there and that the plane is)."""
    factors = _factors(bodies, plane, rests)
    return np.asarray(np.bincount(bodies.stands.body, factors.on, minlength=len(bodies.kind)) / factors.present)


def _shares(bodies: Bodies, plane: Plane, there: Floats, rests: float) -> tuple[Floats, Floats]:
    """(N,) P(each way of standing is how its body stands), where the plane holds: on it, and above it."""
    factors = _factors(bodies, plane, rests)
    less = np.where(bodies.put, factors.by_chance, 1.0)
    of_kind = 1.0 - bodies.sums(there) + bodies.sums(there * factors.present / less)
    of = bodies.stands.body
    on, above = (there / less)[of] * np.array([factors.on, factors.above]) / of_kind[bodies.kind[of]]
    return on, above


def _stacked(bodies: Bodies, known: Known, on: Floats, there: Floats, rests: float) -> Floats:
    """(B,) how much likelier each pose is, by this alone, on the tops of those that stand on a plane, or on such tops.

    ``on`` (N,): P(each way of standing on the plane is how its body stands).
    """
    stands, of, total = bodies.stands, bodies.stands.body, np.zeros(len(bodies.kind))
    above = known.plane.height(stands.foot)
    share, high = on, np.zeros(len(of))
    for _ in range(STOREYS):
        told = np.zeros(len(of))
        for lower in np.flatnonzero(share > LEAST):
            top = top_of(stands, int(lower), known, float(high[lower]))
            here = top.over(stands.foot) & (above > high[lower] + 0.5 * stands.tall[lower]) & (of != of[lower])
            if here.any() and top.plane.offset > 0.0:
                some = borne(Stands(*(part[here] for part in stands)), stands, int(lower))
                told[here] += share[lower] * some.chance * np.exp(np.minimum(log_ratios(some, top.plane), 50.0))
        told *= rests * STACKED
        mine = np.bincount(of, told, minlength=len(total))
        total += mine
        share, high = there[of] * told / (1.0 - rests + mine)[of], above
    return total


def _weighed(bodies: Bodies, known: Known, there: Floats, rests: float) -> tuple[float, Believed]:
    """How much all bodies speak for a plane; and what they do."""
    shares, _ = _shares(bodies, known.plane, there, rests)
    factors = _factors(bodies, known.plane, rests).plus(_stacked(bodies, known, shares, there, rests), bodies, rests)
    less = np.where(bodies.put, factors.by_chance, 1.0)
    volume = 1.5 * np.log(2.0 * np.pi) + 0.5 * float(np.linalg.slogdet(known.covariance)[1])
    log_prior = float(np.log(1.0 - NONE) + min(0.0, float(log_free(known.plane.offset)) + volume))
    of_kind = 1.0 - bodies.sums(there) + bodies.sums(there * factors.present / less)
    stands = np.bincount(bodies.stands.body, shares, minlength=len(there))
    by = tuple(name for name, share in zip(bodies.names, stands, strict=True) if share > STANDS)
    told = known._replace(noise=noise_of(bodies.stands, shares))
    return log_prior + float(np.log(of_kind).sum()), Believed(told, log_prior, factors.present, factors.by_chance, by)
