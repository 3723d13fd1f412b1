"""``plogic kb new``, ``add`` and ``import``.

New knowledge bases, and new types in their folders, each whole or not at all.
"""

import json
import os.path
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import Any

import numpy as np
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from geometry.files.plain_files import IS_FOLDER, IS_MISSING, fault_of, is_there
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.files.changes import AT_ONCE, Writer, writing
from kb.files.folder import MAX_BYTES
from kb.files.write import obj_text, object_text
from kb.files.yaml_text import load
from kb.intake.bop_models import bop_models, bop_symmetries
from kb.intake.example_type import example_files
from kb.intake.new_type import EDITOR_LINE, NewType, check_name, new_kb_files, new_type, schema_files
from kb.intake.robots import frozen_joints, merged, sdf_visuals, urdf_visuals
from kb.intake.source import read_source
from kb.shown.seen_from import FIXING_A_POSE
from plogic.base.errors import InputError
from plogic.run.sources import kb_of
from plogic.sequence.constancy.panorama_reading import unknown_of
from plogic.sequence.constancy.result import SeenFeature, draft_type
from sensing.errors import SensingError
from sensing.files.whole_files import write_folder

PATIENCE = 10.0
"""Seconds that a command which takes few waits for another that is changing the same knowledge base."""


def is_new(folder: Path) -> bool:
    """Whether there is nothing yet, so that a knowledge base is to be made first.

    Raises InputError where what is there is none.
    """
    if is_there(folder) and fault_of(folder / "kb.yaml") is not None:
        raise InputError(f"{folder}: holds no kb.yaml; make a knowledge base with: plogic kb new {quote(str(folder))}")
    return not is_there(folder)


def check_own(kb_folder: str) -> Path:
    """The folder of a KB that is there to be changed. Raises InputError for one that is shipped with plogic."""
    folder = Path(kb_folder)
    if not is_there(folder / "kb.yaml"):
        raise InputError(f"{kb_folder}: is shipped with plogic: copy its folder, and change the copy")
    return folder


@contextmanager
def changing(kb_folder: str, patience: float = AT_ONCE) -> Iterator[tuple[KnowledgeBase, Writer]]:
    """A knowledge base that nobody else changes meanwhile, and who may.

    Raises:
        KBError: It cannot be read, or another process is changing it. InputError: It is shipped with plogic.
    """
    if not is_there(Path(kb_folder) / "kb.yaml"):
        kb_of(kb_folder)
    with writing(check_own(kb_folder), patience) as writer:
        yield kb_of(kb_folder), writer


def check_places(folder: Path, names: Sequence[str]) -> None:
    """Raise InputError for all the names that are types of the KB already, before the work is done."""
    there = type_folders(folder)
    taken = [place for name in names if is_there(place := there.get(name, folder / "objects" / name))]
    if taken:
        raise InputError(
            "\n".join(f"{place}: exists already; remove it first, or choose another name" for place in taken)
        )


def type_folders(folder: Path) -> dict[str, Path]:
    """Where each type of a KB's folder is described, by the name that its object.yaml states.

    What cannot be read is left out.
    """
    found: dict[str, Path] = {}
    if fault_of(folder / "objects") != IS_FOLDER:
        return found
    for file in sorted((folder / "objects").glob("[!.]*/object.yaml")):
        data = load(file.name, file.read_bytes()).data if fault_of(file, MAX_BYTES) is None else None
        name = data.get("object") if isinstance(data, dict) else None
        if isinstance(name, str):
            found[name] = file.parent
    return found


def files_in(folder: Path, types: Sequence[NewType]) -> dict[Path, bytes]:
    """All that is written of new types into a knowledge base's folder: theirs, and the schema of their editor lines."""
    files = {folder / "objects" / kind.name / name: data for kind in types for name, data in kind.files.items()}
    return files | {folder / "object.schema.json": schema_files()["object.schema.json"]}


