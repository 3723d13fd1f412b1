"""One request to the child process: what kind it is, and who answers it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from plogic.logic.safety.atoms import Names

if TYPE_CHECKING:
    from collections.abc import Callable


def serve(request: dict[str, Any], tell: Callable[[dict[str, Any]], None] | None = None) -> dict[str, Any]:
    """The reply to a request: ``{"texts": [{"text", "file"}], "goals": [...], "given": [...], "names": {label: atom} | null}`` and a ``task``.

    Without a task: ``{"answers": [[[goal, p], ...], ...]}``, one list of answers per goal; without goals, one list for
    the program's own query/1. With ``anytime``, ``tell`` gets replies with intervals, ``[goal, low, high]``, before the
    exact one.
    """
    task = request.get("task")
    if task == "outline":
        from plogic.logic.served.outline_reader import outline

        return outline(request)
    if task == "worlds":
        from plogic.logic.answers.state_ranking import ranked

        return ranked(request, tell)
    names = _names(request["names"])
    if task == "prove":
        from plogic.logic.served.prove import prove

        return prove(request, names)
    if task == "formula":
        from plogic.logic.served.goal_formulas import formulas

        return formulas(request)
    return _answered(request, tell)


def _answered(request: dict[str, Any], tell: Callable[[dict[str, Any]], None] | None) -> dict[str, Any]:
    if request.get("anytime") and tell is not None:
        from plogic.logic.answers.anytime_answers import answers_by

        return answers_by(request, tell)
    from plogic.logic.answers.answer import answers_to

    return {"answers": answers_to(request)}


def _names(atoms: dict[str, str] | None) -> Names | None:
    return None if atoms is None else Names(atoms, {atom: label for label, atom in atoms.items()})
