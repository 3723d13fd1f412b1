"""A relation of an interpretation's hypotheses as a user wants to read it: who must be present, and what geometry says.

Geometry is decided before any world is: in a world a relation holds where the hypotheses that it needs are present, in
one or several *ways*, ``frozenset({("h1", True), ("h2", True)})``. Its probability is composed of theirs, each beside
those before it.
"""

import math
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from plogic.base.errors import OutsideError
from plogic.facts.situation import Situation
from plogic.facts.vocabulary import VOCABULARY, Entry
from plogic.logic.safety.atoms import quoted
from plogic.logic.safety.author import load_problog

if TYPE_CHECKING:
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.factors.goal_meaning import Key, Meaning

Way = frozenset[tuple[str, bool]]
"""Whom a relation needs: (id, present or absent)."""
MOST_WAYS = 4
"""Ways that are told one by one; of more, the explanations are."""
ENTRIES = {entry.signature: entry for entry in VOCABULARY}


def related(situation: Situation, goal: str, given: Sequence[str] = ()) -> tuple[float, tuple[str, ...]] | None:
    """P(relation | evidence), and the lines on it; None of what is no relation of two hypotheses or more.

    Raises as ``plogic.scene.asking.live.LiveScene`` does.
    """
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.factors.goal_meaning import meaning

    read = _read(goal, situation)
    if read is None:
        return None
    entry, arguments = read
    scene = LiveScene(situation)
    try:
        meant = meaning(situation, [goal])
        ways = _ways(meant, meant.answers[0][0][1])
        for observed in given:
            scene.observe(observed)
        (answer, *_) = scene.answers(goal)
    except OutsideError:
        return None
    if ways is None:
        return None
    names = {h.id: f"{h.id}, a {h.type}," for h in situation.hypotheses}
    whole = list(dict.fromkeys(argument.split("/")[0] for argument in arguments if argument.split("/")[0] in names))
    lines = [f"it says: {_meant(entry, arguments)}", *_geometry(situation, whole, holds=bool(ways))]
    if ways:
        chances = [list(_way(scene, way, whole, names, many=len(ways) > 1)) for way in ways]
        lines += [line for way in chances for line in way]
    else:
        lines.append("so it holds in no world, whoever is present")
    return answer.probability, tuple(lines)


def open_relation(situation: Situation, goal: str) -> bool:
    """Whether a goal is of the vocabulary, with variables, of two arguments or more that may be hypotheses."""
    term = _term(goal)
    if term is None or term.is_ground() or term.signature not in ENTRIES:
        return False
    from problog.logic import Var

    ids = {h.id for h in situation.hypotheses}
    names = [str(argument).split("/")[0] for argument in term.args]
    return sum(isinstance(argument, Var) or name in ids for argument, name in zip(term.args, names, strict=True)) > 1


def _ways(meant: "Meaning", key: "Key") -> list[Way] | None:
    """The ways in which a key of a meaning holds, the shortest first; None where it speaks of more than presence."""
    made: list[list[Way] | None] = []

    def of(key: "Key") -> list[Way] | None:
        if not key:
            return [] if key is None else [frozenset()]
        if key > 0:
            return made[key - 1]
        found = made[-key - 1]  # a negation: of one condition alone
        if found is None or len(found) != 1 or len(found[0]) != 1:
            return None
        return [frozenset((name, not there) for name, there in found[0])]

    for kind, arguments in meant.nodes:
        if kind == "present":
            made.append([frozenset({(str(arguments[0][0]), True)})])
        elif kind in ("and", "or"):
            made.append(_joined(kind, [of(part) for part in arguments]))
        else:
            made.append(None)
    return of(key)


def _joined(kind: str, parts: Sequence[list[Way] | None]) -> list[Way] | None:
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    found: list[Way] = [frozenset()] if kind == "and" else []
    for part in known:
        found = [a | b for a in found for b in part] if kind == "and" else found + part
        found = [way for way in found if not any((name, not there) in way for name, there in way)]
        found = [
            way for i, way in enumerate(found) if not any(o < way or (o == way and j < i) for j, o in enumerate(found))
        ]
        if len(found) > MOST_WAYS:
            return None
    return sorted(found, key=lambda way: (len(way), sorted(way)))


