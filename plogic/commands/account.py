"""An account of a goal as text: its probability, its explanations as trees, and why not."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.explain import Account, Explanation, Reason


def account_text(account: Account) -> str:
    """The whole account, most probable explanations first."""
    lines = [f"P({account.goal}) = {account.probability:.6g}"]
    lines += _section("why", account.why) + _section("why not", account.why_not)
    if account.failure is not None:
        lines += ["", "it cannot hold:", *_tree(account.failure, 1)]
    return "\n".join(lines)


def _section(title: str, explanations: tuple[Explanation, ...]) -> list[str]:
    lines = []
    for i, e in enumerate(explanations, 1):
        beside = "" if e.given_evidence is None else f", given the evidence {e.given_evidence:.4g}"
        lines += ["", f"{title} {i}: {e.goal} by choices of probability {e.probability:.4g}{beside}", *_tree(e.tree, 1)]
    return lines


def _tree(reason: Reason, depth: int) -> Iterator[str]:
    yield "  " * depth + f"{reason.goal}  [{reason.kind}]"
    for child in reason.children:
        yield from _tree(child, depth + 1)
