"""Whether a knowledge base can be used, and what writers that were killed left in it."""

from collections.abc import Iterator
from pathlib import Path
from time import time

from geometry.errors import PlogicError
from plogic.run.health.findings import REPAIRS, Finding, counted
from plogic.run.health.remains import removed
from plogic.run.sources import kb_folder, kb_of
from sensing.files.whole_files import left_beside

OLD = 3600.0
"""Seconds after which nobody writes a file any more."""
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
            yield Finding(area, "mistakes", "wrong", f"{len(lines) - NAMED} more", f"plogic kb check {name}")
        return
    learned = sum(kind.learned is not None for kind in kb.types)
    told = f"loads: {counted(len(kb.types), 'type', 'types')}, {learned} of them learned; digest {kb.digest[:12]}"
    yield Finding(area, "files", "fine", told)


def unfinished(folder: Path) -> list[Path]:
    """What writers were writing in a knowledge base, or beside it, when they were killed, or are writing now."""
    inside = [folder, folder / "objects", *sorted(folder.glob("objects/[!.]*"))]
    beside = [
        path for path in left_beside(folder.resolve().parent) if path.name.startswith(f".{folder.resolve().name}.")
    ]
    return [*beside, *(path for place in inside for path in left_beside(place))]


def _writes(area: str, folder: Path, *, fix: bool) -> Iterator[Finding]:
    found = unfinished(folder)
    old = [path for path in found if time() - path.lstat().st_mtime > OLD]
    if old:
        told = f"{counted(len(old), 'file', 'files')} of a writer that was killed: {old[0]}"
        yield removed(Finding(area, "unfinished writes", "wrong", told, REPAIRS), old, fix=fix)
    if len(found) > len(old):
        (young, *_) = [path for path in found if path not in old]
        told = f"{young} is being written, or its writer was killed within the hour"
        yield Finding(area, "unfinished writes", "note", told, "look again in an hour")
    if not found:
        yield Finding(area, "unfinished writes", "fine", "none")
