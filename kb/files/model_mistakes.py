"""What pydantic finds wrong with a document, in our words and at its place."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from pydantic import BaseModel, ValidationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic_core import ErrorDetails

    from kb.errors import Mistake
    from kb.files.yaml_text import Document, Path

Model = TypeVar("Model", bound=BaseModel)

WORDS = {
    "extra_forbidden": "unknown key",
    "missing": "missing",
    "model_type": "must be a mapping of keys to values",
    "model_attributes_type": "must be a mapping of keys to values",
    "dict_type": "must be a mapping of keys to values",
    "list_type": "must be a list",
    "tuple_type": "must be a list",
}
WHY_UNITS = "missing; no mesh format carries its unit, so it must be stated, as in 'units: m'"


def checked(model: type[Model], document: Document) -> tuple[Model | None, list[Mistake]]:
    """The document as the model, or None and every mistake; none for a document that was no YAML: that has been said."""
    if document.root is None and document.mistakes:
        return None, []
    if document.data is None and not document.mistakes:
        return None, [document.mistake((), "the file is empty")]
    try:
        return model.model_validate(document.data), []
    except ValidationError as error:
        wrong = [_mistake(document, detail) for detail in error.errors(include_url=False, include_input=False)]
        cut = [tuple(mistake.path.split(".")) for mistake in document.mistakes if mistake.message.startswith("A2")]
        return None, without(wrong, cut)


def without(mistakes: Sequence[Mistake], places: Sequence[Path]) -> list[Mistake]:
    """The mistakes that are not at or below one of the places: of those another mistake has said what is wrong."""
    prefixes = {".".join(str(step) for step in place) for place in places if place}
    lengths = {len(prefix) for prefix in prefixes}
    return [m for m in mistakes if not any(m.path[n : n + 1] in ("", ".") and m.path[:n] in prefixes for n in lengths)]


def _mistake(document: Document, detail: ErrorDetails) -> Mistake:
    kind = detail["type"]
    path: Path = tuple(step for step in detail["loc"] if step != "[key]")
    at_key = kind == "extra_forbidden" or "[key]" in detail["loc"]
    return document.mistake(path, _message(kind, path, detail), key=at_key)


def _message(kind: str, path: Path, detail: ErrorDetails) -> str:
    if kind == "missing" and path[-2:] == ("mesh", "units"):
        return WHY_UNITS
    if kind == "value_error":
        return str(detail["ctx"]["error"])
    return WORDS.get(kind) or f"{detail['msg'][:1].lower()}{detail['msg'][1:]}"
