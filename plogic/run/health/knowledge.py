"""Whether a knowledge base can be used, and what writers that were killed left in it."""

from collections.abc import Iterator
from pathlib import Path
from shlex import quote

from geometry.errors import PlogicError
from geometry.files.begun import left_in
from kb.files.changes import LOCK, NO_LOCK, has_no_lock, holder, is_changing, settle
from plogic.run.health.findings import REPAIRS, Finding, counted
from plogic.run.health.remains import removed
from plogic.run.sources import kb_folder, kb_of

NAMED = 20
"""Mistakes that are told."""


def knowledge(name: str, *, fix: bool) -> Iterator[Finding]:
    """A knowledge base, its own folder or one that is shipped: its leftovers first, then whether it loads."""
    area = f"knowledge base {name}"
    try:
        yield from _writes(area, kb_folder(name), fix=fix)
        kb = kb_of(name)
    except PlogicError as error:
        lines = str(error).splitlines()
        for line in lines[:NAMED]:
            yield Finding(area, "mistake", "wrong", line, "mend the file")
        if len(lines) > NAMED:
            yield Finding(area, "mistakes", "wrong", f"{len(lines) - NAMED} more", f"plogic kb check {quote(name)}")
        return
    learned = sum(kind.learned is not None for kind in kb.types)
    told = f"loads: {counted(len(kb.types), 'type', 'types')}, {learned} of them learned; digest {kb.digest[:12]}"
    yield Finding(area, "files", "fine", told)


def unfinished(folder: Path) -> list[Path]:
    """What writers that were killed began in a knowledge base, or beside it."""
    real = folder.resolve()
    beside = [path for path in left_in(real.parent) if path.name.startswith(f".{real.name}.")]
    inside = [folder, folder / "objects", *sorted(folder.glob("objects/[!.]*"))]
    return [*beside, *(path for place in inside if _is_in(place, real) for path in left_in(place))]


def _is_in(place: Path, real: Path) -> bool:
    """Whether a folder of a knowledge base lies in it, and is no link that leads elsewhere."""
    return place.resolve().is_relative_to(real)


def _writes(area: str, folder: Path, *, fix: bool) -> Iterator[Finding]:
    """Who is changing it, a change that was cut short, and what else is left of killed writers."""
    who = holder(folder)
    if has_no_lock(folder):
        yield Finding(area, "lock", "wrong", f"{folder / LOCK} {NO_LOCK}", "remove it by hand")
    elif who is not None:
        yield Finding(area, "lock", "note", f"process {who} is changing it", "wait until it has ended")
    elif is_changing(folder):
        told = "a change is in force, and was cut short before all its files were at their places"
        if fix:
            settle(folder)
        done = not is_changing(folder)
        yield Finding(
            area, "change", "repaired" if done else "wrong", f"{told}; moved" if done else told, "" if done else REPAIRS
        )
    found = unfinished(folder)
    if found:
        told = f"{counted(len(found), 'file', 'files')} of a writer that was killed: {found[0]}"
        yield removed(Finding(area, "unfinished writes", "wrong", told, REPAIRS), found, fix=fix)
    else:
        yield Finding(area, "unfinished writes", "fine", "none")