def _geometry(situation: Situation, whole: Sequence[str], *, holds: bool) -> Iterator[str]:
    """What is computed of the bodies, whoever is present."""
    if holds:
        yield "geometry says so of them, as they are posed"
    else:
        yield "geometry does not say so of them, as they are posed"
    pairs = [(x, y) for i, x in enumerate(whole) for y in whole[i + 1 :]]
    for fact in situation.relations:
        if (fact.x, fact.y) in pairs or (fact.y, fact.x) in pairs:
            exact = f", {fact.roc} of ROC-20" if fact.roc else ""
            yield f"  outlines and depth: {fact.relation}({fact.x}, {fact.y}){exact}"
    at = {body.id: body for body in situation.space.bodies}
    for name in whole:
        if name in at:
            x, y, z = at[name].middle
            yield f"  {name}: middle at ({x:.2f}, {y:.2f}, {z:.2f}) m, nearest place {at[name].nearest:.2f} m away"
    for one, other, gap in situation.space.gaps:
        if {one, other} <= set(whole):
            yield f"  gap between {one} and {other}: {gap:.2f} m"
    for one, other in pairs:
        if not {(one, other), (other, one)}.isdisjoint(situation.overlaps):
            yield f"  {one} and {other} share volume, so that no world holds both"


def _way(scene: "LiveScene", way: Way, whole: Sequence[str], names: dict[str, str], *, many: bool) -> Iterator[str]:
    """One way: each condition beside those before it, their product, and where it fails."""
    order = sorted(way, key=lambda pair: (whole.index(pair[0]) if pair[0] in whole else len(whole), pair[0]))
    given = " given the evidence" if scene.given else ""
    yield f"{'it holds, for one,' if many else 'it holds just'} where{given}"
    observed, chances, failing = 0, list[float](), list[str]()
    for name, there in order:
        low, high = scene.marginals()[name]
        chance = (low + high) / 2 if there else 1.0 - (low + high) / 2
        before = " and ".join(f"{one} is {_there(is_there)}" for one, is_there in order[:observed])
        beside, though = (f" where {before}", f" though {before}") if before else ("", "")
        yield f"  {names[name]} is {_there(there)}{beside}: {chance:.4g}"
        lost = math.prod(chances) * (1.0 - chance)
        failing += [f"{name} is {_there(not there)}{though} ({lost:.4g})"] if lost else []
        chances.append(chance)
        if chance == 0.0:
            break
        scene.observe(f"present({quoted(name)})" if there else f"\\+ present({quoted(name)})")
        observed += 1
    for _ in range(observed):
        scene.unobserve(scene.given[-1])
    if len(chances) > 1:
        yield f"  together {' x '.join(f'{chance:.4g}' for chance in chances)} = {math.prod(chances):.4g}"
    if failing and not many:
        yield f"it fails where {', or '.join(failing)}"
    some = "; ".join(f"plogic explain ... 'present({name})'" for name, there in order if there)
    if some and not many:
        yield f"why they are present: {some}"


def _there(present: bool) -> str:  # noqa: FBT001 - the word for it
    return "present" if present else "absent"


def _read(goal: str, situation: Situation) -> tuple[Entry, list[str]] | None:
    """The entry of the vocabulary and the arguments of a ground relation of two hypotheses or more; else None."""
    term = _term(goal)
    if term is None or not term.is_ground():
        return None
    arguments = [str(argument) for argument in term.args]
    ids = {h.id for h in situation.hypotheses}
    entry = ENTRIES.get(term.signature)
    if entry is None or len({argument.split("/")[0] for argument in arguments} & ids) < 2:
        return None
    return entry, arguments


def _term(goal: str) -> Any:  # noqa: ANN401 - a term of ProbLog's
    """The one atom that a goal is; None of anything else."""
    load_problog()
    from problog.logic import And, Constant, Not, Or, Term, Var

    from plogic.logic.safety.check import glanced

    source = glanced(goal.strip().rstrip(". ") + " .", "goal")
    if source is None or len(source.statements) != 1 or isinstance(source.statements[0], (And, Or, Not, Var, Constant)):
        return None
    return source.statements[0] if type(source.statements[0]) is Term else None


def _meant(entry: Entry, arguments: Sequence[str]) -> str:
    """The meaning of a relation with its arguments in the place of the variables of its usage."""
    variables = re.findall(r"\b[A-Z]\w*\b", entry.usage)
    if len(variables) != len(arguments) or not all(re.search(rf"\b{v}\b", entry.meaning) for v in variables):
        return entry.meaning
    values = dict(zip(variables, arguments, strict=True))
    return re.sub(rf"\b({'|'.join(variables)})\b", lambda found: values[found[0]], entry.meaning)
