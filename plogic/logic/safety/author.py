"""The knowledge base author's own rules: checked, mapped on their syntax tree, and written out again (§8, layer 4)."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

from plogic.base.errors import ProgramError

if TYPE_CHECKING:
    from plogic.logic.safety.atoms import Names
    from plogic.logic.safety.check import Source

FILE = "rules.pl"


def author_rules(text: str, names: Names, program: frozenset[str], file: str = FILE) -> list[str]:
    """The clauses, one text each; raises ProgramError at the place of what cannot be used.

    ``program``: the signatures that the generated program defines, such as ``present/1``.

    They may call the vocabulary and define predicates of their own. They may not add to what the program defines, nor
    ask or observe: so no rule changes the probability of a world.
    """
    if not text.strip():
        return []
    load_problog()
    from plogic.logic.safety.check import check_source, is_directive, parse
    from plogic.logic.safety.mapping import mapped

    source = parse(text, file)
    spelled = parse("\n".join(f"{mapped(s, names)}." for s in source.statements if not is_directive(s)), file)
    _refuse_evidence(source)
    check_source(source, known=program, protected=program)
    written = [s if is_directive(s) else mapped(s, names) for s in source.statements]
    if [str(s) for s in written if not is_directive(s)] != [str(s) for s in spelled.statements]:
        raise ProgramError("a clause cannot be written back as it was read", file=file)
    return [f"{s}." for s in written]


def load_problog() -> None:
    """Import ProbLog; the copy of pyparsing that it ships warns of its age, which is no user's business."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import problog.program  # noqa: F401


def _refuse_evidence(source: Source) -> None:
    from plogic.logic.safety.allowlist import SPECIAL_HEADS
    from plogic.logic.safety.check import heads

    for statement in source.statements:
        special: list[Any] = [head for head in heads(statement) if head.signature in SPECIAL_HEADS]
        if special:
            raise ProgramError(
                f"{special[0].signature}: rules neither ask nor observe (use a goal, or --given)",
                **source.place(special[0]),
            )
