"""A document held to its model; what pydantic finds wrong is told in our words and at its place."""

import json

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from kb.errors import Mistake
from kb.files.branches import without
from kb.files.folder import Document, Keys

WORDS = {
    "extra_forbidden": "unknown key",
    "missing": "missing",
    "model_type": "must be a mapping of keys to values",
    "model_attributes_type": "must be a mapping of keys to values",
    "dict_type": "must be a mapping of keys to values",
    "list_type": "must be a list",
    "tuple_type": "must be a list",
}
MAPPED = {
    "mesh": "{file: mesh.obj, units: m}",
    "cloud": "{file: cloud.npz}",
    "lobe": "{axis: [0, 0, 1], half_angle: 60 deg, range: [0.2 m, 5 m]}",
}
"""Keys whose value is a mapping, each with one that would be right."""
WHY_UNITS = "missing; no mesh format carries its unit, so it must be stated, as in 'units: m'"


def checked(model: type[BaseModel], document: Document) -> tuple[str | None, list[Mistake]]:
    """What the document says by the model, as JSON, or None and every mistake.

    None for a document that was no YAML: that has been said.
    """
    if document.root is None and document.mistakes:
        return None, []
    if document.data is None and not document.mistakes:
        return None, [document.mistake((), "the file is empty")]
    try:
        return json.dumps(model.model_validate(document.data).model_dump()), []
    except ValidationError as error:
        wrong = [_mistake(document, detail) for detail in error.errors(include_url=False, include_input=False)]
        cut = [tuple(mistake.path.split(".")) for mistake in document.mistakes if mistake.message.startswith("A2")]
        return None, without(wrong, cut)


def _mistake(document: Document, detail: ErrorDetails) -> Mistake:
    kind = detail["type"]
    path: Keys = tuple(step for step in detail["loc"] if step != "[key]")
    at_key = kind == "extra_forbidden" or "[key]" in detail["loc"]
    return document.mistake(path, _message(kind, path, detail), key=at_key)


def _message(kind: str, path: Keys, detail: ErrorDetails) -> str:
    if kind == "missing" and path[-2:] == ("mesh", "units"):
        return WHY_UNITS
    if kind == "value_error":
        return str(detail["ctx"]["error"])
    if kind.startswith("model_") and path and path[-1] in MAPPED:
        return f"{WORDS[kind]}, as in '{path[-1]}: {MAPPED[path[-1]]}'"
    return WORDS.get(kind) or f"{detail['msg'][:1].lower()}{detail['msg'][1:]}"