def write_types(folder: Path, types: Sequence[NewType]) -> bool:
    """Write types, all or none, into a knowledge base; whether it was made for them.

    Raises IntakeError, InputError where a type of a name is there meanwhile, KBError, SensingError.
    """
    if is_new(folder):
        try:
            _make(folder, new_kb_files(_name_of(folder)), types)
        except SensingError:
            if is_new(folder):  # else another process has made it meanwhile
                raise
        else:
            return True
    with writing(folder, PATIENCE) as writer:
        check_places(folder, [kind.name for kind in types])
        writer.change(files_in(folder, types))
    return False


def _make(folder: Path, files: Mapping[str, bytes], types: Sequence[NewType] = ()) -> None:
    """Write a new knowledge base, whole or not at all."""
    more = {str(path): data for path, data in files_in(Path(), types).items()} if types else {}
    write_folder(folder, {**files, **more}, empty=["objects"])


def _name_of(folder: Path) -> str:
    return Path(os.path.realpath(folder)).name


def told(folder: Path, types: Sequence[NewType], what: str, *, new: bool, as_json: bool) -> str:
    """What was done, as text, or as one ``kb_add/1`` or ``kb_import/1`` document; ``new``.

    The knowledge base was made too.
    """
    if as_json:
        documents: list[dict[str, Any]] = [kind.document | {"notes": list(kind.notes)} for kind in types]
        return json.dumps({"format": f"{what}/1", "kb": str(folder), "new_kb": new, "types": documents})
    noted = [(kind, note) for kind in types for note in kind.notes]
    lines = [f"note: {note}" if len(types) == 1 else f"note: {kind.name}: {note}" for kind, note in noted]
    lines += [line for kind in types for line in kind.lines]
    lines += [f"made a new knowledge base: {folder}"] if new else []
    wrote = ", ".join(str(folder / "objects" / kind.name) for kind in types[:3]) + (
        f" and {len(types) - 3} more" if len(types) > 3 else ""
    )
    return "\n".join([*lines, f"wrote {wrote}"])


def new_command(folder: Path, name: str | None, *, example: bool = False) -> str:
    """Write a new knowledge base, whole or not at all, and never over anything. Raises IntakeError, SensingError.

    ``example``: with a type written by hand.
    """
    name = name or _name_of(folder)
    if example:
        _make(folder, example_files(name))
        return (
            f"wrote {folder}: kb.yaml, rules.pl, their schemas, and objects/box: object.yaml, mesh.obj\n"
            f"next: plogic kb check {quote(str(folder))}; plogic simulate --kb {quote(str(folder))} --gamma -o scene"
        )
    _make(folder, new_kb_files(name))
    return (
        f"wrote {folder}: kb.yaml, rules.pl, their schemas and objects/\n"
        f"next: plogic kb add NAME --mesh FILE --units m|cm|mm --kb {quote(str(folder))}\n"
        f"or write {folder}/objects/NAME/object.yaml by hand, as plogic kb new FOLDER --example has one"
    )


def add_command(name: str, mesh: Path, units: str | None, folder: Path, *, as_json: bool) -> str:
    """Make a type from a mesh file; the text says what was done.

    Where there is no such folder, a new knowledge base is made first.

    Raises IntakeError, InputError, SensingError.
    """
    is_new(folder)
    check_name(name)
    check_places(folder, [name])
    new = new_type(name, read_source(mesh), units, mesh)
    made = write_types(folder, [new])
    return told(folder, [new], "kb_add", new=made, as_json=as_json)


def import_command(source: Path, folder: Path, units: str | None, *, as_json: bool) -> str:
    """Make types from a URDF, an SDF, or a BOP models folder; all are made before the first is written.

    Where there is no such KB folder, a new knowledge base is made first.

    Raises:
        IntakeError: a file that no type can be made of. InputError: no such file, a folder that is no KB, a type that
        exists. SensingError.
    """
    is_new(folder)
    fault = fault_of(source)
    if fault not in (None, IS_FOLDER):
        raise InputError(f"{source}: {'there is no such file or folder' if fault == IS_MISSING else fault}")
    types = _of_bop(source, folder, units) if fault == IS_FOLDER else [_of_robot(source, folder, units)]
    made = write_types(folder, types)
    return told(folder, types, "kb_import", new=made, as_json=as_json)


