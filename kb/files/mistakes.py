"""What pydantic finds wrong with a document, in our words and at its place."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from kb.errors import Mistake
from kb.files.branches import nodes
from kb.files.schema import KBModel
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
    """The document as the model, or None and every mistake.

    None for a document that was no YAML: that has been said.
    """
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


def cross_mistakes(
    kb: Document, model: KBModel | None, objects: Sequence[Document], *, complete: bool
) -> Iterator[Mistake]:
    """Types of appearances, features and objects that are nowhere declared, and types of objects that are declared twice.

    Where the objects are not ``complete``, some being unreadable, nobody can say which feature and object types are
    unknown.
    """
    yield from _repeated_objects(objects)
    vocabulary = _vocabulary(kb)
    if vocabulary is not None:
        known = {name for name in vocabulary if isinstance(name, str)}
        for document in objects:
            yield from _unknown_appearances(document, vocabulary, known)
    if model is not None:
        yield from _unknown(
            kb, ("detector", "clutter"), model.detector.clutter, set(model.appearance_types), "appearance"
        )
        yield from _unknown(kb, ("counts", "clutter"), model.counts.clutter, set(model.appearance_types), "appearance")
        yield from _repeated_types(kb, model)
    if model is not None and complete:
        features = {name for document in objects for name in _types(document, "feature")}
        yield from _unknown(kb, ("detector", "hit"), model.detector.hit, features, "feature")
        yield from _unknown(kb, ("detector", "sigmas"), model.detector.sigmas, features, "feature")
        yield from _unknown(kb, ("counts", "hit"), model.counts.hit, features, "feature")
        names = {name for document in objects if isinstance(name := _name(document), str)}
        yield from _unknown(kb, ("priors",), model.priors, names, "object")
        yield from _unknown(kb, ("counts", "prior"), model.counts.prior, names, "object")


def _name(document: Document) -> object:
    return document.data.get("object")


def _vocabulary(kb: Document) -> list[Any] | None:
    """The appearance types, if they can be made out, whatever else is wrong."""
    types = kb.data.get("appearance_types") if isinstance(kb.data, dict) else None
    return types if isinstance(types, list) else None


def _types(document: Document, kind: str) -> Iterator[str]:
    for _, sort, entry in nodes(document.data):
        if sort == kind and isinstance(entry, dict) and isinstance(entry.get("type"), str):
            yield entry["type"]


def _unknown_appearances(document: Document, vocabulary: list[Any], known: set[str]) -> Iterator[Mistake]:
    listed = ", ".join(map(str, vocabulary[:12])) or "none"
    for path, kind, entry in nodes(document.data):
        name = entry.get("type") if kind == "appearance" and isinstance(entry, dict) else None
        if isinstance(name, str) and name not in known:
            yield document.mistake(
                (*path, "type"), f"unknown appearance type {name!r}; appearance_types in kb.yaml: {listed}"
            )


def _unknown(
    kb: Document, path: tuple[str, ...], given: Mapping[str, object], known: set[Any], what: str
) -> Iterator[Mistake]:
    listed = ", ".join(sorted(map(str, known))[:12]) or "none"
    for name in given:
        if name not in known:
            yield kb.mistake((*path, name), f"unknown {what} type {name!r}; known: {listed}", key=True)


def _repeated_types(kb: Document, model: KBModel) -> Iterator[Mistake]:
    before: set[str] = set()
    for index, name in enumerate(model.appearance_types):
        if name in before:
            yield kb.mistake(("appearance_types", index), f"{name!r} was listed before")
        before.add(name)


def _repeated_objects(objects: Sequence[Document]) -> Iterator[Mistake]:
    first: dict[str, str] = {}
    for document in objects:
        name = _name(document)
        if isinstance(name, str) and first.setdefault(name, document.file) != document.file:
            yield document.mistake(("object",), f"{name!r} is also the object of {first[name]}")
