"""The verbs of the shell, one table: what help says, how a line is taken apart, what of the session it calls.

``perform(session, "ask present(h1).")`` is ``session.ask("present(h1)")``; a line without a verb is ``ask``.
"""

import contextlib
import difflib
import os
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from geometry.digits import whole
from geometry.errors import PlogicError
from plogic.base.errors import InputError, UnknownPredicateError
from plogic.face.session.blocks import Result
from plogic.face.session.results import Help, Replayed
from plogic.logic.safety.atoms import OPERATORS

if TYPE_CHECKING:
    from plogic.face.session.session import Session


Takes = Literal["goal", "observed", "number", "predicate", "file", "verb", "nothing"]
"""What a verb's argument is: what completion offers for it."""


@dataclass(frozen=True)
class Verb:
    """``Verb("ask", "ask GOAL", "P(goal)...", "goal", call)``."""

    name: str
    usage: str
    meaning: str
    takes: Takes
    call: "Callable[[Session, str], Result] | None" = None


def _number(verb: str, text: str, default: int) -> int:
    if not text:
        return default
    number = whole(text, 1_000_000)
    if not number:
        raise InputError(f"{verb} {text:.80}: should be a number of worlds, such as {verb} {default}")
    return number


def _numbered(text: str) -> tuple[str, int | None]:
    """``5 present(h1)``: a goal with the number before it, if there is one."""
    match = re.match(r"([1-9][0-9]{0,3})\s+(?=([A-Za-z_]\w*|['(\\]))", text)
    return (text, None) if match is None or match[2] in OPERATORS else (text[match.end() :], int(match[1]))


VERBS = (
    Verb(
        "ask", "ask [GOAL]", "P(goal), every answer, without what was observed", "goal", lambda s, t: s.ask(t or None)
    ),
    Verb("observe", "observe LITERAL", "add evidence; prints how probable it was", "goal", lambda s, t: s.observe(t)),
    Verb(
        "unobserve",
        "unobserve [LITERAL]",
        "take back one observation, or all",
        "observed",
        lambda s, t: s.unobserve(t or None),
    ),
    Verb(
        "predict",
        "predict [GOAL]",
        "P(goal | everything observed), beside P(goal)",
        "goal",
        lambda s, t: s.predict(t or None),
    ),
    Verb(
        "worlds",
        "worlds [N]",
        "the N most probable worlds given what was observed",
        "number",
        lambda s, t: s.worlds(_number("worlds", t, 10)),
    ),
    Verb(
        "why",
        "why [N] GOAL",
        "why it holds, given what was observed; N explanations",
        "goal",
        lambda s, t: s.why(*_numbered(t)),
    ),
    Verb(
        "whynot",
        "whynot [N] GOAL",
        "why it does not hold; N explanations",
        "goal",
        lambda s, t: s.whynot(*_numbered(t)),
    ),
    Verb(
        "listing",
        "listing [NAME]",
        "what was observed; or the clauses of a predicate or a layer",
        "predicate",
        lambda s, t: s.listing(t or None),
    ),
    Verb("save", "save FILE", "write the session's lines to a file", "file", lambda s, t: s.save(t)),
    Verb("load", "load FILE", "do the lines of a saved session", "file", lambda s, t: s.load(t)),
    Verb("help", "help [VERB]", "this table, or what a verb or a predicate means", "verb"),
    Verb("quit", "quit", "end the session (Ctrl-D, too)", "nothing"),
)
SYNONYMS = {"how": "why", "exit": "quit"}
MOST_LINES = 1000
"""Of a saved session: `help`, which is quick, takes 6 ms."""

_LINE = re.compile(r"\s*([a-z]+)(?=\s|\.?\s*$)\s*(.*)", re.DOTALL)
_LIKE_A_VERB = re.compile(r"\s*([a-z_]\w*)\s+([A-Za-z_]\w*|'|\\\+)", re.ASCII)


def verb_of(line: str) -> tuple[str, str]:
    """The verb of a line and its argument without the full stop.

    Raises InputError where a verb was meant that there is not.
    """
    match = _LINE.match(line)
    name = match[1] if match else ""
    name = SYNONYMS.get(name, name)
    if match and any(verb.name == name for verb in VERBS):
        return name, match[2].strip().removesuffix(".").rstrip()
    meant = _LIKE_A_VERB.match(line)
    if meant and meant[1] not in OPERATORS and meant[2] not in OPERATORS:
        raise InputError(f"{meant[1]} is no verb{_perhaps(meant[1])}; `help` lists them")
    return "ask", line.strip().removesuffix(".").rstrip()


