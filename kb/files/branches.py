"""From a document that an author wrote to the tree's description, and to what is wrong with it.

Any document has an outline, so that mistakes are sought in one that does not fit the schema too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import rotation_from_quat_xyzw, turn_about
from kb.clouds.lobes import Branch, Kind, Lobe

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from kb.errors import Mistake
    from kb.files.folder import Document, Keys
    from kb.files.schema import AppearanceModel, FeatureModel, KBModel, ObjectModel, PartModel, RotationModel

LISTS: dict[str, Kind] = {"parts": "object", "features": "feature", "appearances": "appearance"}
"""The keys whose lists hold what a node is made of, in the order of ``Branch.parts``, and what they should hold."""


def branch_of(model: ObjectModel) -> Branch:
    """The description of a checked document."""
    return Branch("object", model.object, model.object, parts=_held(model))


def _held(model: ObjectModel | PartModel) -> list[Branch]:
    return [_part(part) for part in model.parts] + [_feature(feature) for feature in model.features]


def _part(model: PartModel) -> Branch:
    kind = model.type or model.part
    return Branch("object", model.part, kind, model.at, rotation_matrix(model.rotation), _held(model))


def _feature(model: FeatureModel) -> Branch:
    parts = [_feature(part) for part in model.features] + [_appearance(part) for part in model.appearances]
    turn = rotation_matrix(model.rotation)
    return Branch("feature", model.feature, model.type, model.at, turn, parts, arms=model.arms)


def _appearance(model: AppearanceModel) -> Branch:
    cone = model.lobe
    size = np.nan if model.size is None else model.size
    lobe = None if cone is None else Lobe(np.array(cone.axis), cone.half_angle, cone.range[0], cone.range[1], size)
    parts = [_appearance(part) for part in model.appearances]
    return Branch("appearance", "", model.type, parts=parts, lobe=lobe)


def rotation_matrix(model: RotationModel | None) -> NDArray[np.float64]:
    """parent_from_child (3, 3)."""
    if model is None:
        return np.eye(3)
    if model.quat_xyzw is not None:
        return np.asarray(rotation_from_quat_xyzw(model.quat_xyzw))
    x, y, z = map(turn_about, np.eye(3), model.euler_xyz or ())
    return np.asarray(z @ y @ x)


def held(raw: object) -> Iterator[tuple[Keys, Kind, Any]]:
    """What hangs directly below a node of any document, in the order of ``Branch.parts``.

    Each is (keys from the node, kind, document).
    """
    for key, kind in LISTS.items():
        items = raw.get(key) if isinstance(raw, dict) else None
        for index, item in enumerate(items if isinstance(items, list) else ()):
            yield (key, index), _kind(item, kind), item


def _kind(item: object, usual: Kind) -> Kind:
    """What an entry says that it is, wherever it stands: a feature in a list of parts is a feature."""
    if isinstance(item, dict) and "part" in item:
        return "object"
    return "feature" if isinstance(item, dict) and "feature" in item else usual


def outline(raw: object, kind: Kind = "object", index: int = 0) -> Branch:
    """The tree of any document, without its geometry.

    What has no name gets one of its own, its lack being another mistake.
    """
    entry = raw if isinstance(raw, dict) else {}
    name = entry.get("part", entry.get("feature", entry.get("object")))
    parts = [outline(item, sort, i) for i, (_, sort, item) in enumerate(held(raw))]
    plain = name if isinstance(name, str) and name and not set(name) & set("/#") else f"unnamed {index}"
    return Branch(kind, "" if kind == "appearance" else plain, "any", parts=parts)


def path_to(raw: object, indices: Sequence[int]) -> Keys:
    """Keys from the document's root to the node that ``indices`` into ``Branch.parts`` lead to."""
    path: Keys = ()
    for index in indices:
        step, raw = _held_at(raw, index)
        path += step
    return path


def _held_at(raw: object, index: int) -> tuple[Keys, object]:
    """Of ``held`` the entry of this number, without the others."""
    rest = index
    for key in LISTS:
        items = raw.get(key) if isinstance(raw, dict) else None
        if not isinstance(items, list):
            continue
        if rest < len(items):
            return (key, rest), items[rest]
        rest -= len(items)
    raise IndexError(index)


def nodes(raw: object, path: Keys = (), kind: Kind = "object") -> Iterator[tuple[Keys, Kind, Any]]:
    """Every node of any document, from the root on."""
    yield path, kind, raw
    for step, sort, item in held(raw):
        yield from nodes(item, path + step, sort)


