"""The next view: of candidate camera moves the one with the greatest expected reduction of entropy, in bits.

Worlds w_k with probabilities p_k; at a candidate, each world leads to expect features (D7), which fall into sites; Z,
which sites report, is independent given w. The gain is I(W; Z), or I(T; Z) for the truth T of a goal.

* ``Outlook``: one candidate with its gain and why, ``Outlook(Candidate("ring 90°", pose), Gain(0.83, 0.0, 12),
  reasons)``
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from plogic.sequence.next_view.expected import sightings
from plogic.sequence.next_view.gain import Gain, gain
from plogic.sequence.next_view.sites import sites
from plogic.sequence.next_view.why import Reason, reasons

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from plogic.sequence.next_view.moves import Candidate
    from plogic.sequence.next_view.prospect import Prospect

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
    answers: NDArray[np.float64] | None = None,
    seed: int = 0,
) -> list[Outlook]:
    """All candidates, that of the greatest gain first; ``answers`` (W, A): P(answer | w) of the goal that it is about, None for the worlds."""
    found = [outlook(prospect, camera, one, answers, seed) for one in candidates]
    return sorted(found, key=lambda look: -round(look.gain.bits, DIGITS))


def outlook(
    prospect: Prospect, camera: Camera, candidate: Candidate, answers: NDArray[np.float64] | None = None, seed: int = 0
) -> Outlook:
    """One candidate; every one has the same random numbers."""
    seen = sightings(prospect, camera, candidate.reference_from_camera)
    found = sites(seen, prospect, camera)
    return Outlook(
        candidate, gain(prospect.probability, found.report, answers, seed), reasons(prospect, seen, found, answers)
    )
