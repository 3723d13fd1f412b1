"""``plogic kb learn``: features of types from their textured meshes, and the symmetries that a texture keeps."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud, cloud_bytes
from kb.clouds.words import Words, words_bytes
from kb.files.changes import Writer
from kb.files.yaml_text import load
from kb.learning.compounds import with_parts
from kb.learning.symmetry_trials import Trial, entries
from kb.shown.cautions import UNPAINTED
from plogic.base.errors import InputError
from plogic.face.authoring.kb_learn_all import WORK, learned, no_print
from plogic.face.authoring.kb_learn_words import words_of
from plogic.face.authoring.kb_types import changing, type_folders, with_entry
from plogic.face.shown.options import Learning
from plogic.face.shown.progress import Work
from plogic.face.shown.tables import plain_table
from sensing.errors import SensingError
from sensing.simulated.body import read_mesh
from sensing.simulated.stage import MAX_TRIANGLES

BY_HAND = "its features were written by hand; learning would replace them: take them out of object.yaml first"

NOTHING_NEW = (
    "nothing to learn: every type that can be learned has features already; name those that are to be learned again"
)
WORDED = 30.0
"""What it takes to find the words of all types, in views: 5 s, where a view takes 0.17 s."""
NAMED = 20
"""Names that a line lists."""


def learn_command(kb_folder: str, names: Sequence[str], options: Learning, *, say: Callable[[str], None]) -> str:
    """Learn the types that are named, or all that have a texture and no features; what cannot be learned is left out.

    Raises:
        InputError: a name is no type's, or nothing can be learned and no type is there that has features.
    """
    with changing(kb_folder) as (kb, writer):
        return _learn(kb_folder, kb, names, options, writer, say)


def _learn(
    kb_folder: str,
    kb: KnowledgeBase,
    names: Sequence[str],
    options: Learning,
    writer: Writer,
    say: Callable[[str], None],
) -> str:
    """As ``learn_command``, of a knowledge base that nobody else changes."""
    folder = writer.root
    chosen, left_out = _chosen(kb, names)
    check_detector(kb_folder, kb, options.detector, [kind.name for kind in chosen])
    rows, clouds = [], {kind.name: kind.learned for kind in kb.types if kind.learned is not None}
    files, found = {name: place / "object.yaml" for name, place in type_folders(folder).items()}, {}
    with Work(WORK * len(chosen) + WORDED, say) as work:
        open_ = {kind.name for kind in chosen if not stated(files[kind.name])}
        known = learned(chosen, open_, kb, options, work)
        for kind in chosen:
            cloud, tried = known[kind.name]
            if cloud is None:
                left_out[kind.name] = no_print(options.detector)
                continue
            clouds[kind.name] = with_parts(kind, cloud)
            if tried is not None:
                found[files[kind.name]] = tried
            rows.append(row_of(kind.name, clouds[kind.name]))
            rows[-1]["symmetries"] = None if tried is None else symmetry_rows(tried)
        if rows:
            work.at("words of all types")
            words, clouds = words_of(clouds, options.seed)
    _tell_left_out(left_out, nothing=not rows and (bool(names) or not any(kind.features for kind in kb.types)), say=say)
    if rows:
        writer.change(written(files_of(folder, words, clouds), found))
        count = len(words.centroids)
    else:
        count = 0 if kb.words is None else len(kb.words.centroids)
    if options.as_json:
        missed = [{"type": name, "why": why} for name, why in left_out.items()]
        return json.dumps({"format": "kb_learn/1", "kb": kb.name, "words": count, "types": rows, "left_out": missed})
    return _text(f"learned into {kb_folder}: {count} words in all", rows) if rows else NOTHING_NEW


def _tell_left_out(why: Mapping[str, str], *, nothing: bool, say: Callable[[str], None]) -> None:
    """Say which types were left out, a line a reason. Raises InputError with it where ``nothing`` else was done."""
    together: dict[str, list[str]] = {}
    for name, reason in why.items():
        together.setdefault(reason, []).append(name)
    lines = [(_few(those), reason) for reason, those in together.items()]
    if nothing and lines:
        raise InputError("\n".join(f"{those}: {reason}" for those, reason in lines))
    for those, reason in lines:
        say(f"{those}: left out: {reason}")


def _text(title: str, rows: list[dict[str, Any]]) -> str:
    """For people: a table of the types, and a line on each symmetry that holds or may hold."""
    table = plain_table(title, [{name: value for name, value in row.items() if name != "symmetries"} for row in rows])
    return "\n".join(
        [table.rstrip("\n"), *(line for row in rows for line in symmetry_lines(row["type"], row["symmetries"]))]
    )


def _chosen(kb: KnowledgeBase, names: Sequence[str]) -> tuple[list[ObjectType], dict[str, str]]:
    """The types to learn, each once, and why each of the others that were asked for cannot be.

    Raises:
        InputError: a name is no type's; with what else is wrong, so that everything is told at once.
    """
    known = {kind.name: kind for kind in kb.types}
    names = list(dict.fromkeys(names))
    if not known and not names:
        raise InputError("there is no object type yet: plogic kb add NAME --mesh FILE --units m|cm|mm --kb KB")
    some = (
        [known[name] for name in names if name in known] if names else [kind for kind in kb.types if not kind.features]
    )
    left_out = {kind.name: why for kind in some if (why := _fault(kind)) is not None}
    lost = [name for name in names if name not in known]
    if lost:
        there = f"{_few(lost)}: no such object type; there are: {_few(list(known)) or 'none (plogic kb add)'}"
        raise InputError("\n".join([there, *(f"{name}: {why}" for name, why in left_out.items())]))
    return [kind for kind in some if kind.name not in left_out], left_out


def _few(names: Sequence[str]) -> str:
    """The first names of many."""
    return ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")


def _fault(kind: ObjectType) -> str | None:
    """Why a type cannot be learned."""
    if kind.features and kind.learned is None:
        return BY_HAND
    if kind.mesh_file is None:
        return "has no mesh to render"
    try:
        mesh = read_mesh(kind.mesh_file, kind.mesh_scale)
    except SensingError as error:
        return str(error)
    if mesh.texture is None:
        return UNPAINTED
    if len(mesh.triangles) > MAX_TRIANGLES:
        what = f"{kind.mesh_file.name} has {len(mesh.triangles)} triangles, more than the {MAX_TRIANGLES} that can be rendered"
        return f"{what}: simplify the mesh with its texture kept (as Blender's Decimate does), and put it in place of the one that is there"
    return None


def check_detector(kb_folder: str, kb: KnowledgeBase, detector: str, fresh: Iterable[str]) -> None:
    """Raise InputError where clouds that stay, of types that are not ``fresh``, were learned with another detector."""
    mixed = sorted(
        {detector, *(kind.learned.detector for kind in kb.types if kind.learned is not None and kind.name not in fresh)}
    )
    if len(mixed) > 1:
        raise InputError(
            f"{kb_folder}: clouds of {' and '.join(mixed)} cannot share one vocabulary: learn all types with one detector"
        )


def row_of(name: str, cloud: LearnedCloud) -> dict[str, Any]:
    """What is printed of a type that was learned."""
    return {
        "type": name,
        "features": len(cloud.at),
        "compounds": cloud.compounds,
        "appearances": len(cloud.feature),
        "hit rate": round(float(np.median(cloud.hit)), 3),
        "σ mm": round(1000.0 * float(np.median(cloud.sigma)), 2),
    }


def files_of(
    folder: Path, words: Words, clouds: Mapping[str, LearnedCloud], new: Mapping[Path, bytes] | None = None
) -> dict[Path, bytes]:
    """All that is written into a KB's folder.

    Words, every cloud (its words are new), and the lines that name them, where none does yet. ``new``: files of types
    that are written with them, which come with the rest.

    Raises:
        InputError: two types name one file for their clouds, or a YAML file is written so that no line can be added.
    """
    new, digest = dict(new or {}), words.digest
    files = new | _named(folder / "kb.yaml", "words", words_bytes(words), new)
    taken = {path.resolve() for path in files}
    fresh = {path.parent.name: path.parent for path in new if path.name == "object.yaml"}
    for name, place in (type_folders(folder) | fresh).items():
        if name in clouds:
            content = cloud_bytes(replace(clouds[name], words=digest))
            own = _named(place / "object.yaml", "cloud", content, new)
            shared = [path for path in own if path not in new and path.resolve() in taken]
            if shared:
                raise InputError(
                    f"{place / 'object.yaml'}: names {shared[0]} for its cloud, which another file names too: give it one of its own"
                )
            taken |= {path.resolve() for path in own}
            files |= own
    return files


def _named(file: Path, key: str, data: bytes, new: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """The data under the name that a YAML file gives them.

    Where it gives none, under the usual one, and the file with a line that does.
    """
    content = new[file] if file in new else file.read_bytes()
    entry = load(str(file), content).data.get(key)
    if entry:
        return {file.parent / entry["file"]: data}
    return {file.parent / f"{key}.npz": data, file: with_entry(file, content, key, {"file": f"{key}.npz"})}


KEPT = "symmetries: as object.yaml states them"


def stated(file: Path) -> bool:
    """Whether an object.yaml says what the symmetries are, be it that there are none."""
    data = load(str(file), file.read_bytes()).data
    return isinstance(data, dict) and "symmetries" in data


def written(files: dict[Path, bytes], found: Mapping[Path, Sequence[Trial]]) -> dict[Path, bytes]:
    """The files of a KB with the symmetries that hold in each ``object.yaml`` of ``found``.

    Raises:
        InputError: a YAML file is written so that no line can be added; with what to write into it.
    """
    more = {}
    for file, tried in found.items():
        listed = entries(tried)
        if listed:
            content = files[file] if file in files else file.read_bytes()
            more[file] = with_entry(file, content, "symmetries", listed)
    return files | more


def symmetry_rows(tried: Sequence[Trial]) -> list[dict[str, Any]]:
    """For programs: ``share`` and ``control`` of the cloud alone, ``ratio`` of new pictures turned and unturned."""
    return [
        {
            "turn": str(trial.turn),
            "verdict": trial.verdict,
            "share": round(trial.share, 3),
            "control": round(trial.control, 3),
            "ratio": None if trial.ratio is None else round(trial.ratio, 3),
        }
        for trial in tried
    ]


def symmetry_lines(name: str, rows: Sequence[Mapping[str, Any]] | None) -> list[str]:
    """For people, a line a turn; None where object.yaml states the symmetries."""
    if rows is None:
        return [f"{name}: {KEPT}"]
    if all(row["verdict"] == "broken" for row in rows):
        turns = "the one turn" if len(rows) == 1 else f"all {len(rows)} turns"
        return [f"{name}: symmetries: none; its texture breaks {turns} of its shape"] if rows else []
    return [f"{name}: {_line(row)}" for row in rows if row["verdict"] != "broken"]


def _line(row: Mapping[str, Any]) -> str:
    shown = f"turned by it, new pictures show {row['ratio']:.0%} of what they show unturned"
    if row["verdict"] == "holds":
        return f"symmetry {row['turn']}: {shown}; written into object.yaml"
    return f"perhaps a symmetry, not written: {row['turn']}: {shown}"
