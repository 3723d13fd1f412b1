"""``plogic kb learn``: object types from their textured meshes, by rendering them and looking with the detectors of run time."""

from __future__ import annotations

import hashlib
import json
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plogic.commands.sources import kb_of
from plogic.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kb.cloud import KnowledgeBase, ObjectType
    from kb.learning.observations import Observations
    from kb.learnt import LearntCloud

    Keep = Callable[[Observations], Observations]

CHUNK = 10
"""Directions that a process renders at a time."""
RECIPE = 1
"""Changes whenever learning does: clouds that were remembered are then learnt anew."""
MESH_AND_PAINT = {".obj", ".mtl", ".png", ".jpg", ".jpeg", ".glb", ".ply"}
"""Files beside a mesh on which its cloud depends."""


def learn_command(kb_folder: str, names: Sequence[str], options: dict[str, Any], *, say: Callable[[str], None]) -> str:
    """Learn the types that are named, or all that have a texture and no features; ``options``: detector, jobs, seed, as_json."""
    from kb.learning.words import worded
    from sensing.whole_files import write_files

    kb = kb_of(kb_folder)
    chosen = _chosen(kb, names)
    rows, clouds = [], {kind.name: kind.learnt for kind in kb.types if kind.learnt is not None}
    mixed = sorted({options["detector"], *(cloud.detector for name, cloud in clouds.items() if name not in {kind.name for kind in chosen})})
    if len(mixed) > 1:
        raise InputError(f"{kb_folder}: clouds of {' and '.join(mixed)} cannot share one vocabulary: learn all types with one detector")
    for kind in chosen:
        clouds[kind.name] = learnt_of(kind, kb, options, say)
        rows.append(row_of(kind.name, clouds[kind.name]))
    words, clouds = worded(clouds, options["seed"])
    write_files(files_of(kb, words, clouds, {kind.name for kind in chosen}))
    if options["as_json"]:
        return json.dumps({"format": "kb_learn/1", "kb": kb.name, "words": len(words.centroids), "types": rows})
    from plogic.commands.printing import plain_table

    return plain_table(f"learnt into {kb_folder}: {len(words.centroids)} words in all", rows)


def _chosen(kb: KnowledgeBase, names: Sequence[str]) -> list[ObjectType]:
    """The types to learn; everything that is wrong with them is told at once."""
    if kb.folder is None:
        raise InputError(f"{kb.name}: has no folder to write to")
    known = {kind.name: kind for kind in kb.types}
    wrong = [f"{name}: no such object type; there are: {', '.join(known) or 'none (plogic kb add)'}" for name in names if name not in known]
    some = [known[name] for name in names if name in known] or [kind for kind in kb.types if not kind.features]
    wrong += [fault for kind in some if (fault := _fault(kind)) is not None]
    if wrong:
        raise InputError("\n".join(wrong))
    if not some:
        raise InputError("every type has features already; name those that are to be learnt again")
    return some


def _fault(kind: ObjectType) -> str | None:
    """Why a type cannot be learnt."""
    if kind.features and kind.learnt is None:
        return f"{kind.name}: its features were written by hand; learning would replace them: take them out of object.yaml first"
    if kind.mesh_file is None:
        return f"{kind.name}: has no mesh to render"
    from sensing.simulated.meshes import read_mesh

    if read_mesh(kind.mesh_file, kind.mesh_scale).texture is None:
        instead = "junctions, patches, markers and colour blobs can be written by hand"
        return f"{kind.name}: its mesh has no texture, so keypoints see nothing of it; {instead}"
    return None


def learnt_of(
    kind: ObjectType, kb: KnowledgeBase, options: dict[str, Any], say: Callable[[str], None], keep: Keep | None = None
) -> LearntCloud:
    """From the cache, or learnt and put there; ``keep`` chooses among what is seen (``options["seed"]`` and the files say all that it does)."""
    from kb.errors import CloudError
    from kb.learnt import cloud_bytes, read_cloud
    from sensing.errors import SensingError
    from sensing.whole_files import write_whole

    place = _cache() / f"{_key(kind, kb, options)}.npz"
    try:
        remembered = read_cloud(place.read_bytes())
    except (OSError, CloudError):
        cloud = _rendered(kind, kb, options, say, keep)
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            write_whole(place, cloud_bytes(cloud))
        except (OSError, SensingError) as error:
            say(f"{kind.name}: is not remembered for the next time: {error}")
        return cloud
    say(f"{kind.name}: was learnt before ({place})")
    return remembered


def _cache() -> Path:
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "plogic" / "clouds"


