"""The next view: of candidate camera moves the one with the greatest expected reduction of entropy, in bits.

Worlds w_k with probabilities p_k; at a candidate, each world leads to expect features (D7), which fall into sites; Z,
which sites report, is independent given w. The gain is I(W; Z) = H(W) − E[H(W | Z)], or I(T; Z) for the truth T of a
goal, which in each world is what ``plogic query`` would say there. Sites with the same probabilities in every world are
counted, not told apart (the count is all that they say): where the outcomes are few the sum is exact, else it is taken
over samples, the same for all candidates as far as they go, until its standard error is below ``ERROR``.

* ``Outlook``: one candidate with its gain and why, ``Outlook(Candidate("ring 90°", pose), Gain(0.83, 0.0, 12),
  reasons)``
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.camera import Camera
from plogic.base.errors import ProgramError, SituationError
from plogic.facts.situation import Situation
from plogic.logic.safety.atoms import quoted
from plogic.logic.served.engine import Answer
from plogic.scene.asking.live import LiveScene
from plogic.scene.asking.query import answers
from plogic.sequence.next_view.expected import Prospect, Sightings, Sites, sightings, sites
from plogic.sequence.next_view.moves import Candidate

OUTCOMES = 200_000
"""Joint outcomes times worlds that are enumerated."""
ERROR = 0.004
"""Bits: the standard error at which sampling stops."""
BATCH, BATCHES = 2048, 40
"""Samples of a batch, shared out over the worlds, and the most batches."""
SAME = 12
"""Digits to which probabilities are the same."""


class Gain(NamedTuple):
    """``bits`` with the standard ``error`` of it, 0 where it is exact; ``sites``: how many differ between worlds."""

    bits: float
    error: float
    sites: int


class _Told(NamedTuple):
    """C classes of worlds alike, G groups of sites alike.

    P(class) (C,), P(answer | class) (C, A), sites (G,), report (C, G).
    """

    mass: Floats
    answers: Floats
    sites: Indices
    report: Floats


def entropy(p: Floats, axis: int = -1) -> Floats:
    """−Σ p log2 p along an axis, 0 log 0 being 0."""
    from scipy.special import xlogy

    return np.asarray(-xlogy(p, p).sum(axis=axis) / np.log(2.0) + 0.0)  # −0 is 0


def gain(probability: Floats, report: Floats, answers: Floats | None = None, seed: int = 0) -> Gain:
    """I(W; Z), or I(T; Z) where ``answers`` (W, A) are P(answer | w).

    Of worlds (W,) and independent sites that report with (W, S).
    """
    alike = np.round(report, SAME)
    differs = np.flatnonzero(np.ptp(alike, axis=0) > 0.0) if len(alike) else np.zeros(0, np.intp)
    if not len(differs):
        return Gain(0.0, 0.0, 0)
    told = _told(probability, alike[:, differs], answers)
    before = float(entropy(told.mass @ told.answers))
    outcomes = float(np.prod(told.sites + 1.0)) * len(told.mass)
    after, error = _enumerated(told) if outcomes <= OUTCOMES else _sampled(told, seed)
    return Gain(min(max(before - after, 0.0), before), error, len(differs))


def _told(probability: Floats, report: Floats, answers: Floats | None) -> _Told:
    columns, sites = np.unique(report, axis=1, return_counts=True)
    rows, which = np.unique(columns, axis=0, return_inverse=True)
    member = np.zeros((len(rows), len(probability)))
    member[np.asarray(which).reshape(-1), np.arange(len(probability))] = probability
    mass = member.sum(axis=1)
    kept = mass > 0.0
    given = np.eye(len(rows)) if answers is None else member @ answers / np.where(kept, mass, 1.0)[:, None]
    return _Told(mass[kept], given[kept], sites, rows[kept])


def _enumerated(told: _Told) -> tuple[float, float]:
    """E[H(answer | Z)] over every joint outcome."""
    from scipy.stats import binom

    joint = told.mass[:, None]
    for n, p in zip(told.sites, told.report.T, strict=True):
        pmf = binom.pmf(np.arange(n + 1)[None], n, p[:, None])
        joint = (joint[:, :, None] * pmf[:, None, :]).reshape(len(joint), -1)
    total = joint.sum(axis=0)
    joint, total = joint[:, total > 0.0], total[total > 0.0]
    return float(total @ entropy((joint / total).T @ told.answers)), 0.0


def _sampled(told: _Told, seed: int) -> tuple[float, float]:
    """E[H(answer | Z)] over samples from each class in turn, and its standard error."""
    rng = np.random.default_rng([seed, 8])
    each = max(BATCH // len(told.mass), 8)
    found = np.zeros((len(told.mass), 0))
    error = np.inf
    for _ in range(BATCHES):
        found = np.concatenate([found, np.stack([_left(told, c, each, rng) for c in range(len(told.mass))])], axis=1)
        error = float(np.sqrt((told.mass**2 * found.var(axis=1, ddof=1) / found.shape[1]).sum()))
        if error <= ERROR:
            break
    return float(told.mass @ found.mean(axis=1)), error


def _left(told: _Told, which: int, count: int, rng: np.random.Generator) -> Floats:
    """(M,) H(answer | z) for samples z of what is reported where one class is true."""
    from scipy.special import log_softmax, xlog1py, xlogy

    z = rng.binomial(told.sites, told.report[which], (count, len(told.sites)))
    p = told.report[None]
    logs = np.log(told.mass)[None] + (xlogy(z[:, None], p) + xlog1py((told.sites - z)[:, None], -p)).sum(axis=2)
    return entropy(np.exp(log_softmax(logs, axis=1)) @ told.answers)


def each_site(probability: Floats, report: Floats, answers: Floats | None = None) -> Floats:
    """(S,) what each site alone would tell, bits."""
    joint = probability[:, None] * (np.eye(len(probability)) if answers is None else answers)
    mass = joint.sum(axis=0)
    by_answer = (joint / np.where(mass > 0.0, mass, 1.0)).T @ report
    return np.maximum(_flip(probability @ report) - mass @ _flip(by_answer), 0.0)


def _flip(p: Floats) -> Floats:
    return entropy(np.stack([p, 1.0 - p], axis=-1))


SAME_ANSWER = 9
"""To which two worlds give a goal the same probability."""


def answers_in(situation: Situation, worlds: Sequence[Sequence[str]], goal: str) -> Floats:
    """(W, A) P(answer | w), each row summing to 1, of worlds that are told by who is present.

    Of a ground goal the answers are true and false. Of one with variables, which substitutions hold: worlds of which
    all have the same probabilities give the same answer. Raises ProgramError for what is no goal.
    """
    try:
        rows = _by_graph(situation, worlds, goal)
    except (ProgramError, SituationError):  # only the program text can say it, or what is wrong with it
        rows = [_rounded(answers(situation, goal, given=_given(situation, present))) for present in worlds]
    if all(len(row) == 1 for row in rows) and len({tuple(row) for row in rows}) == 1:
        true = np.array([next(iter(row.values())) for row in rows], dtype=float)
        return np.stack([true, 1.0 - true], axis=1)
    kinds = {key: i for i, key in enumerate(dict.fromkeys(tuple(sorted(row.items())) for row in rows))}
    return np.eye(len(kinds))[[kinds[tuple(sorted(row.items()))] for row in rows]]


def _by_graph(situation: Situation, worlds: Sequence[Sequence[str]], goal: str) -> list[dict[str, float]]:
    """The goal's answers in each world, from the factor graph.

    What the goal and each hypothesis' presence mean is worked out once.
    """
    scene, rows = LiveScene(situation), []
    for present in worlds:
        scene.given = tuple(_given(situation, present))
        rows.append(_rounded(scene.answers(goal)))
    return rows


def _given(situation: Situation, present: Sequence[str]) -> list[str]:
    """A world as evidence."""
    there = set(present)
    return [
        f"present({quoted(h.id)})" if h.id in there else f"\\+ present({quoted(h.id)})" for h in situation.hypotheses
    ]


def _rounded(found: Sequence[Answer]) -> dict[str, float]:
    return {a.goal: round(a.probability, SAME_ANSWER) for a in found}


LISTED = 3
"""Reasons of a candidate, those that tell most first."""
LEAST = 1e-3
"""Bits that a reason's best site alone must tell."""


