"""``plogic doctor``: what is wrong with the installation, its caches and knowledge bases, and its repair.

It tells what it can where packages are missing, click among them: what is imported here is our own, and needs none.
"""

import json
import platform
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby, pairwise

from plogic.face.shown.printed import emit
from plogic.run.health.findings import REPAIRS, Finding, FindingRow, Health

MARKS = {"fine": "ok", "note": "note", "wrong": "WRONG", "repaired": "repaired"}


def doctor_command(knowledge_bases: Sequence[str], *, fix: bool, as_json: bool) -> tuple[str, int]:
    """What was found, for people or as one ``doctor/1`` document, and the exit status: 1 where something is wrong."""
    found = list(_looked(knowledge_bases, fix=fix))
    healthy = all(one.state != "wrong" for one in found)
    text = json.dumps(_document(found, healthy=healthy)) if as_json else "\n".join(_lines(found))
    return text, 0 if healthy else 1


def _looked(knowledge_bases: Sequence[str], *, fix: bool) -> Iterator[Finding]:
    """All findings. A part of ours that cannot even be imported is one more."""
    from plogic.run.health.installation import installation
    from plogic.run.health.surroundings import console, limits, tools

    yield from _guarded("installation", installation)
    yield from _guarded("tools", tools)
    yield from _guarded("caches", partial(_caches, fix=fix))
    yield from _guarded("scratch", partial(_scratch, fix=fix))
    yield from _guarded("limits", limits)
    yield from _guarded("console", console)
    for name in knowledge_bases:
        yield from _guarded(f"knowledge base {name}", partial(_knowledge, name, fix=fix))


def _caches(*, fix: bool) -> Iterable[Finding]:
    from plogic.run.health.remains import caches

    return caches(fix=fix)


def _scratch(*, fix: bool) -> Iterable[Finding]:
    from plogic.run.health.remains import scratch

    return scratch(fix=fix)


def _knowledge(name: str, *, fix: bool) -> Iterable[Finding]:
    from plogic.run.health.knowledge import knowledge

    return knowledge(name, fix=fix)


def _guarded(area: str, look: Callable[[], Iterable[Finding]]) -> Iterator[Finding]:
    """The findings of one look, up to where it fails: what is broken may break it in any way."""
    try:
        yield from look()
    except Exception as error:  # noqa: BLE001 - see above
        told = f"cannot be looked at: {' '.join(f'{type(error).__name__}: {error}'.split())[:300]}"
        yield Finding(area, "look", "wrong", told, "mend the installation first")


def _document(found: Sequence[Finding], *, healthy: bool) -> Health:
    try:
        own: str | None = version("plogic")
    except PackageNotFoundError:
        own = None
    return {
        "format": "doctor/1",
        "plogic": own,
        "python": platform.python_version(),
        "healthy": healthy,
        "findings": [_row(one) for one in found],
    }


def _row(one: Finding) -> FindingRow:
    row: FindingRow = {"area": one.area, "name": one.name, "state": one.state, "told": one.told}
    return row | {"remedy": one.remedy} if one.remedy else row


def _lines(found: Sequence[Finding]) -> Iterator[str]:
    """A line each; of the packages those that are fine in one."""
    for area, some in groupby(found, lambda one: one.area):
        rows = list(some)
        yield area
        fine = [f"{one.name} {one.told}" for one in rows if one.state == "fine"] if area == "installation" else []
        yield from _wrapped(fine)
        for one in rows:
            if not fine or one.state != "fine":
                remedy = f"; {one.remedy}" if one.remedy else ""
                yield f"  {MARKS[one.state]:<8}  {one.name}: {one.told}{remedy}"
    wrong = [one for one in found if one.state == "wrong"]
    left = [one for one in found if one.state in ("wrong", "note") and one.remedy == REPAIRS]
    yield f"{len(wrong)} wrong" if wrong else "healthy"
    if left:
        yield f"{REPAIRS} repairs {len(left)} of what was found"


def _wrapped(names: Sequence[str]) -> Iterator[str]:
    from textwrap import wrap

    head = f"  {MARKS['fine']:<8}  "
    yield from wrap(", ".join(names), 110, initial_indent=head, subsequent_indent=" " * len(head)) if names else ()


def doctor_alone(arguments: Sequence[str]) -> int:
    """``plogic doctor`` where click cannot be imported; returns the exit status."""
    kb = [value for key, value in pairwise(arguments) if key == "--kb"]
    text, status = doctor_command(kb, fix="--fix" in arguments, as_json="--json" in arguments)
    emit(text)
    return status