def _of_robot(path: Path, folder: Path, units: str | None) -> NewType:
    """One type of one description, its meshes merged in the zero pose. URDF and SDF are in metres."""
    readers = {".urdf": urdf_visuals, ".sdf": sdf_visuals, ".world": sdf_visuals}
    reader = readers.get(path.suffix.lower())
    if reader is None and path.suffix.lower() == ".xacro":
        to = path.with_suffix("" if path.with_suffix("").suffix else ".urdf")
        command = f"xacro {quote(str(path))} > {quote(str(to))}"
        raise InputError(
            f"{path}: is a template of a description: run xacro first, and import what it writes: {command}"
        )
    if reader is None:
        raise InputError(
            f"{path}: is neither a .urdf nor an .sdf, nor a BOP models folder; a mesh comes with: plogic kb add NAME --mesh {quote(str(path))}"
        )
    stem = path.resolve().parent.name if path.stem == "model" else path.stem  # Gazebo's: NAME/model.sdf
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", stem).lstrip(".-") or "robot"
    check_places(folder, [name])
    source = merged(path, reader(path))
    return new_type(name, replace(source, notes=(*frozen_joints(path), *source.notes)), units or "m", path)


def _of_bop(models: Path, folder: Path, units: str | None) -> list[NewType]:

    unit = units or "mm"
    rows = bop_models(models)
    check_places(folder, [name for name, _, _ in rows])
    known = [bop_symmetries(entry, unit, f"{models / 'models_info.json'}: {name}") for name, _, entry in rows]
    return [
        new_type(name, read_source(path), unit, path, turns) for (name, path, _), turns in zip(rows, known, strict=True)
    ]


def with_entry(file: Path, content: bytes, key: str, value: Mapping[str, str] | Sequence[Mapping[str, Any]]) -> bytes:
    """The content of a file that was read as a mapping, with ``value`` under ``key``.

    In the place of what is there, or at the end.

    A list of mappings is written in one line, as a mapping is.

    Raises:
        InputError: it is written in a form that cannot be changed so, such as an anchor or a flow; with what to write
        into it.
    """
    document = load(str(file), content)
    if document.data.get(key) == value:
        return content
    text = content.decode("utf-8-sig")
    entry = _flow(value) if isinstance(value, Mapping) else "[" + ", ".join(_flow(item) for item in value) + "]"
    node = next((item for name, item in getattr(document.root, "value", ()) if name.value == key), None)
    changed = (f"{text.rstrip()}\n{key}: {entry}\n" if node is None else _replaced(text, node, entry)).encode()
    again = load(str(file), changed)
    if again.mistakes or again.data != document.data | {
        key: dict(value) if isinstance(value, Mapping) else [dict(item) for item in value]
    }:
        raise InputError(
            f"{file}: cannot be changed as it is written: write this into it, and try again: {key}: {entry}"
        )
    return changed


def _flow(value: Mapping[str, Any]) -> str:
    return "{" + ", ".join(f"{name}: {json.dumps(item, ensure_ascii=False)}" for name, item in value.items()) + "}"


def _replaced(text: str, node: Node, entry: str) -> str:
    """The text with an entry in the place of a node; the comments that follow it stay."""
    start, end = node.start_mark, _last(node).end_mark
    lines = [*text.splitlines(keepends=True), ""]
    before = "".join(lines[: start.line]) + lines[start.line][: start.column]
    after = "".join([lines[end.line][end.column :], *lines[end.line + 1 :]])
    gap = "" if before.endswith((" ", "\n")) else " "
    return before + gap + entry + ("\n" if end.column == 0 else "") + after