class Reason(NamedTuple):
    """Sites alike: their number, the ``mass`` of worlds that expect them, the best one's ``bits``, the sentence."""

    sites: int
    mass: float
    bits: float
    text: str


def reasons(prospect: Prospect, seen: Sightings, found: Sites, answers: Floats | None) -> list[Reason]:
    """The sites that tell the worlds, or the answers (W, A), apart, those of one kind together."""
    bits = each_site(prospect.probability, found.report, answers)
    groups: dict[tuple[tuple[str, ...], tuple[str, ...], bytes], list[int]] = {}
    for site in np.flatnonzero(bits > LEAST).tolist():
        groups.setdefault(_kind(site, prospect, seen, found), []).append(site)
    order = sorted(groups.items(), key=lambda item: (-round(float(bits[item[1]].sum()), 9), str(item[0][:2])))
    return [_reason(some, float(bits[some].max()), prospect, seen, found) for _, some in order[:LISTED]]


def _members(site: int, found: Sites) -> list[int]:
    return np.flatnonzero(found.of == site).tolist()


def _kind(
    site: int, prospect: Prospect, seen: Sightings, found: Sites
) -> tuple[tuple[str, ...], tuple[str, ...], bytes]:
    """Of which bodies and kinds of features a site is, and in which worlds they are expected."""
    members = _members(site, found)
    whose = tuple(sorted({prospect.bodies[seen.body[n]].id for n in members}))
    kinds = tuple(sorted({prospect.bodies[seen.body[n]].cloud.kinds[seen.feature[n]] for n in members}))
    return whose, kinds, found.expected[:, members].any(axis=1).tobytes()


