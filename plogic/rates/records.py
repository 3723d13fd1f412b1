"""What one scene with ground truth tells of the rates: plain counts' material, free of geometry.

Vocabulary, each with an example value:

* ``Sighting("corner", near=True, chance=0.002)``: a feature that should be seen; whether an appearance that it may
  cause lies at its place, and how probable it is that clutter alone puts one there
* ``Slot("t1", present=True, sightings=(...))``: one place where an object of the type is, is not, or may be (None)
* ``Record((Slot(...), ...), {"l_junction": 7})``: one scene; its clutter is None where not every object is known
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Sighting:
    """One expected feature; ``near`` is what was observed, ``chance`` the probability of that by clutter alone."""

    feature_type: str
    near: bool
    chance: float


@dataclass(frozen=True)
class Slot:
    """One instance that is there, is not there, or (None) may be there; its sightings are those of its pose, none where it is not there."""

    object_type: str
    present: bool | None
    sightings: tuple[Sighting, ...] = ()


@dataclass(frozen=True)
class Record:
    """One scene; ``clutter`` counts per appearance type what no object causes."""

    slots: tuple[Slot, ...]
    clutter: dict[str, int] | None
