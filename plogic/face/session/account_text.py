"""An account of a goal as text: its probability, why, why not, and what it lacked."""

from collections.abc import Iterator

from plogic.face.shown.figures import precise
from plogic.scene.asking.explanations import Account, Covered, Explanation, Miss, Reason


def account_text(account: Account, *, brief: bool = False) -> str:
    """The whole account, most probable explanations first; ``brief``: of a summary alone, with how to get the rest."""
    lines = [_head(account), *account.summary]
    if brief:
        return "\n".join([*lines, "", "choice by choice: -n 5, or --json"])
    lines += _section("why", account.why, account.covered)
    lines += _section("why not", tuple(e for e in account.why_not if e.choices), account.covered_not)
    if account.misses:
        lines += [
            "",
            "nearest misses, what lacked least first:",
            *(line for i, m in enumerate(account.misses, 1) for line in _miss(i, m)),
        ]
    elif account.failure is not None:
        conditions = (line for child in account.failure.children for line in _condition(child, 1))
        lines += ["", "it cannot hold: no fact and no rule gives it", *conditions]
    return "\n".join([*lines, *([""] if account.notes else []), *(f"note: {note}" for note in account.notes)])


def _head(account: Account) -> str:
    beside = f", its most probable of {account.answers} answers" if account.answers > 1 else ""
    return f"P({account.goal}) = {precise(account.probability, 6)}{beside}"


def _section(title: str, explanations: tuple[Explanation, ...], covered: Covered) -> list[str]:
    lines: list[str] = []
    for i, e in enumerate(explanations, 1):
        lines += ["", f"{title} {i}: {_choices(e)}  {_chance(e)}", *_tree(e.tree, 1)]
    if explanations:
        lines += [*([""] if len(explanations) > 1 else []), _rest(len(explanations), covered)]
    elif covered.stopped:
        lines += ["", f"{title}: the search was stopped before it found an explanation"]
    return lines


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


def _tree(reason: Reason, depth: int) -> Iterator[str]:
    indent = "  " * depth
    if reason.kind == "case":
        yield f"{indent}if {reason.goal}{':' if reason.children else ''}"
    elif reason.kind == "cases":
        yield f"{indent}{reason.goal}  [{'in every world by one of these' if reason.children else 'whichever way the other choices fall'}]"
    else:
        yield f"{indent}{reason.goal}  [{reason.kind}]"
    for child in reason.children:
        yield from _tree(child, depth + 1)


def _miss(number: int, miss: Miss) -> Iterator[str]:
    count = len(miss.conditions)
    if not count:
        yield f"  {number}. {miss.goal}: only by the choice {miss.rule}, which fell otherwise"
        return
    failed = (
        f"{miss.failed} of {count} conditions {'fail' if miss.failed > 1 else 'fails'}"
        if count > 1
        else "its condition fails"
    )
    yield f"  {number}. {miss.goal}: {failed if miss.failed else f'P(all conditions) = {precise(miss.probability, 4)}'}"
    if miss.rule:
        yield f"     {miss.rule}"
    for condition in miss.conditions:
        yield from _condition(condition, 3)


def _condition(reason: Reason, depth: int) -> Iterator[str]:
    known = reason.kind in ("holds", "fails", "open") or reason.probability is None
    mark = reason.kind if reason.probability is None or known else precise(reason.probability, 3)
    yield "  " * depth + f"[{mark:^5}] {reason.goal}"
    for child in reason.children:
        yield from _condition(child, depth + 2)
