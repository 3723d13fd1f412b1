"""``plogic kb show KB TYPE --html FILE``: an object type as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from plogic.base.errors import InputError
from plogic.run.sources import kb_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from kb.clouds.cloud import KnowledgeBase, ObjectType


def page_command(
    folder: str, name: str | None, out: str, *, say: Callable[[str], None], write: Callable[[str], None]
) -> None:
    """Write the page of a type, the KB's only one where none is named; `-` is stdout. Raises InputError."""
    from plogic.face.pages.type_page import type_page
    from sensing.files.whole_files import write_whole

    kb = kb_of(folder)
    text = type_page(kb, type_of(kb, name))
    if out == "-":
        write(text)
        return
    write_whole(Path(out), text.encode())
    say(f"wrote {out}")


def type_of(kb: KnowledgeBase, name: str | None) -> ObjectType:
    """The type of that name. Raises InputError, naming those that there are."""
    known = {kind.name: kind for kind in kb.types}
    there = f"there are: {', '.join(known) or 'none (plogic kb add)'}"
    if name is not None and name not in known:
        raise InputError(f"{name}: no such object type; {there}")
    if name is None and len(known) != 1:
        raise InputError(f"{kb.name}: a page shows one object type: name it; {there}")
    return known[name] if name is not None else kb.types[0]