def misplaced(raw: object) -> list[Keys]:
    """The entries of another kind than their list, in nodes whose parts are of several kinds.

    A1 says all that is wrong with them.
    """
    rows = ((path, list(held(item))) for path, _, item in nodes(raw))
    mixed = [(path, entries) for path, entries in rows if len({kind for _, kind, _ in entries}) > 1]
    return [path + step for path, entries in mixed for step, kind, _ in entries if LISTS[str(step[0])] != kind]


def without(mistakes: Sequence[Mistake], places: Sequence[Keys]) -> list[Mistake]:
    """The mistakes that are not at or below one of the places: of those another mistake has said what is wrong."""
    prefixes = {".".join(str(step) for step in place) for place in places if place}
    lengths = {len(prefix) for prefix in prefixes}
    return [m for m in mistakes if not any(m.path[n : n + 1] in ("", ".") and m.path[:n] in prefixes for n in lengths)]


NONE = {
    "appearance": "none: appearance_types is empty",
    "feature": "none, for no object type has features yet: take these rates out until one has",
    "object": "none, for there is no object type yet",
}
"""What is known where nothing is."""
Tables = dict[tuple[str, ...], Mapping[str, object]]
"""Numbers by the name of a type, by the keys that lead to them."""


def cross_mistakes(
    kb: Document, model: KBModel | None, objects: Sequence[Document], *, complete: bool
) -> Iterator[Mistake]:
    """Types of appearances, features and objects that are declared nowhere, and types of objects declared twice.

    Where the objects are not ``complete``, some being unreadable, nobody can say which feature and object types are
    unknown.
    """
    yield from _repeated_objects(objects)
    vocabulary = kb.data.get("appearance_types") if isinstance(kb.data, dict) else None
    if isinstance(vocabulary, list):
        known = {name for name in vocabulary if isinstance(name, str)}
        for document in objects:
            yield from _unknown_appearances(document, vocabulary, known)
    if model is None:
        return
    yield from _repeated_types(kb, model)
    detector, counts = model.detector, model.counts
    clutter: Tables = {("detector", "clutter"): detector.clutter, ("counts", "clutter"): counts.clutter}
    checked_for = [("appearance", set(model.appearance_types), clutter)]
    if complete:
        features = {
            entry["type"]
            for document in objects
            for _, sort, entry in nodes(document.data)
            if sort == "feature" and isinstance(entry, dict) and isinstance(entry.get("type"), str)
        }
        hit: Tables = {("detector", "hit"): detector.hit, ("detector", "sigmas"): detector.sigmas}
        names = {name for document in objects if isinstance(name := document.data.get("object"), str)}
        priors: Tables = {("priors",): model.priors, ("counts", "prior"): counts.prior}
        checked_for += [("feature", features, {**hit, ("counts", "hit"): counts.hit}), ("object", names, priors)]
    for what, known, tables in checked_for:
        listed = f"; known: {', '.join(sorted(map(str, known))[:12]) or NONE[what]}"
        for path, given in tables.items():
            for name in given:
                if name not in known:
                    yield kb.mistake((*path, name), f"unknown {what} type {name!r}{listed}", key=True)
                    listed = ""  # it is told once


def _unknown_appearances(document: Document, vocabulary: list[Any], known: set[str]) -> Iterator[Mistake]:
    listed = ", ".join(map(str, vocabulary[:12])) or "none"
    first: dict[str, str] = {}
    for path, kind, entry in nodes(document.data):
        name = entry.get("type") if kind == "appearance" and isinstance(entry, dict) else None
        if isinstance(name, str) and name not in known:
            more = first.setdefault(name, "" if first else f"; appearance_types in kb.yaml: {listed}")
            yield document.mistake((*path, "type"), f"unknown appearance type {name!r}{more}")


def _repeated_types(kb: Document, model: KBModel) -> Iterator[Mistake]:
    before: set[str] = set()
    for index, name in enumerate(model.appearance_types):
        if name in before:
            yield kb.mistake(("appearance_types", index), f"{name!r} was listed before")
        before.add(name)


def _repeated_objects(objects: Sequence[Document]) -> Iterator[Mistake]:
    first: dict[str, str] = {}
    for document in objects:
        name = document.data.get("object")
        if isinstance(name, str) and first.setdefault(name, document.file) != document.file:
            yield document.mistake(("object",), f"{name!r} is also the object of {first[name]}")
