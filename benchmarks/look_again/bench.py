"""``plogic bench look-again``.

How many views until the true world is probable, for the next view by what it would tell, and for others.

Every policy goes to places of the same ring, sees the same there, and judges all views together. ``--quick``: few
scenes, which promise means alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from benchmarks.look_again.episode import SURE, at_random, fixed, greatest_gain, tour, views_needed, widest
from benchmarks.look_again.scenes import scene
from benchmarks.look_again.table import CAPTION, Counted, claims, rows
from benchmarks.look_again.types import look_alikes
from benchmarks.shared.claims import report

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.look_again.episode import Policy

SCENES, QUICK = 50, 6
STEP = 1_000_000
"""How far apart the scenes of two seeds of the benchmark are."""
OURS = "greatest expected gain"
POLICIES: dict[str, Policy] = {
    OURS: greatest_gain,
    "random": at_random,
    "fixed, 30° on": fixed(1),
    "fixed, 90° on": fixed(3),
    "fixed, 150° on": fixed(5),
    "widest baseline": widest,
}


def run(
    *, seed: int, quick: bool, as_json: bool, say: Callable[[str], None], scenes: int | None = None
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a scene on ``say``."""
    found = counted(seed, scenes or (QUICK if quick else SCENES), say)
    text, met = report(
        "look-again", rows(found, seed), claims(found, OURS, seed, QUICK if quick else None), as_json=as_json
    )
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def counted(seed: int, scenes: int, say: Callable[[str], None]) -> list[Counted]:
    """So many scenes whose first view leaves the true world less probable than ``SURE``, and views per policy."""
    from plogic.run.perceive import Perceiver

    kb = look_alikes(seed)
    perceiver, found, tried = Perceiver(kb), list[Counted](), 0
    while len(found) < scenes:
        one = scene(kb, STEP * seed + tried)
        tried += 1
        begun = tour(one, perceiver)
        first = None if begun is None else begun.state([0]).true
        if begun is None or first is None or first >= SURE:
            continue
        needed = {name: views_needed(begun, policy) for name, policy in POLICIES.items()}
        found.append(Counted(one.sort, first, needed, tried))
        say(
            f"scene {len(found)} ({one.sort}, the {tried}. tried), {first:.2f} at first: "
            + ", ".join(f"{n} {v}" for n, v in needed.items())
        )
    return found
