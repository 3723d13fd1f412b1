"""Which types stand in a simulated scene, and how large that makes it.

* ``Standing``: one type as something that can be put down, ``Standing("bolt", mesh, largest=0.05, broadest=0.02,
  ranges=(0.02, 1.0))``
* ``drawn(standings, number, seed, say)``: what a seed puts there
* ``framed(standings, distance, size_px, say)``: the scene's unit, and how far the camera is
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.errors import InputError
from sensing.simulated.framing import DISTANCE, Framing, framing_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from sensing.simulated.body import TexturedMesh

APART = 3.0
"""Types more than so many times apart in size are not put into one scene unless they are named."""
NEAREST, FARTHEST = 0.2, 90.0
"""Units of a scene that a camera may be from its middle: beyond, nothing is drawn."""
THIN = 0.05
"""Of the largest extent of a type without a mesh: the least thickness of the box that stands for it."""


@dataclass(frozen=True, eq=False)
class Standing:
    """One type that can be put down: its mesh and two lengths of it, m, corner to corner of its box and footprint.

    ``ranges``: the nearest and the farthest from which the detectors see a feature of it, m at the KB's ``f_ref``.
    """

    label: str
    mesh: TexturedMesh
    largest: float
    broadest: float
    ranges: tuple[float, float]


def standing(kind: ObjectType, mesh: TexturedMesh) -> Standing:
    """The type with what stands for it."""
    size, lobes = np.ptp(mesh.vertices, axis=0), kind.lobes
    ranges = (float(lobes.r_min.min()), float(lobes.r_max.max())) if len(lobes.r_min) else (0.0, np.inf)
    return Standing(kind.name, mesh, float(np.linalg.norm(size)), float(np.linalg.norm(size[:2])), ranges)


def box_of(kind: ObjectType) -> TexturedMesh:
    """What is put down for a type without a mesh: the box round its features. Raises InputError where it has none."""
    from sensing.simulated.scene import box

    at = np.array([feature.at for feature in kind.seen_features]).reshape(-1, 3)
    if not len(at):
        raise InputError(f"{kind.name}: has neither a mesh nor features, so that nothing of it can be seen")
    size = np.maximum(np.ptp(at, axis=0), max(THIN * float(np.ptp(at, axis=0).max()), 1e-3))
    middle = (at.min(axis=0) + at.max(axis=0)) / 2.0
    upright = box(size, np.random.default_rng(0), painted=False)
    return replace(upright, vertices=upright.vertices + middle - (0.0, 0.0, size[2] / 2.0))


def checked_names(kb: KnowledgeBase, names: Sequence[str]) -> list[ObjectType]:
    """The types of these names, or all. Raises InputError for a name that is none, and for a KB without types."""
    known = [kind.name for kind in kb.types]
    for name in names:
        if name not in known:
            raise InputError(f"--type {name}: is no type of the KB ({', '.join(known) or 'it has none'})")
    return [kb.type(name) for name in names] if names else list(kb.types)


def drawn(
    standings: Sequence[Standing], number: int, seed: int, *, named: bool, say: Callable[[str], None]
) -> list[Standing]:
    """As many as asked for, every type once before any twice.

    Types too far apart in size from those that were drawn before them are left out, and said, unless ``named``.
    """
    rng = np.random.default_rng([seed, 1])
    orders = [rng.permutation(len(standings)) for _ in range(number)] if len(standings) else []
    alike = [] if not orders else _alike(standings, orders[0].tolist(), named=named)
    if orders and len(alike) < len(standings):
        _tell_left_out([standings[i] for i in alike], [s for i, s in enumerate(standings) if i not in alike], say)
    return [standings[i] for order in orders for i in order if i in alike][:number]


def _alike(standings: Sequence[Standing], order: Sequence[int], *, named: bool) -> set[int]:
    """Those of which no two are too far apart, taken in this order."""
    taken: list[int] = []
    for i in order:
        sizes = [standings[k].largest for k in (*taken, i)]
        if named or max(sizes) <= APART * min(sizes):
            taken.append(i)
    return set(taken)


def _tell_left_out(there: Sequence[Standing], left: Sequence[Standing], say: Callable[[str], None]) -> None:
    def listed(some: Sequence[Standing]) -> str:
        return ", ".join(f"{s.label} ({told(s.largest)})" for s in some)

    say(
        f"left out, more than {APART:g} times larger or smaller than {listed(there)}: {listed(left)}; "
        "name them with --type to see them together, or alone"
    )


def told(metres: float) -> str:
    """A length in the unit that a person would say it in, ``5.1 cm``."""
    return f"{100.0 * metres:.3g} cm" if metres < 1.0 else f"{metres:.3g} m"


def framed(
    standings: Sequence[Standing],
    *,
    focal: float,
    f_ref: float,
    distance: float | None,
    size_px: int | None,
    say: Callable[[str], None],
) -> Framing:
    """The framing of a scene with these; ``focal``: the camera's, pixels.

    ``distance`` (m), or ``size_px``, how long the largest is in the picture, say where the camera stands; else it
    stands as near and as far as shows each well, and no farther than their features are seen. Of types that are too far
    apart in size for that, the largest counts.

    Raises InputError for a distance at which nothing can be drawn.
    """
    largest = max(s.largest for s in standings)
    framing = framing_of(largest, max(s.broadest for s in standings))
    if largest > APART * min(s.largest for s in standings):
        framing = replace(framing, cover=None)
    if distance is None and size_px is None:
        framing = _within_ranges(framing, standings, focal / f_ref)
        _tell_out_of_range(standings, framing.distance[0] * framing.unit, focal / f_ref, say)
        return framing
    away = distance if distance is not None else focal * largest / float(size_px or 1)
    low, high = NEAREST * framing.unit, FARTHEST * framing.unit
    if not low <= away <= high:
        option = f"--distance {distance:g}" if distance is not None else f"--size-px {size_px}: {told(away)} away"
        raise InputError(f"{option}: should be {told(low)} to {told(high)} for things of {told(largest)}")
    _tell_out_of_range(standings, away, focal / f_ref, say)
    return replace(framing, distance=(away / framing.unit,) * 2, reach=None, cover=None)


def _within_ranges(framing: Framing, standings: Sequence[Standing], longer: float) -> Framing:
    """No farther than the features of each type are seen, as long as some of the usual distances are left."""
    far = min(s.ranges[1] for s in standings) * longer / framing.unit
    if framing.unit == 1.0 or not 1.2 * DISTANCE[0] <= far < DISTANCE[1]:
        return framing
    return replace(framing, distance=(DISTANCE[0], far), reach=(DISTANCE[0], far))


def _tell_out_of_range(standings: Sequence[Standing], away: float, longer: float, say: Callable[[str], None]) -> None:
    for s in {s.label: s for s in standings}.values():
        low, high = (longer * r for r in s.ranges)
        if not low <= away <= high:
            say(
                f"{s.label}: no feature of it is seen from {told(away)}; its lobes' ranges are {told(low)} to {told(high)}"
            )
