"""How many objects are present, of any type or of one: the distribution, without grounding or listing worlds.

* ``count_asked(situation, "number_of(t1, N)")``: what of it is counted, and how an answer is written
* ``how_many(asked, scene, graph_asked)``: its answers

The program text says the same by a chain of clauses (``number_of_objects/1`` in ``plogic.facts.vocabulary``).
"""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from plogic.base.walk import by_key
from plogic.facts.situation import Situation
from plogic.inference.counting import counted
from plogic.inference.gates import Literal
from plogic.inference.graph import Beliefs, FactorGraph
from plogic.logic.safety.atoms import quoted
from plogic.logic.served.engine import Answer, in_order
from plogic.scene.factors.scene_graph import SceneGraph

_ANY = r"[A-Z_]\w*"
_GOAL = re.compile(rf"number_of(?:_objects\(|\(\s*([a-z]\w*|'[^'\\]+'|{_ANY})\s*,)\s*({_ANY}|\d{{1,6}})\s*\)\s*\.?")


class Counted(NamedTuple):
    """``kinds``: what an answer begins with, and the hypotheses that it counts; ``number``: the one that is asked."""

    kinds: tuple[tuple[str, tuple[str, ...]], ...]
    number: int | None


def count_asked(situation: Situation, goal: str) -> Counted | None:
    """What a goal counts: ``number_of_objects(N)``, ``number_of(t1, N)``, ``number_of(T, 2)``; None of any other."""
    found = _GOAL.fullmatch(goal.strip())
    if found is None or found[1] == found[2]:
        return None
    number = int(found[2]) if found[2].isdigit() else None
    if found[1] is None:
        return Counted((("number_of_objects(", tuple(h.id for h in situation.hypotheses)),), number)
    known = dict.fromkeys([*(h.type for h in situation.hypotheses), *situation.types])
    names = {quoted(kind): kind for kind in known}
    if re.fullmatch(_ANY, found[1]):
        chosen = names
    elif (kind := names.get(found[1], names.get(f"'{found[1]}'", names.get(found[1].strip("'"))))) is not None:
        chosen = {quoted(kind): kind}
    else:
        return None
    return Counted(
        tuple(
            (f"number_of({shown}, ", tuple(h.id for h in situation.hypotheses if h.type == kind))
            for shown, kind in chosen.items()
        ),
        number,
    )


def how_many(asked: Counted, scene: SceneGraph, solve: Callable[[FactorGraph], Beliefs]) -> list[Answer]:
    """Each number that is possible, or the one that is asked for, most probable first."""
    return in_order(_rows(asked, scene, solve))


def _rows(
    asked: Counted, scene: SceneGraph, solve: Callable[[FactorGraph], Beliefs]
) -> Iterator[tuple[str, float, float]]:
    single = asked.number is not None and len(asked.kinds) == 1
    for begin, ids in asked.kinds:
        states = by_key(scene.place[name] for name in ids)  # alternatives are states of one variable
        chances = counted(scene.graph, [Literal(v, frozenset(some)) for v, some in states.items()], solve)
        for number, (low, high) in enumerate(chances):
            if asked.number in (None, number) and (high > 0.0 or single):
                yield f"{begin}{number})", low, high
        if single and asked.number is not None and asked.number >= len(chances):
            yield f"{begin}{asked.number})", 0.0, 0.0
