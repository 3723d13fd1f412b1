"""Documents that were found right before: to read and check them again takes ruamel and pydantic, longer than all else.

What they say is found again by their bytes and names, the code that reads them, and the libraries' versions. Documents
with a mistake are not kept.

Vocabulary: ``Said(document, told, [])``, ``told.name == told["name"] == "towers"``.

* ``said(place, kb, objects)``: what the documents of a knowledge base say, or what is wrong with them
"""

import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from geometry.files.remembered import arrays_of
from kb.errors import Mistake
from kb.files.folder import Document, Folder
from kb.files.kept_surfaces import read_by

if TYPE_CHECKING:
    from kb.files.schema import KBModel, ObjectModel

Model = TypeVar("Model")

SOURCES = "kb/files", "kb/clouds/cloud.py"
"""What reads and checks a document."""
LIBRARIES = "pydantic", "ruamel.yaml"
KEPT = 64
"""Knowledge bases whose documents are kept; those used last."""


class Told(dict[str, Any]):
    """What a mapping of a checked document says, by its keys or as attributes, as pydantic's models say it."""

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - any value
        """The value of a key."""
        return self[name]


@dataclass(frozen=True, eq=False)
class Said(Generic[Model]):
    """A document, what it says by its model, None where it has a mistake, and the ``mistakes`` that the model found."""

    document: Document
    model: Model | None
    mistakes: list[Mistake]


class _MistakenError(Exception):
    """Documents have mistakes, and are not to be kept."""


def said(place: Folder, kb: Path, objects: Sequence[Path]) -> "tuple[Said[KBModel], list[Said[ObjectModel]]]":
    """What ``kb.yaml``, which can be read, and the types' documents say.

    Those that cannot be read are left out; that, and mistakes of the texts, join the folder's mistakes.
    """
    contents = {path: content for path in (kb, *objects) if (content := place.content(path)) is not None}
    found = _checked(place, contents) if place.kept is None else _kept(place, contents, place.kept / "documents")
    return cast("Said[KBModel]", found[0]), cast("list[Said[ObjectModel]]", found[1:])


def _checked(place: Folder, paths: Iterable[Path]) -> list[Said[Told]]:
    """Each document, the first being ``kb.yaml``."""
    from kb.files.checking import checked
    from kb.files.schema import KBModel, ObjectModel

    found = list[Said[Told]]()
    for document in filter(None, map(place.document, paths)):
        text, wrong = checked(ObjectModel if found else KBModel, document)
        unread = {key for one in document.mistakes for key in _with_its_list(one.path)}
        wrong = [one for one in wrong if one.path not in unread]
        found.append(Said(document, None if text is None else _told(text), wrong))
    return found


def _with_its_list(key: str) -> tuple[str, ...]:
    """Where a value could not be read, and the list of numbers that it is in: what stands for it is no mistake."""
    above, _, last = key.rpartition(".")
    return (key, above) if above and last.isdigit() else (key,)


def _told(text: str) -> Any:  # noqa: ANN401 - any JSON
    return json.loads(text, object_hook=Told)


def _kept(place: Folder, contents: dict[Path, bytes], folder: Path) -> list[Said[Told]]:
    fresh = list[Said[Told]]()

    def made() -> dict[str, NDArray[np.uint8]]:
        fresh.extend(_checked(place, contents))
        if any(one.model is None or one.mistakes or one.document.mistakes for one in fresh):
            raise _MistakenError
        rows = [[one.document.data, one.model] for one in fresh]
        return {"said": np.frombuffer(json.dumps(rows).encode(), np.uint8)}

    named = {place.name(path): content for path, content in contents.items()}
    try:
        rows = _told(arrays_of(folder / _key(named), ("said",), made, KEPT)["said"].tobytes().decode())
    except _MistakenError:
        return fresh
    return [
        Said(Document(name, data, partial(_composed, content), ()), model, [])
        for (name, content), (data, model) in zip(named.items(), rows, strict=True)
    ]


def _composed(content: bytes) -> Any:  # noqa: ANN401 - a node, where only a mistake imports what it is
    from kb.files.yaml_text import composed

    return composed(content)


def _key(named: dict[str, bytes]) -> str:
    """64 hex digits of documents by their names."""
    parts = [
        read_by(LIBRARIES, SOURCES),
        *(part for name, content in named.items() for part in (os.fsencode(name), content)),
    ]
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
