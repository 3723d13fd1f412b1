"""Why, and why not: minimal sets of choices that entail a goal, as trees down to the data (§8, *explanation*).

Vocabulary:

* ``Reason``, a node of a tree, ``Reason("in_view(h1, 'roof/apex')", "rule", (...))``
* ``Explanation``, ``Explanation("present(h1)", 0.31, 0.33, ("pick(h1, 'roof/apex')",), tree)``
* ``Miss``, one way in which the goal could have been, with what lacked
* ``Account``, all that there is to say of one goal
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from plogic.base.errors import LimitError, OutsideError
from plogic.facts.situation import Situation
from plogic.logic.safety.atoms import quoted, tokens
from plogic.logic.served.engine import Limits, ask, request_of
from plogic.scene.asking.query import Subject, answers, subject_text
from plogic.scene.text.values_asked import told_in_words

if TYPE_CHECKING:
    from plogic.scene.asking.live import LiveScene

COUNTING = frozenset({"number_of_objects", "number_of"})
"""Predicates that speak of every hypothesis without naming one."""


@dataclass(frozen=True)
class Reason:
    """One node; the children of a rule are its conditions.

    In a proof ``kind`` is rule, fact, choice, check (a built-in test), absent (a negation that holds), computed (by the
    engine: findall/3 and the like), cases (no single proof is certain, but in every world one of these ways is open) or
    case (one of them: what it needs). In a miss it is holds, fails, possible (``probability`` is P(condition |
    evidence)) or open (it cannot be asked, since what should bind its variables failed).
    """

    goal: str
    kind: str
    children: "tuple[Reason, ...]" = ()
    probability: float | None = None


@dataclass(frozen=True)
class Explanation:
    """A minimal set of ``choices`` that entails ``goal``.

    Without any one of them there are worlds in which it is false.

    ``probability`` is the product of its choices (ICL); ``given_evidence`` is P(choices | evidence), exact.
    """

    goal: str
    probability: float
    given_evidence: float
    choices: tuple[str, ...]
    tree: Reason


@dataclass(frozen=True)
class Covered:
    """``listed``: P(at least one of the listed explanations | evidence), an interval.

    ``unlisted``: at most so much is left for all others.

    ``stopped``: the search ended before it had all that were asked for.
    """

    listed: tuple[float, float] = (0.0, 0.0)
    unlisted: float = 0.0
    stopped: bool = False


@dataclass(frozen=True)
class Miss:
    """An instance of a rule that could have given ``goal``.

    Its conditions, how many of them cannot hold, and P(all of them | evidence).
    """

    goal: str
    rule: str
    failed: int
    probability: float
    conditions: tuple[Reason, ...]


@dataclass(frozen=True)
class Account:
    """P(goal | evidence) and what there is to say of it. ``answers``: instances of the goal that are possible.

    ``why``: explanations; ``why_not``: explanations of the negated goal, both ranked by P(choices | evidence), and none
    that contradicts the evidence; ``misses``: of an improbable goal (below ½), what lacked least first; ``failure``: of
    a goal that no choices entail, the condition that fails; ``notes``: what names would be right, and what was left
    out; ``summary``: of the presence of an interpretation's hypothesis, what its features say; of a relation of
    several, what geometry says and who must be present.
    """

    goal: str
    probability: float
    why: tuple[Explanation, ...]
    why_not: tuple[Explanation, ...]
    failure: Reason | None
    misses: tuple[Miss, ...] = ()
    covered: Covered = Covered()
    covered_not: Covered = Covered()
    answers: int = 1
    notes: tuple[str, ...] = ()
    summary: tuple[str, ...] = ()


def explain(
    subject: Subject, goal: str, *, given: Sequence[str] = (), most: int = 5, limits: Limits | None = None
) -> Account:
    """The ``most`` probable explanations of a goal and of its negation, given the evidence.

    Raises as ``plogic.scene.asking.query.answers`` does.

    Of a goal with variables the probability is that of its most probable answer. Choices of probability 1 are certain,
    and not listed. Where the presence of a scene's hypothesis cannot be explained choice by choice within the limits,
    its summary is, and a note says so.
    """
    summary = present(subject, goal, given=given)
    limits = limits or Limits()
    try:
        account = _explained(_about(subject, [goal, *given]), goal, given, most, limits)
    except LimitError as error:
        if summary is None:
            raise
        return replace(summary, notes=(f"no explanations choice by choice: {error}",))
    if isinstance(subject, Situation) and account.probability == 0.0 and not given:
        from plogic.scene.worlds.blame import excluding

        if why := excluding(subject, goal):
            account = replace(account, notes=(*account.notes, f"no world holds it, because of {' and '.join(why)}"))
    if summary is not None:
        return replace(account, summary=summary.summary)
    return replace(account, notes=(*account.notes, *_presence(subject, goal, given)))


def _presence(subject: Subject, goal: str, given: Sequence[str]) -> list[str]:
    """How probable it is that the hypotheses are present of which a goal speaks; all, where it counts them."""
    if not isinstance(subject, Situation):
        return []
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.asking.presence import listed

    said = set(tokens(goal))
    names = [h.id for h in subject.hypotheses if h.id in said or not said.isdisjoint(COUNTING)]
    scene = LiveScene(subject)
    try:
        for observed in given:
            scene.observe(observed)
        chances = scene.marginals() if names else {}
    except OutsideError:
        return []
    shown = [f"present({quoted(name)}) {sum(chances[name]) / 2:.4g}" for name in names]
    return [f"it rests on {listed(shown)}; each has an explanation of its own"] if shown else []


def _explained(subject: Subject, goal: str, given: Sequence[str], most: int, limits: Limits) -> Account:
    text, names = subject_text(subject)
    with told_in_words(text):
        reply = ask({**request_of([text], [goal], given, names), "task": "prove", "most": most}, limits)
    return Account(
        goal,
        reply["probability"],
        tuple(_explanation(e) for e in reply["for"]),
        tuple(_explanation(e) for e in reply["against"]),
        None if reply["failure"] is None else _reason(reply["failure"]),
        tuple(
            Miss(m["goal"], m["rule"], m["failed"], m["probability"], tuple(map(_reason, m["conditions"])))
            for m in reply["misses"]
        ),
        _covered(reply["covered_for"]),
        _covered(reply["covered_against"]),
        reply["answers"],
        tuple(reply["notes"]),
    )


def present(subject: Subject, goal: str, *, given: Sequence[str] = ()) -> Account | None:
    """Of ``present(h)`` in a scene, or of a relation of its hypotheses; else None.

    P(h | evidence) and what h's features say in the most probable world that holds it; of a relation what geometry says
    and who must be present. Of ``present(h)`` no program is run: this is fast for any number of hypotheses. Raises
    InconsistentError, ProgramError, and WidthError, as the worlds do.
    """
    wanted = goal.strip().rstrip(". ")
    if not isinstance(subject, Situation):
        return None
    name = next((h.id for h in subject.hypotheses if wanted in (f"present({h.id})", f"present('{h.id}')")), None)
    if name is None:
        return _related(subject, goal, given)
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.asking.presence import presence
    from plogic.scene.asking.shortfall import shortfall

    scene = LiveScene(subject)
    try:
        for observed in given:
            scene.observe(observed)
        low, high = scene.marginals()[name]
    except OutsideError:
        return None
    account = Account(goal, (low + high) / 2, (), (), None)
    if high == 0:
        return account
    scene.observe(goal)
    world = scene.worlds(1).worlds[0].present
    lacks = shortfall(subject, name, world, account.probability, given)
    return replace(account, summary=(*presence(subject, name, world), *lacks, *_constrained(scene, name)))


def _related(situation: Situation, goal: str, given: Sequence[str]) -> Account | None:
    from plogic.scene.asking.related import open_relation, related

    asked = open_relation(situation, goal)
    answered = answers(situation, goal, given=given) if asked else []
    first = answered[0].goal if answered else goal
    found = related(situation, first, given)
    if found is None:
        return None
    lines = (f"the most probable answer, {first}:", *found[1]) if asked else found[1]
    return Account(goal, found[0], (), (), None, answers=max(len(answered), 1), summary=lines)


def _constrained(scene: "LiveScene", name: str) -> list[str]:
    """The author's constraints that speak of a hypothesis, given that it is present."""
    from plogic.scene.asking.presence import listed

    found = scene.constraints(name)
    kept = [shown for shown, p in found if p == 0.0]
    lines = [f"  violates {shown}, which may fail, with probability {p:.4g}" for shown, p in found if p > 0.0]
    return [*lines, f"  keeps {listed(kept)}"] if kept else lines


def _about(subject: Subject, goals: Sequence[str]) -> Subject:
    """The part of a situation that the goals are about; a part that is left out only has to be possible."""
    if not isinstance(subject, Situation):
        return subject
    from plogic.scene.asking.relevant import relevant
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    part = relevant(subject, goals)
    if part is not subject:
        ranked_worlds(subject, 1)
    return part


def _explanation(entry: dict[str, Any]) -> Explanation:
    return Explanation(
        entry["goal"], entry["probability"], entry["given_evidence"], tuple(entry["choices"]), _reason(entry["tree"])
    )


def _covered(entry: dict[str, Any]) -> Covered:
    return Covered((entry["listed"][0], entry["listed"][1]), entry["unlisted"], entry["stopped"])


def _reason(tree: dict[str, Any]) -> Reason:
    return Reason(tree["goal"], tree["kind"], tuple(_reason(child) for child in tree["children"]), tree["probability"])
