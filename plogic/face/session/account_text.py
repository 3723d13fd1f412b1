"""An account of a goal as text: its probability, why, why not, and what it lacked."""

from collections.abc import Callable, Iterator
from functools import partial

from plogic.face.shown.figures import precise
from plogic.scene.asking.explanations import Account, Covered, Explanation, Miss, Reason

Piece = Callable[[int], list[str]]
"""A part of the text: its lines with its trees down to a depth, 0 for its heading alone."""
SCREEN = 40
"""Lines that one look takes in."""
EVERYTHING = 1_000_000
"""A depth that no tree has: what is nested deeper is a limit of the run (``TOO_DEEP``)."""
WHOLE = "-n 5, or --json"
"""How all of it is had on the command line."""


def account_text(account: Account, *, brief: bool = False, whole: str | None = None) -> str:
    """The account, most probable explanations first; ``brief``: of a summary alone, with how to get the rest.

    With ``whole``, which says how all of it is had, it fits a screen: the goal's nearest reasons, those of the most
    probable explanation first, and the number of the lines that are left out.
    """
    if brief:
        return "\n".join([_head(account), *account.summary, "", f"choice by choice: {WHOLE}"])
    pieces = _pieces(account)
    lines = _laid(pieces, [EVERYTHING] * len(pieces))
    if whole is None or len(lines) <= SCREEN:
        return "\n".join(lines)
    shown = _laid(pieces, _depths(pieces))
    return "\n".join([*shown, "", f'(the reasons end at "...", {len(lines) - len(shown)} lines are left out: {whole})'])


def _depths(pieces: list[Piece]) -> list[int]:
    """Of each piece the depth to which all together fit a screen; the first are the deepest."""
    depths = [0] * len(pieces)
    for i, piece in enumerate(pieces):
        room = SCREEN - 2 - len(_laid(pieces, depths)) + len(piece(0))
        while len(piece(depths[i])) < len(piece(depths[i] + 1)) <= room:
            depths[i] += 1
    return depths


def _laid(pieces: list[Piece], depths: list[int]) -> list[str]:
    return [line for piece, depth in zip(pieces, depths, strict=True) for line in piece(depth)]


def _pieces(account: Account) -> list[Piece]:
    found = [_fixed(_head(account), *account.summary), *_section("why", account, account.why, account.covered)]
    found += _section("why not", account, tuple(e for e in account.why_not if e.choices), account.covered_not)
    if account.misses:
        found.append(_fixed("", "nearest misses, what lacked least first:"))
        found += [partial(_miss, i, miss) for i, miss in enumerate(account.misses, 1)]
    elif account.failure is not None:
        found.append(_fixed("", "it cannot hold: no fact and no rule gives it"))
        found += [partial(_conditions, (child,), 1) for child in account.failure.children]
    return [*found, _fixed(*([""] if account.notes else []), *(f"note: {note}" for note in account.notes))]


def _fixed(*lines: str) -> Piece:
    return lambda _: [*lines]


def _head(account: Account) -> str:
    beside = f", its most probable of {account.answers} answers" if account.answers > 1 else ""
    return f"P({account.goal}) = {precise(account.probability, 6)}{beside}"


def _section(title: str, account: Account, explanations: tuple[Explanation, ...], covered: Covered) -> list[Piece]:
    several = account.answers > 1 and title == "why"
    found = [partial(_explanation, f"{title} {i}", e, several=several) for i, e in enumerate(explanations, 1)]
    if explanations:
        rest = _rest(len(explanations), covered)
        return [*found, _fixed("", rest) if len(explanations) > 1 else _fixed(rest)]
    return [_fixed("", f"{title}: the search was stopped before it found an explanation")] if covered.stopped else []


def _explanation(title: str, e: Explanation, depth: int, *, several: bool) -> list[str]:
    """Without its tree it says which of several answers it is of; the tree's first line only repeats that."""
    gap = [""] if depth or title.endswith(" 1") else []
    what = f"{e.goal}: {_choices(e)}" if several and not depth else _choices(e)
    return [*gap, f"{title}: {what}  {_chance(e)}", *(_tree(e.tree, 1, depth + 1) if depth else ())]


def _choices(e: Explanation) -> str:
    several = len(e.choices) > 1
    written = (
        f"({choice})" if several and " :- " in choice and not choice.startswith("\\+ (") else choice
        for choice in e.choices
    )
    return " and ".join(written) if e.choices else "it follows without any choice"


def _chance(e: Explanation) -> str:
    before = (
        ""
        if abs(e.probability - e.given_evidence) <= 1e-9 * e.probability
        else f" given the evidence, {precise(e.probability, 4)} before it"
    )
    return f"[P = {precise(e.given_evidence, 4)}{before}]"


def _rest(count: int, covered: Covered) -> str:
    low, high = covered.listed
    listed = f"{precise(low, 4)}" if high - low < 1e-9 else f"between {precise(low, 4)} and {precise(high, 4)}"
    told = f"  listed: {count}, of probability {listed} together; "
    stopped = " (the search was stopped)" if covered.stopped else ""
    return (
        told
        + (
            f"all others add at most {precise(covered.unlisted, 4)}"
            if covered.unlisted > 0
            else "there is nothing beyond them"
        )
        + stopped
    )


def _tree(reason: Reason, depth: int, deepest: int) -> Iterator[str]:
    indent = "  " * depth
    more = " ..." if reason.children and depth == deepest else ""
    if reason.kind == "case":
        yield f"{indent}if {reason.goal}{':' if reason.children else ''}{more}"
    elif reason.kind == "cases":
        yield f"{indent}{reason.goal}  [{'in every world by one of these' if reason.children else 'whichever way the other choices fall'}]{more}"
    else:
        yield f"{indent}{reason.goal}  [{reason.kind}]{more}"
    for child in reason.children if depth < deepest else ():
        yield from _tree(child, depth + 1, deepest)


def _miss(number: int, miss: Miss, depth: int) -> list[str]:
    count = len(miss.conditions)
    if not count:
        return [f"  {number}. {miss.goal}: only by the choice {miss.rule}, which fell otherwise"]
    failed = (
        f"{miss.failed} of {count} conditions {'fail' if miss.failed > 1 else 'fails'}"
        if count > 1
        else "its condition fails"
    )
    what = failed if miss.failed else f"P(all conditions) = {precise(miss.probability, 4)}"
    more = " ..." if not depth else ""
    rule = [f"     {miss.rule}"] if miss.rule and depth else []
    return [
        f"  {number}. {miss.goal}: {what}{more}",
        *rule,
        *(_conditions(miss.conditions, 3, depth - 1) if depth else []),
    ]


def _conditions(reasons: tuple[Reason, ...], indent: int, depth: int) -> list[str]:
    """Conditions with theirs below them, so many levels of those."""
    lines: list[str] = []
    for reason in reasons:
        known = reason.kind in ("holds", "fails", "open") or reason.probability is None
        mark = reason.kind if reason.probability is None or known else precise(reason.probability, 3)
        more = " ..." if reason.children and not depth else ""
        lines.append("  " * indent + f"[{mark:^5}] {reason.goal}{more}")
        lines += _conditions(reason.children, indent + 2, depth - 1) if depth else []
    return lines
