"""What things stand on in the program (§9.9): planes and ways to stand (layer 2), and their choices (layer 3).

``P1/T::support(s1); P2/T::support(none) :- ...`` is the one choice of an image; what is left is a plane that is none of
those named. Each hypothesis that has a footing has a choice of ways to stand on a plane, and one for all others.
``0.03::by_chance(h1).``: it has a footing where it is absent, too.
"""

from collections.abc import Iterator

from plogic.base.bounds import bounded
from plogic.facts.stances import FREE, NONE, OTHER, Support
from plogic.scene.readings.standing import Standing
from plogic.scene.text.layout import Writer, coordinate, disjunction, number


def support_facts(w: Writer) -> Iterator[str]:
    """``plane(s1, 0.0, -0.8, -0.6, -0.9). plane_prior(s1, 0.7).``, then ``way_to_stand(h1, s1, 2, 0.3, 4.1).``."""
    support = w.scene.situation.support
    if support is None:
        return
    yield "% Support: the chance that a thing rests on something known; planes, their normal upwards and offset, m, camera frame (§9.9)."
    yield f"rests_chance({number(bounded(support.rests))}). plane_prior({NONE}, {number(bounded(support.none))})."
    for plane in support.planes:
        place = ", ".join(coordinate(x) for x in (*plane.normal, plane.offset))
        name = w.names.atom(plane.name)
        yield f"plane({name}, {place}). plane_prior({name}, {number(bounded(plane.prior))})."
    yield "% Ways to stand: who, on what, with which stable pose; the chance of that, and what the pose says of it, log-odds."
    yield "way_to_stand(_, _, _, _, _) :- fail."
    for s in support.stances:
        way = f"{_way(w, s.hypothesis, s.on, str(s.face))}, {number(bounded(s.chance))}, {number(s.log_ratio)}"
        yield f"way_to_stand({way})."
    yield "% Who may rest on something unknown, level above a plane, and what the pose says of that where it is free, log-odds."
    yield "level(_, _, _) :- fail."
    for above, surface, ratio in support.level:
        yield f"level({w.atoms(above, surface)}, {number(ratio)})."


def _by_chance(w: Writer, support: Support) -> Iterator[str]:
    yield "% The pose of what is absent may stand by chance, as if it were there."
    yield "by_chance(_) :- fail."
    yield from (f"{number(bounded(e))}::{w.fact('by_chance', name)}" for name, e in support.by_chance)


def support_choices(w: Writer) -> Iterator[str]:
    """One alternative of planes; one of footings a hypothesis and plane that it may stand on, one for all others."""
    situation = w.scene.situation
    if situation.support is None:
        return
    standing = Standing(situation, situation.support)
    yield ""
    yield "% Things stand on one of these planes, or nothing says where; what is left is another plane."
    yield from _planes(w, situation.support)
    yield from _by_chance(w, situation.support)
    yield "% Who has a footing stands on that plane, or on another hypothesis, in a stable pose, or is free."
    for name in standing.posed:
        for state in (*standing.planes(name), OTHER):
            yield _footings(w, standing, name, state)


def open_choices(w: Writer) -> Iterator[str]:
    """``0.5::support(s1). 0.5::footing(h1, s1, 2).``: what can be chosen, with labels of no meaning."""
    situation = w.scene.situation
    if situation.support is None:
        return
    yield from (f"0.5::{w.fact('support', plane.name)}" for plane in situation.support.planes)
    yield f"0.5::support({NONE})."
    for name in Standing(situation, situation.support).posed:
        yield f"0.5::footing({_way(w, name, FREE, NONE)})."
    yield from (f"0.5::footing({_way(w, s.hypothesis, s.on, str(s.face))})." for s in situation.support.stances)


def _planes(w: Writer, support: Support) -> Iterator[str]:
    names = [*(w.names.atom(plane.name) for plane in support.planes), NONE]
    shares = [f"P{i}" for i, _ in enumerate(names)]
    known = [f"plane_prior({name}, {p})" for name, p in zip(names, shares, strict=True)]
    heads = [(f"{p}/T", f"support({name})") for name, p in zip(names, shares, strict=True)]
    yield disjunction(heads, ", ".join([*known, f"T is max(1, {' + '.join(shares)})"]))


def _footings(w: Writer, standing: Standing, name: str, state: str) -> str:
    """``C1/T::footing(h1, s1, 2); F/T::footing(h1, free, none) :- has_footing(h1), support(s1), ...``."""
    ways = [_way(w, name, s.on, str(s.face)) for s in standing.stances(name, state)]
    chances = [f"C{i}" for i, _ in enumerate(ways, 1)]
    all_of_them = " + ".join(chances) or "0"
    free = f"1 - ({all_of_them})" if w.scene.situation.reading == "score" else "1 - Q"
    body = [
        f"has_footing({w.atoms(name)})",
        f"other_plane({w.atoms(name)})" if state == OTHER else f"support({w.atoms(state)})",
    ]
    body += [f"way_to_stand({way}, {c}, _)" for way, c in zip(ways, chances, strict=True)]
    body += ["rests_chance(Q)"] if w.scene.situation.reading == "posterior" else []
    body += [f"F is max(0, {free})", f"T is max(1, F + {all_of_them})"]
    heads = [(f"{c}/T", f"footing({way})") for way, c in zip(ways, chances, strict=True)]
    return disjunction([*heads, ("F/T", f"footing({_way(w, name, FREE, NONE)})")], ", ".join(body))


def _way(w: Writer, name: str, on: str, face: str) -> str:
    """``h1, s1, 2``."""
    return f"{w.atoms(name)}, {on if on == FREE else w.atoms(on)}, {face}"
