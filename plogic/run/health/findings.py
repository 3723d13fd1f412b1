"""What a look at something finds, in plain words.

Vocabulary: ``Finding("installation", "trimesh", "wrong", "4.4.0 is installed, and not >=4.6.10", "pip install ...")``.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NotRequired, TypedDict

State = Literal["fine", "note", "wrong", "repaired"]


@dataclass(frozen=True)
class Finding:
    """``told`` of a thing's ``name``, in an ``area``; ``remedy``: what to do where it is not fine.

    ``note``: worth to be known, and no fault. ``repaired``: it was wrong, or left behind, and is so no more.
    """

    area: str
    name: str
    state: State
    told: str
    remedy: str = ""


REPAIRS = "plogic doctor --fix"
"""The remedy of what is repaired here."""


def size(count: int) -> str:
    """Bytes for people: ``size(1_234_567) == "1.2 MB"``."""
    for unit, name in ((10**9, "GB"), (10**6, "MB"), (10**3, "kB")):
        if count >= unit:
            return f"{count / unit:.3g} {name}"
    return f"{count} bytes"


def counted(count: int, one: str, more: str) -> str:
    """``counted(2, "entry", "entries") == "2 entries"``."""
    return f"{count} {one if count == 1 else more}"


class FindingRow(TypedDict):
    """One thing that was looked at."""

    area: Annotated[str, "What it belongs to, as `installation`, `caches`, `knowledge base mykb`."]
    name: Annotated[str, "What was looked at."]
    state: Annotated[State, "`note` is worth to be known, and no fault; `repaired` was wrong, and is so no more."]
    told: Annotated[str, "What was found."]
    remedy: NotRequired[Annotated[str, "What to do."]]


class Health(TypedDict):
    """The document ``doctor/1``."""

    format: Literal["doctor/1"]
    plogic: Annotated[str | None, "The version of plogic; null where it has no metadata."]
    python: Annotated[str, "The version of Python."]
    healthy: Annotated[bool, "That nothing is wrong, or is so any more."]
    findings: Annotated[list[FindingRow], "All that was looked at."]
