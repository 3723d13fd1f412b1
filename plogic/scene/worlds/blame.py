"""Which observations and constraints of the author's leave no world: as few of them as exclude all together (§9.7)."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

from plogic.base.errors import BeliefError, InconsistentError, OutsideError
from plogic.facts.situation import Situation, names_of
from plogic.inference.marginals import beliefs
from plogic.logic.safety.author import FILE, load_problog, observes
from plogic.logic.served.engine import Limits, Process, Text, run, through
from plogic.scene.factors.scene_graph import scene_graph
from plogic.scene.text.program_text import added_to, program_of
from plogic.scene.text.rules import defined

if TYPE_CHECKING:
    from plogic.logic.safety.added import Observation
    from plogic.logic.safety.check import Source


class BlamedError(InconsistentError):
    """The author's observations leave no world; it is said which."""


@contextmanager
def blaming(situation: Situation) -> Iterator[None]:
    """Within it, say which observations of the author's leave no world, where that is their doing."""
    try:
        yield
    except BlamedError:
        raise
    except InconsistentError as error:
        reason = blamed(situation)
        if reason is None:
            raise
        raise BlamedError(reason) from error


def blamed(situation: Situation) -> str | None:
    """One line with their places; None where there is no world without them either."""
    found = _fewest(situation)
    return None if found is None else _told(found) + unsmoothed(situation, _possible)


SMOOTHED = 0.01
"""A smoothing with which no choice is certain, to find out whether that is what leaves no world."""


def unsmoothed(situation: Situation, possible: "Callable[[Situation], bool]") -> str:
    """What to say where there is no world for the score reading's certain choices alone; '' where that is not why."""
    if situation.reading != "score" or situation.smoothing:
        return ""
    try:
        if not possible(replace(situation, smoothing=SMOOTHED)):
            return ""
    except BeliefError:  # more choices are open than can be decided
        return ""
    return f"; choices of the score reading can be certain: plogic perceive --smoothing {SMOOTHED} leaves them open"


GOAL = "goal_of_the_question"


def excluding(situation: Situation, goal: str) -> tuple[str, ...]:
    """The observations of the author's, with their places, because of which a goal holds in no world."""
    asked = Text(f"{GOAL} :- {goal.strip().removesuffix('.')}\n.\nevidence({GOAL}).", GOAL, situation.own)
    return tuple(each.told for each in _fewest(replace(situation, own=asked)) or () if each.file != GOAL)


def _fewest(situation: Situation) -> "list[Observation] | None":
    added = added_to(situation)
    pieces = [] if added is None else list(added.pieces())

    def possible(some: "Sequence[Observation]") -> bool:
        own: Text | None = None
        for piece in reversed(pieces):
            own = Text(only(_source(piece), some), piece.file, own)
        return _possible(replace(situation, rules="", own=own))

    load_problog()
    from plogic.logic.safety.added import observations, only

    return _spared([each for piece in pieces for each in observations(_source(piece))], possible)


def blamed_without_scene(rules: str) -> str | None:
    """The same of an author's rules as far as they say nothing of any scene."""
    if not observes(rules):
        return None
    load_problog()
    from plogic.logic.safety.added import LAW, observations, only

    nothing = f"constraint(_) :- fail.{LAW}"
    source = _source(Text(rules, FILE))

    def possible(some: "Sequence[Observation]") -> bool:
        try:
            run([Text(nothing, own=Text(only(source, some, free_of=defined()), FILE))], ["true"])
        except InconsistentError:
            return False
        return True

    found = _spared(observations(source), possible)
    return None if found is None else _told(found)


def _source(piece: Text) -> "Source":
    from plogic.logic.safety.check import parse

    return parse(piece.text, piece.file)


def _told(found: "list[Observation]") -> str:
    return f"no world satisfies {' and '.join(each.told for each in found)}"


def _spared(
    found: "list[Observation]", possible: "Callable[[Sequence[Observation]], bool]"
) -> "list[Observation] | None":
    """Observations of which none can be spared for there to be no world; None where that is not their doing."""
    if not found:
        return None
    with closing(Process(Limits())) as process, through(process.ask):
        if possible(found) or not possible([]):
            return None
        for each in list(found):
            less = [other for other in found if other is not each]
            found = found if possible(less) else less
    return found


def _possible(situation: Situation) -> bool:
    try:
        try:
            return beliefs(scene_graph(situation).graph).log_z[1] > -inf
        except OutsideError:
            run([program_of(situation)], ["true"], names=names_of(situation))
            return True
    except InconsistentError:
        return False