def is_end(line: str) -> bool:
    """Whether the line is ``quit``."""
    match = _LINE.match(line)
    return match is not None and SYNONYMS.get(match[1], match[1]) == "quit"


def perform(session: "Session", line: str) -> Result | None:
    """What a line comes to; None for an empty line, a comment and ``quit``. Raises what the verb raises."""
    if not line.strip() or line.lstrip().startswith("%"):
        return None
    name, argument = verb_of(line)
    verb = next(verb for verb in VERBS if verb.name == name)
    if name == "help":
        return helped(session, argument)
    if verb.call is None:
        return None
    if not argument and not verb.usage.endswith("]") and " " in verb.usage:
        raise InputError(f"{name}: what? `{verb.usage}`: {verb.meaning}")
    try:
        return verb.call(session, argument)
    except UnknownPredicateError as error:
        raise _helpful(error, argument) from None


def helped(session: "Session", topic: str) -> Result:
    """The table of verbs; or what one verb, or a predicate that can be asked for, means.

    Raises InputError where it is neither.
    """
    if not topic:
        return Help("verbs (a line without one is `ask`)", tuple((verb.usage, verb.meaning) for verb in VERBS))
    name = SYNONYMS.get(topic, topic)
    found = [(verb.usage, verb.meaning) for verb in VERBS if verb.name == name]
    found += [(known.usage, known.meaning) for known in session.predicates() if name in (known.name, known.signature)]
    if not found:
        raise InputError(f"help {topic}: is neither a verb nor a predicate{_perhaps(topic)}")
    return Help(f"help {topic}", tuple(dict.fromkeys(found)))


def _helpful(error: UnknownPredicateError, goal: str) -> UnknownPredicateError:
    """The same error; where the goal is one word that looks like a verb, with that verb."""
    hint = _perhaps(goal) if goal.isidentifier() else ""
    return UnknownPredicateError(f"{error.reason}{hint}", file=error.file, line=error.line, column=error.column)


def _perhaps(word: str) -> str:
    near = difflib.get_close_matches(word, [verb.name for verb in VERBS], 1)
    return f" (did you mean `{near[0]}`?)" if near else ""


def attempted(session: "Session", line: str) -> tuple[Result | None, list[str]]:
    """What the line came to, and the mistakes in it, a sentence each: a line that fails never ends the session."""
    try:
        return perform(session, line), []
    except PlogicError as error:
        return None, str(error).splitlines()
    except Exception as error:  # a mistake of ours in one verb is no reason to lose the session
        if os.environ.get("PLOGIC_TRACEBACK"):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())
        return None, [f"internal error: {what} (please report it with the traceback that PLOGIC_TRACEBACK=1 shows)"]


def shown(text: str) -> str:
    """A result's text, set off from the next by an empty line where it is more than a sentence."""
    return text.rstrip("\n") + "\n" + "\n" * ("\n" in text)


def replayed(session: "Session", file: str, text: str) -> Replayed:
    """What each line comes to; raises InputError with file and line at the first that fails.

    A stranger's session asks and observes; it writes nothing, and takes no end of time.
    """
    results, lines = [], text.splitlines()
    if len(lines) > MOST_LINES:
        raise InputError(f"{file}: has {len(lines)} lines, more than the {MOST_LINES} that are done")
    for number, line in enumerate(lines, 1):
        try:
            if (verb := verb_of(line)[0]) in ("load", "save"):
                raise InputError(f"a saved session {verb}s nothing: type it yourself")
            result = perform(session, line)
        except PlogicError as error:
            raise InputError(f"{file}:{number}: {error}") from None
        if result is not None:
            results.append(result)
    return Replayed(tuple(results))


def run_lines(
    session: "Session", lines: Iterable[bytes], write: Callable[[str], None], say: Callable[[str], None]
) -> int:
    """Do every line up to ``quit``; a line that fails is told and does not end the session. The exit code.

    1 if any failed, else 0.
    """
    status = 0
    for number, data in enumerate(lines, 1):
        result, mistakes = None, ["is not UTF-8 text"]
        with contextlib.suppress(UnicodeDecodeError):
            line = data.decode("utf-8-sig")
            if is_end(line):
                break
            result, mistakes = attempted(session, line)
        if result is not None:
            write(shown(str(result)))
        for mistake in mistakes:
            status = 1
            say(f"plogic: line {number}: {mistake}")
    return status
