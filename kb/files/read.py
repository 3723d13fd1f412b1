"""Read a KB's folder, or say everything that is wrong with it.

A learned cloud becomes features of its type.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of, is_there
from kb.clouds.cloud import (
    UNKNOWN_SUPPORT,
    Counts,
    KnowledgeBase,
    ObjectType,
    Rates,
    Stand,
    clutter_prior,
    word_clutter,
)
from kb.clouds.learned import MAX_BYTES, LearnedCloud, read_cloud
from kb.clouds.lobes import Feature, LobeTable, build_tree, features_of, object_nodes, tree_mistakes
from kb.clouds.words import MAX_BYTES as MAX_WORDS
from kb.clouds.words import Words, dominant, read_words
from kb.errors import CloudError, KBErrors, Mistake, SurfaceError
from kb.files.branches import branch_of, cross_mistakes, misplaced, nodes, outline, path_to, without
from kb.files.changes import settle
from kb.files.folder import MAX_MESH_BYTES, Document, Folder, Keys
from kb.files.kept_documents import Said, said
from kb.files.kept_surfaces import kept_surface
from kb.files.quantities import LENGTHS
from kb.surfaces.surface import Surface
from kb.surfaces.symmetries import motions

if TYPE_CHECKING:
    from kb.files.schema import CountsModel, KBModel, ObjectModel

Kind = TypeVar("Kind")


def words_of(place: Folder, document: Document) -> Words | None:
    """The vocabulary that ``kb.yaml`` names; None where it names none, or with a mistake."""
    return _read(place, document, place.root, "words", MAX_WORDS, read_words)


def learned_of(place: Folder, document: Document, folder: Path) -> LearnedCloud | None:
    """The learned cloud that ``object.yaml`` names; None where it names none, or with a mistake."""
    by_hand = isinstance(document.data, dict) and any(kind != "object" for _, kind, _ in nodes(document.data))
    if by_hand and document.data.get("cloud"):
        why = "a type is learned or written by hand: with cloud there are no features, of the whole or of a part"
        place.mistakes.append(document.mistake(("cloud",), why, key=True))
    return _read(place, document, folder, "cloud", MAX_BYTES, read_cloud)


def _read(
    place: Folder, document: Document, folder: Path, key: str, limit: int, read: Callable[[bytes], Kind]
) -> Kind | None:
    path = _named(place, document, folder, (key, "file"), "file", limit)
    content = None if path is None else place.content(path, limit)
    try:
        return None if content is None else read(content)
    except CloudError as error:
        file = document.data[key]["file"]
        place.mistakes.append(document.mistake((key, "file"), f"{file!r:.100} {error}"))
        return None


def _named(place: Folder, document: Document, folder: Path, keys: Keys, what: str, limit: int) -> Path | None:
    """A file that a document names, if it may be read, sought even where the document has other mistakes."""
    value = document.data
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    if not isinstance(value, str) or not value or "\0" in value:
        return None
    fault = place.fault(folder / value, limit)
    if fault is not None:
        place.mistakes.append(document.mistake(keys, f"the {what} {value!r:.100} {fault}"))
        return None
    return folder / value


def check_learned(place: Folder, document: Document, cloud: LearnedCloud | None, words: Words | None) -> None:
    """A learned cloud needs the words that it was learned with, and names no part that the type does not have."""
    if cloud is None:
        return
    wrong = []
    if words is None:
        wrong.append("the knowledge base has no words (kb.yaml: words): learn the type again")
    elif (
        words.detector != cloud.detector
        or (cloud.words.size and not np.array_equal(cloud.words, words.digest))
        or len(words.centroids) <= max(cloud.word.max(initial=-1), cloud.lobe_word.max(initial=-1))
    ):
        wrong.append("was learned with other words than kb.yaml names: learn the type again")
    objects = sum(1 for _, kind, _ in nodes(document.data) if kind == "object")
    if cloud.part.max(initial=0) >= objects:
        wrong.append(f"knows {cloud.part.max()} parts, where there are {objects - 1}: learn the type again")
    place.mistakes += [document.mistake(("cloud",), why, key=True) for why in wrong]


def learned_features(cloud: LearnedCloud, words: Words, parts: Sequence[str] = ("",)) -> tuple[Feature, ...]:
    """Features ``f0001``, ``lid/f0001``, or ``lid/c0001/f0001`` of a compound, each of its dominant word's type.

    ``parts``: the objects of the type's tree. Their appearances are in ``learned_lobes``, as arrays.
    """
    names, still = words.names, np.eye(3)
    heads = [f"{part}/" if part else "" for part in parts]
    rows = zip(cloud.at, cloud.word, cloud.part.tolist(), cloud.compound.tolist(), strict=True)
    return tuple(
        Feature(f"{heads[part]}{f'c{group:04d}/' if group else ''}f{i:04d}", names[word], at, still, ())
        for i, (at, word, part, group) in enumerate(rows, 1)
    )


def with_compounds(
    seen: tuple[Feature, ...], cloud: LearnedCloud, words: Words
) -> tuple[tuple[Feature, ...], tuple[Feature, ...]]:
    """The maximal features, and every Feature node, of a learned cloud whose features are ``seen``.

    A compound before its parts (A1).

    A compound has the type of the word that dominates its parts' appearances, stands in their middle, and looks like
    any of them.
    """
    whole = dominant(cloud.compound[cloud.feature], cloud.lobe_word, cloud.hit, cloud.compounds + 1)
    maximal: list[Feature] = []
    every: list[Feature] = []
    order = np.argsort(cloud.compound, kind="stable")
    members = np.split(order, np.searchsorted(cloud.compound[order], np.arange(1, cloud.compounds + 1)))
    for row, group in enumerate(cloud.compound.tolist()):
        if not group:
            maximal.append(seen[row])
            every.append(seen[row])
        elif row == members[group][0]:
            its = [seen[i] for i in members[group].tolist()]
            name, middle = its[0].name.rpartition("/")[0], np.mean([part.at for part in its], axis=0)
            one = Feature(
                name, words.names[whole[group]], middle, np.eye(3), (), parts=tuple(part.name for part in its)
            )
            maximal.append(one)
            every += [one, *its]
    return tuple(maximal), tuple(every)


def learned_lobes(cloud: LearnedCloud, words: Words) -> LobeTable:
    """The lobes of a learned cloud as those of any type."""
    names = words.names
    return LobeTable(
        feature=cloud.feature.astype(np.intp),
        types=tuple(names[word] for word in cloud.lobe_word),
        at=cloud.at[cloud.feature],
        axis=cloud.axis,
        cos_half=np.cos(cloud.half_angle),
        r_min=cloud.r_min,
        r_max=cloud.r_max,
        features=len(cloud.at),
        size=cloud.size,
    )


MAX_RULES_BYTES = 200_000
"""Largest ``rules.pl``."""
HIT, PRIOR = 0.8, 0.5
"""What holds for types that ``kb.yaml`` says nothing about."""


@dataclass(frozen=True, eq=False)
class _Object:
    """One ``object.yaml``: its document, and what could be made of it."""

    document: Document
    model: "ObjectModel | None"
    surface: Surface | None
    rendered: Path | None
    scale: float
    learned: LearnedCloud | None


TRIES = 20
"""Of a knowledge base that changes while it is read."""


def read_kb(folder: Path | str, kept: Path | None = None, rules: str | None = None) -> KnowledgeBase:
    """The knowledge base of a folder: ``kb.yaml``, ``objects/NAME/object.yaml`` with its mesh, ``rules.pl``.

    It is read as it is at one moment, whoever changes it meanwhile (``kb.files.changes``).

    ``kept``: where documents and surfaces that were read are kept from run to run. ``rules``: what is read
    instead of ``rules.pl``; empty: as though there were none.

    Raises:
        KBErrors: with every mistake of every file.
    """
    root, found = Path(folder), list[KnowledgeBase | KBErrors]()
    for _ in range(TRIES):
        settle(root)
        place = Folder(root, kept, None if rules is None else rules.encode())
        try:
            found.append(_read_kb(place))
        except KBErrors as error:
            found.append(error)
        if place.is_as_it_was():
            break
    if isinstance(found[-1], KBErrors):
        raise found[-1]
    return found[-1]


def _read_kb(place: Folder) -> KnowledgeBase:
    """The knowledge base as it is now. Raises KBErrors."""
    _check_folder(place)
    file = place.root / "kb.yaml"
    if place.content(file) is None:
        raise KBErrors(place.mistakes)
    files = _object_files(place)
    complete = not place.mistakes
    whole, said_of_objects = said(place, file, files)
    document, model, wrong = whole.document, whole.model, whole.mistakes
    objects = [item for one in said_of_objects if (item := _object(place, one)) is not None]
    rules, words = _rules(place), words_of(place, document)
    for item in objects:
        check_learned(place, item.document, item.learned, words)
    wrong += cross_mistakes(
        document, model, [item.document for item in objects], complete=complete and len(objects) == len(files)
    )
    mistakes = list(dict.fromkeys(place.mistakes + wrong))
    if mistakes or model is None:
        cautions = (  # they would come to light only after the mistakes are mended
            item.document.mistake(("mesh", "file"), f"warning: {item.surface.caution}")
            for item in objects
            if item.surface is not None and item.surface.caution
        )
        raise KBErrors([*mistakes, *cautions])
    types = tuple(_type(item.model, item, words) for item in objects if item.model is not None)
    return _knowledge_base(place, model, types, rules, words)


def _check_folder(place: Folder) -> None:
    root = place.root
    if not is_there(place.at(root / "kb.yaml")):
        what = {IS_FOLDER: "the folder holds no kb.yaml", IS_MISSING: "there is no such folder"}
        fault = fault_of(root) or "is a file, not a folder"
        why = f"{what.get(fault, fault)}; a knowledge base is a folder with a kb.yaml in it"
        raise KBErrors([Mistake(str(root), 0, 0, "", why)])


def _object_files(place: Folder) -> list[Path]:
    """One file per folder of ``objects``, hidden ones excepted."""
    folder = place.root / "objects"
    if not is_there(place.at(folder)):
        return []
    inside = place.listed(folder) if fault_of(place.at(folder)) == IS_FOLDER else [folder]
    lost = [
        path for path in inside if path == folder or (path.is_symlink() and fault_of(path) not in (IS_FOLDER, None))
    ]
    place.mistakes += [
        Mistake(place.name(path), 0, 0, "", f"must be a folder, but it {fault_of(path) or 'is a file'}")
        for path in lost
    ]
    there = [path for path in inside if fault_of(place.at(path)) == IS_FOLDER]
    return [path / "object.yaml" for path in there if not path.name.startswith(".")]


def _object(place: Folder, told: "Said[ObjectModel]") -> _Object | None:
    document, model = told.document, told.model
    place.mistakes.extend(without(told.mistakes, misplaced(document.data)))
    if not isinstance(document.data, dict):
        return None
    wrong = [
        document.mistake(path_to(document.data, where), why) for where, why in tree_mistakes(outline(document.data))
    ]
    try:
        motions(model.symmetries if model is not None else ())
    except ValueError as error:
        wrong.append(document.mistake(("symmetries",), str(error)))
    mesh = document.data.get("mesh")
    if model is not None and model.stands and mesh is None:
        why = "a type without a mesh stands on nothing: add mesh, or leave stands out"
        wrong.append(document.mistake(("stands",), why, key=True))
    place.mistakes += wrong
    units = mesh.get("units") if isinstance(mesh, dict) else None
    scale = LENGTHS.get(units, 1.0) if isinstance(units, str) else 1.0
    folder = (place.root / document.file).parent
    mesh_file, surface = _surface(place, document, folder, scale)
    rendered = _textured(place, document, folder) or mesh_file
    return _Object(document, model, surface, rendered, scale, learned_of(place, document, folder))


def _surface(place: Folder, document: Document, folder: Path, scale: float) -> tuple[Path | None, Surface | None]:
    path = _named(place, document, folder, ("mesh", "file"), "mesh", MAX_MESH_BYTES)
    content = place.content(path, MAX_MESH_BYTES) if path is not None else None
    if path is not None and content is not None:
        place.read_sides(path, content)
        try:
            return place.at(path), kept_surface(place.at(path), content, scale, place.kept and place.kept / "surfaces")
        except SurfaceError as error:
            place.mistakes.append(document.mistake(("mesh", "file"), str(error)))
    return None, None


def _textured(place: Folder, document: Document, folder: Path) -> Path | None:
    """The mesh that is rendered."""
    path = _named(place, document, folder, ("mesh", "textured"), "mesh", MAX_MESH_BYTES)
    content = place.content(path, MAX_MESH_BYTES) if path is not None else None
    if path is not None and content is not None:
        place.read_sides(path, content)
    return path


def _rules(place: Folder) -> str:
    path, content = place.root / "rules.pl", place.rules
    if content:
        place.contents["rules.pl"] = content
    elif content is None and is_there(place.at(path)):
        content = place.content(path, MAX_RULES_BYTES)
    try:
        return (content or b"").decode()
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        place.mistakes.append(Mistake("rules.pl", line, 1, "", f"must be UTF-8: {error.reason}"))
        return ""


def _type(model: "ObjectModel", item: _Object, words: Words | None) -> ObjectType:
    tree = build_tree(branch_of(model))
    features, all_features = features_of(tree)
    seen = features
    lobes = None
    if item.learned is not None and words is not None:
        seen = learned_features(item.learned, words, object_nodes(tree))
        features, all_features = with_compounds(seen, item.learned, words)
        lobes = learned_lobes(item.learned, words)
    return ObjectType(
        name=model.object,
        tree=tree,
        features=features,
        all_features=all_features,
        surface=item.surface,
        opaque=model.opaque,
        symmetries=motions(model.symmetries),
        mesh_file=item.rendered,
        mesh_scale=item.scale,
        learned=item.learned,
        learned_lobes=lobes,
        learned_features=seen if item.learned is not None else None,
        stands=None if model.stands is None else tuple(Stand(tuple(one.down), one.weight) for one in model.stands),
    )


def _knowledge_base(
    place: Folder, model: "KBModel", types: tuple[ObjectType, ...], rules: str, words: Words | None
) -> KnowledgeBase:
    named, gravity = words.names if words is not None else (), model.gravity
    return KnowledgeBase(
        name=model.name,
        types=types,
        appearance_types=(*model.appearance_types, *named),
        rates=_rates(model, types, named),
        f_ref=model.f_ref,
        rules=rules,
        digest=place.digest(),
        folder=place.root,
        words=words,
        gravity=gravity is not None and gravity.certain,
        maybe=gravity is not None and not gravity.certain,
        unknown_support=UNKNOWN_SUPPORT if gravity is None else gravity.floats,
        ground=None if gravity is None else gravity.ground,
    )


def _rates(model: "KBModel", types: tuple[ObjectType, ...], words: tuple[str, ...]) -> Rates:
    detector = model.detector
    kinds = sorted({feature.type for kind in types for feature in kind.all_features})
    return Rates(
        hit={name: detector.hit.get(name, HIT) for name in kinds},
        clutter=clutter_prior(types, model.appearance_types) | word_clutter(types, words) | dict(detector.clutter),
        prior={kind.name: model.priors.get(kind.name, PRIOR) for kind in types},
        sigma=detector.sigma,
        sigmas=dict(detector.sigmas),
        match_tolerance=detector.match_tolerance,
        sigma_angle=detector.sigma_angle,
        counts=_counts(model.counts),
    )


def _counts(model: "CountsModel") -> Counts:
    tables = (
        {name: (pair[0], pair[1]) for name, pair in table.items()} for table in (model.hit, model.clutter, model.prior)
    )
    return Counts(*tables)
