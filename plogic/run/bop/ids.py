"""Which BOP object a type of the KB is: by its name, ``obj_000005``, or by a file ``{"003_cracker_box": 2}``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from plogic.base.errors import InputError
from plogic.run.bop.json_files import read_json, shown, whole

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

NAMED = re.compile(r"obj_0*(\d+)")


def ids_of(types: Sequence[str], stated: Mapping[str, int]) -> dict[str, int]:
    """The numbers of the types that have one, ``stated`` before what a name says. Raises InputError where two types have one number."""
    named = {name: int(match[1]) for name in types if (match := NAMED.fullmatch(name))}
    found = {name: stated.get(name, named.get(name, -1)) for name in types if name in stated or name in named}
    for name, number in found.items():
        twin = next(other for other, its in found.items() if its == number)
        if twin != name:
            raise InputError(f"{twin} and {name} are both BOP object {number}")
    return found


def read_ids(path: str | None) -> dict[str, int]:
    """The numbers that a file states; none without a file. Raises InputError."""
    if path is None:
        return {}
    content = read_json(Path(path))
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be an object of numbers by type name, not {shown(content)}")
    return {name: whole(number, f"{path}: {name}") for name, number in content.items()}


def unknown(
    types: Sequence[str], ids: Mapping[str, int], stated: Collection[str], models: Collection[int] | None
) -> list[str]:
    """A line for each name or number that leads nowhere; ``models``: the objects that the dataset has, None where it does not say."""
    lines = [
        f"{name}: has no BOP number: what is found of it is left out (name it obj_000001, or give --ids)"
        for name in types
        if name not in ids
    ]
    lines += [
        f"{name}: has a BOP number, but the knowledge base has no such type" for name in stated if name not in types
    ]
    lines += [
        f"{name}: the dataset has no object {n}" for name, n in ids.items() if models is not None and n not in models
    ]
    return lines