def _last(node: Node) -> Node:
    """The node that a node's text ends with.

    In block style a parent ends where the next key begins, comments included.
    """
    while isinstance(node, MappingNode | SequenceNode) and node.value and not node.flow_style:
        node = node.value[-1][1] if isinstance(node, MappingNode) else node.value[-1]
    return node


def assimilate_command(panorama: str, unknown: str, kb_folder: str, name: str, *, as_json: bool) -> str:
    """Write the type's folder, whole or not at all, and never over another.

    The text says what the draft has and what it has not.

    Raises InputError, IntakeError, KBError, SensingError.
    """
    with changing(kb_folder, PATIENCE) as (kb, writer):
        folder = writer.root
        check_name(name)
        check_places(folder, [name])
        features = unknown_of(panorama, unknown)
        _check_features(features, kb, panorama, unknown)
        new = draft_files(name, features, kb, f"{unknown} of {panorama}")
        writer.change(files_in(folder, [new]))
    where = folder / "objects" / name
    if as_json:
        return json.dumps(
            {"format": "kb_assimilate/1", "kb": str(folder), "type": new.document | {"notes": list(new.notes)}}
        )
    return "\n".join([*new.lines, *(f"  note: {note}" for note in new.notes), f"wrote {where}"])


def _check_features(features: Sequence[SeenFeature], kb: KnowledgeBase, panorama: str, unknown: str) -> None:
    """Raise InputError where no pose could be taken from the draft, or the KB has not its appearance types."""
    if len(features) < FIXING_A_POSE:
        raise InputError(
            f"{panorama}: {unknown} has {len(features)} features, and a pose is taken from {FIXING_A_POSE}: look at it again from elsewhere"
        )
    strange = sorted({feature.type for feature in features} - set(kb.appearance_types))
    if strange:
        raise InputError(
            f"{panorama}: {', '.join(strange)[:200]}: no appearance types of {kb.name}; add them to kb.yaml"
        )


def draft_files(name: str, features: Sequence[SeenFeature], kb: KnowledgeBase, origin: str) -> NewType:
    """The draft's files, and what is told of it."""
    kind = draft_type(name, features, kb.f_ref)
    comment = "".join(sign if " " <= sign <= "~" else "?" for sign in origin)
    lines = [f"# A draft, made from {comment[:200]}: features where they were seen, lobes from where they were."]
    lines += (
        ["# The body is the convex hull of the features, made smaller until it hides nothing that was seen."]
        if kind.surface
        else []
    )
    text = EDITOR_LINE + "\n".join(lines) + "\n" + object_text(kind, "mesh.obj" if kind.surface else None)
    files = {"object.yaml": text.encode()} | ({"mesh.obj": obj_text(kind.surface).encode()} if kind.surface else {})
    document = _document(kind)
    return NewType(name, files, document, tuple(_lines(document)), tuple(_notes(document)))


def _document(kind: ObjectType) -> dict[str, Any]:

    at = np.array([feature.at for feature in kind.features])
    types = sorted({feature.type for feature in kind.features})
    return {
        "type": kind.name,
        "features": len(kind.features),
        "feature_types": {name: sum(feature.type == name for feature in kind.features) for name in types},
        "extent_m": np.ptp(at, axis=0).tolist(),
        "mesh": "hull" if kind.surface is not None else None,
        "opaque": kind.opaque,
    }


def _lines(document: dict[str, Any]) -> list[str]:
    sides = " x ".join(f"{side:.4g}" for side in document["extent_m"])
    counts = ", ".join(f"{count} {name}" for name, count in document["feature_types"].items())
    return [f"{document['type']}: a draft of {document['features']} features, {sides} m", f"  {counts}"]


def _notes(document: dict[str, Any]) -> list[str]:
    body = "the mesh is a hull of the features: a draft; replace it with the real one" if document["mesh"] else NO_BODY
    return [body, "it has features only where it was looked at; symmetries and parts are for you to say"]


NO_BODY = "there is no mesh, so that it hides nothing and may share space with others: its features span no volume that leaves all seen that was"
