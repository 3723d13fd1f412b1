"""The next view: of candidate camera moves the one with the greatest expected reduction of entropy, in bits.

Worlds w_k with probabilities p_k; at a candidate, each world leads to expect features (D7), which fall into sites; Z,
which sites report, is independent given w. The gain is I(W; Z), or I(T; Z) for the truth T of a goal.

* ``Outlook``: one candidate with its gain and why, ``Outlook(Candidate("ring 90°", pose), Gain(0.83, 0.0, 12),
  reasons)``
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.sequence.next_view.expected import Sightings, Sites, sightings, sites
from plogic.sequence.next_view.gain import Gain, each_site, gain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.arrays import Floats, Mask
    from geometry.camera import Camera
    from plogic.sequence.next_view.moves import Candidate
    from plogic.sequence.next_view.prospect import Prospect


LISTED = 3
"""Reasons of a candidate, those that tell most first."""
LEAST = 1e-3
"""Bits that a reason's best site alone must tell."""


class Reason(NamedTuple):
    """Sites alike: how many, in worlds of which ``mass`` they are expected, the ``bits`` that the best of them alone would tell, and the sentence."""

    sites: int
    mass: float
    bits: float
    text: str


def reasons(prospect: Prospect, seen: Sightings, found: Sites, answers: Floats | None) -> list[Reason]:
    """The sites that tell the worlds, or the answers (W, A), apart, those of one kind together."""
    bits = each_site(prospect.probability, found.report, answers)
    groups: dict[tuple[object, ...], list[int]] = {}
    for site in np.flatnonzero(bits > LEAST).tolist():
        groups.setdefault(_kind(site, prospect, seen, found), []).append(site)
    order = sorted(groups.items(), key=lambda item: (-round(float(bits[item[1]].sum()), 9), str(item[0][:2])))
    return [_reason(some, float(bits[some].max()), prospect, seen, found) for _, some in order[:LISTED]]


def _members(site: int, found: Sites) -> list[int]:
    return np.flatnonzero(found.of == site).tolist()


def _kind(site: int, prospect: Prospect, seen: Sightings, found: Sites) -> tuple[object, ...]:
    """Of which bodies and kinds of features a site is, and in which worlds they are expected."""
    members = _members(site, found)
    whose = tuple(sorted({prospect.bodies[seen.body[n]].id for n in members}))
    kinds = tuple(sorted({prospect.bodies[seen.body[n]].cloud.kinds[seen.feature[n]] for n in members}))
    return whose, kinds, found.expected[:, members].any(axis=1).tobytes()


def _reason(some: list[int], bits: float, prospect: Prospect, seen: Sightings, found: Sites) -> Reason:
    members = _members(some[0], found)
    there = found.expected[:, members].any(axis=1)
    mass = float(prospect.probability[there].sum())
    what = _what(some, prospect, seen, found)
    rest = "" if there.all() else f"; {_rest(members, np.logical_not(there), prospect, seen)} in the rest"
    return Reason(len(some), mass, bits, f"{what}: seen in worlds of mass {mass:.2f}{rest}")


def _what(some: list[int], prospect: Prospect, seen: Sightings, found: Sites) -> str:
    """'roof/apex of h2', or '5 patches of h1', of h1 or h2 where both have one there."""
    members = _members(some[0], found)
    whose = " or ".join(sorted({prospect.bodies[seen.body[n]].id for n in members}))
    first = prospect.bodies[seen.body[members[0]]].cloud
    feature = seen.feature[members[0]]
    if len(some) == 1:
        return f"{first.features[feature]} of {whose}"
    kinds = sorted({prospect.bodies[seen.body[n]].cloud.kinds[seen.feature[n]] for n in members})
    return f"{len(some)} features ({' or '.join(kinds)}; {first.features[feature]}, ...) of {whose}"


def _rest(members: list[int], rest: Mask, prospect: Prospect, seen: Sightings) -> str:
    """Why none of the features is expected in the worlds ``rest`` (W,): hidden by whom, or not there."""
    rest = rest & (prospect.probability > 0.0)
    said: dict[str, None] = {}
    for n in members:
        body = seen.body[n]
        for other in np.flatnonzero(seen.hidden[n]).tolist():
            if (prospect.present[rest, body] & prospect.present[rest, other]).any():
                said[f"hidden by {prospect.bodies[other].id}"] = None
    for body in sorted({int(seen.body[n]) for n in members}):
        if (~prospect.present[rest, body]).any():
            said[f"{prospect.bodies[body].id} is not there"] = None
    return " or ".join(said)


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