def _reason(some: list[int], bits: float, prospect: Prospect, seen: Sightings, found: Sites) -> Reason:
    members = _members(some[0], found)
    there = found.expected[:, members].any(axis=1)
    mass = float(prospect.probability[there].sum())
    rest = "" if there.all() else f"; {_rest(members, np.logical_not(there), prospect, seen)} in the rest"
    text = f"{_what(some, prospect, seen, found)}: seen in worlds of mass {mass:.2f}{rest}"
    return Reason(len(some), mass, bits, text)


def _what(some: list[int], prospect: Prospect, seen: Sightings, found: Sites) -> str:
    """'roof/apex of h2', or '5 patches of h1', of h1 or h2 where both have one there."""
    first = _members(some[0], found)[0]
    bodies, kinds, _ = _kind(some[0], prospect, seen, found)
    whose, feature = " or ".join(bodies), prospect.bodies[seen.body[first]].cloud.features[seen.feature[first]]
    if len(some) == 1:
        return f"{feature} of {whose}"
    return f"{len(some)} features ({' or '.join(kinds)}; {feature}, ...) of {whose}"


def _rest(members: list[int], rest: Mask, prospect: Prospect, seen: Sightings) -> str:
    """Why none of the features is expected in the worlds ``rest`` (W,): hidden by whom, or not there."""
    present = prospect.present[rest & (prospect.probability > 0.0)]
    said = [
        f"hidden by {prospect.bodies[other].id}"
        for n in members
        for other in np.flatnonzero(seen.hidden[n]).tolist()
        if (present[:, seen.body[n]] & present[:, other]).any()
    ]
    absent = [body for body in sorted({int(seen.body[n]) for n in members}) if not present[:, body].all()]
    said += [f"{prospect.bodies[body].id} is not there" for body in absent]
    return " or ".join(dict.fromkeys(said))


DIGITS = 9
"""Of the bits by which candidates are ordered: what agrees to so many is a tie, and goes by the order in which they
were made."""


class Outlook(NamedTuple):
    """One candidate: ``gain`` and the ``why`` of it."""

    candidate: Candidate
    gain: Gain
    why: list[Reason]


def looked_ahead(
    prospect: Prospect,
    camera: Camera,
    candidates: Sequence[Candidate],
    answers: Floats | None = None,
    seed: int = 0,
) -> list[Outlook]:
    """All candidates, that of the greatest gain first.

    ``answers`` (W, A): P(answer | w) of the goal that it is about, None for the worlds.
    """
    found = [outlook(prospect, camera, one, answers, seed) for one in candidates]
    return sorted(found, key=lambda look: -round(look.gain.bits, DIGITS))


def outlook(
    prospect: Prospect, camera: Camera, candidate: Candidate, answers: Floats | None = None, seed: int = 0
) -> Outlook:
    """One candidate; every one has the same random numbers."""
    seen = sightings(prospect, camera, candidate.reference_from_camera)
    found = sites(seen, prospect, camera)
    return Outlook(
        candidate, gain(prospect.probability, found.report, answers, seed), reasons(prospect, seen, found, answers)
    )