def _key(kind: ObjectType, kb: KnowledgeBase, options: dict[str, Any]) -> str:
    """SHA-256 over all that a cloud depends on: the mesh, its paint, and how it is learnt."""
    assert kind.mesh_file is not None  # noqa: S101 - _chosen looked
    total = hashlib.sha256(repr((RECIPE, kind.mesh_scale, kb.f_ref, options["detector"], options["seed"])).encode())
    for file in sorted(path for path in kind.mesh_file.parent.iterdir() if path.suffix.lower() in MESH_AND_PAINT):
        total.update(file.name.encode() + hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()


def _rendered(
    kind: ObjectType, kb: KnowledgeBase, options: dict[str, Any], say: Callable[[str], None], keep: Keep | None
) -> LearntCloud:
    from kb.learning.features import cloud_of
    from kb.learning.observations import joined
    from kb.learning.views import DIRECTIONS
    from sensing.simulated.meshes import read_mesh
    from sensing.simulated.turntable import extent

    assert kind.mesh_file is not None  # noqa: S101 - _chosen looked
    task = (str(kind.mesh_file), kind.mesh_scale, options["detector"], options["seed"])
    parts = [range(start, min(start + CHUNK, DIRECTIONS)) for start in range(0, DIRECTIONS, CHUNK)]
    seen: list[Observations] = []
    # a forked process would inherit the locks of OpenCV's threads, and wait for them for ever
    with ProcessPoolExecutor(options["jobs"], mp_context=get_context("spawn")) as pool:
        for part, some in zip(parts, pool.map(_look, [task] * len(parts), parts), strict=True):
            seen += some
            _progress(f"{kind.name}: {part.stop} of {DIRECTIONS} views")
    _progress("")
    mesh = read_mesh(kind.mesh_file, kind.mesh_scale)
    whole = joined(seen)
    cloud = cloud_of(whole if keep is None else keep(whole), extent(mesh.vertices)[1], kb.f_ref, DIRECTIONS)
    if not len(cloud.at):
        raise InputError(f"{kind.name}: no keypoint of it comes again from view to view: its texture is too plain for {options['detector']}")
    say(f"{kind.name}: {len(cloud.at)} features, {len(cloud.feature)} appearances")
    return cloud


def _look(task: tuple[str, float, str, int], part: range) -> list[Observations]:
    """In a process of its own: render from some directions, and look."""
    from functools import partial

    import cv2

    from kb.learning.observations import observed
    from kb.learning.views import AWAY, MARGIN, PIXELS, directions
    from sensing.keypoints import keypoints
    from sensing.simulated.meshes import read_mesh
    from sensing.simulated.turntable import turned

    cv2.setNumThreads(1)
    file, scale, detector, seed = task
    detect = partial(keypoints, name=detector)
    views = turned(read_mesh(file, scale), [directions()[i] for i in part], PIXELS[0], MARGIN, AWAY)
    return [observed(view, number, detect, seed) for number, view in zip(part, views, strict=True)]


def _progress(text: str) -> None:
    """One line that is written over, on a terminal only."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r{text}\033[K")
        sys.stderr.flush()


def row_of(name: str, cloud: LearntCloud) -> dict[str, Any]:
    """What is printed of a type that was learnt."""
    import numpy as np

    return {
        "type": name,
        "features": len(cloud.at),
        "appearances": len(cloud.feature),
        "hit rate": round(float(np.median(cloud.hit)), 3),
        "σ mm": round(1000.0 * float(np.median(cloud.sigma)), 2),
    }


def files_of(kb: KnowledgeBase, words: Any, clouds: dict[str, LearntCloud], fresh: set[str]) -> dict[Path, bytes]:  # noqa: ANN401 - Words
    """All that is written: words, every cloud (its words are new), and the lines that name them."""
    from kb.learnt import cloud_bytes
    from kb.words import words_bytes

    assert kb.folder is not None  # noqa: S101 - _chosen looked
    files = {kb.folder / "words.npz": words_bytes(words)}
    files |= _named(kb.folder / "kb.yaml", "words", "words.npz") if kb.words is None else {}
    for folder in sorted((kb.folder / "objects").iterdir()):
        name = object_of(folder)
        if name in clouds:
            files[folder / "cloud.npz"] = cloud_bytes(clouds[name])
            files |= _named(folder / "object.yaml", "cloud", "cloud.npz") if name in fresh and kb.type(name).learnt is None else {}
    return files


def object_of(folder: Path) -> str | None:
    """The object that a folder's object.yaml describes."""
    from kb.yaml_text import load

    file = folder / "object.yaml"
    if not file.is_file():
        return None
    document = load(file.name, file.read_bytes())
    return document.data.get("object") if document is not None and isinstance(document.data, dict) else None


def _named(file: Path, key: str, value: str) -> dict[Path, bytes]:
    """The file with one more line, which names another file."""
    text = file.read_text(encoding="utf-8")
    return {file: f"{text.rstrip()}\n{key}: {{file: {value}}}\n".encode()}
