"""Support in the program: who may hold whom (layer 2), an excuse for each that may float (layer 3), and that none floats without (evidence)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.base.bounds import bounded
from plogic.facts.gravity import GROUND
from plogic.scene.text.layout import number

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.gravity import Gravity
    from plogic.scene.text.layout import Writer


def holds(w: Writer) -> Iterator[str]:
    """``weighs(h1). open_foot(h1, 0.0, 0.02).``, then ``body_rests(h2, h1).``; nothing where nobody said that gravity holds."""
    gravity = w.scene.situation.gravity
    if gravity is None:
        return
    yield "% Gravity: whom it is said of; between which heights they begin, m, where the ground's is not told; who rests on whom."
    if gravity.silent:
        yield f"% It keeps silent: {gravity.silent}"
    for foot in gravity.feet:
        height = (
            f" open_foot({w.names.atom(foot.id)}, {number(foot.low)}, {number(foot.high)})."
            if gravity.ground is None
            else ""
        )
        yield w.fact("weighs", foot.id) + height
    yield from (
        f"body_rests({w.names.atom(x)}, {GROUND if y == GROUND else w.names.atom(y)})." for x, y in gravity.rests
    )


def excuses(w: Writer) -> Iterator[str]:
    """``0.1::excused(h2).`` for each that floats in some world."""
    gravity = w.scene.situation.gravity
    if gravity is None:
        return
    yield ""
    yield "% Something that the KB does not know may hold what seems to float, each by itself."
    yield "excused(_) :- fail."
    yield from (
        f"{number(bounded(gravity.unknown_support))}::excused({w.names.atom(name)})." for name in may_float(gravity)
    )


def evidence(w: Writer) -> Iterator[str]:
    """Nothing floats without an excuse."""
    gravity = w.scene.situation.gravity
    if gravity is not None:
        yield from (f"evidence(\\+ violated(floats({w.names.atom(name)})))." for name in may_float(gravity))


def may_float(gravity: Gravity) -> list[str]:
    """Those that float in some assignment of present/1."""
    return [
        foot.id
        for foot in gravity.feet
        if (gravity.lower(foot.id) if gravity.ground is None else GROUND not in gravity.holders(foot.id))
    ]
