"""``plogic kb learn NAME --photo FILE --points FILE``.

An object type from one photo, laid onto its mesh by a few clicked points.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from geometry.camera import camera_to_dict
from geometry.files.begun import scratch
from geometry.poses.register import Registration
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud
from kb.clouds.words import Words
from kb.files.changes import Writer
from kb.files.yaml_text import load
from kb.intake.new_type import NewType, check_name, new_type
from kb.intake.source import png, read_source
from kb.learning.compounds import with_parts
from kb.learning.photo import PaintedMesh, painted, read_points, registered
from plogic.base.errors import InputError
from plogic.face.authoring.kb_learn import BY_HAND, check_detector, files_of, row_of
from plogic.face.authoring.kb_learn_all import WORK, learned, no_print
from plogic.face.authoring.kb_learn_words import words_of
from plogic.face.authoring.kb_types import changing, check_places, files_in, new_command, type_folders, with_entry
from plogic.face.shown.options import Learning, Photo
from plogic.face.shown.progress import Work
from plogic.face.shown.tables import plain_table
from plogic.run.cameras import sized
from plogic.run.sources import kb_of
from sensing.files.images import read_image
from sensing.simulated.body import read_mesh
from sensing.simulated.stage import MAX_TRIANGLES

BY_PHOTO = "# painted with a photo by plogic kb learn --photo\n"
"""The first line of a material that may be replaced by a better photo's."""
PAINT = ("textured.obj", "textured.mtl", "texture.png")


def learn_photo_command(
    kb_folder: str, names: Sequence[str], sources: Photo, options: Learning, *, say: Callable[[str], None]
) -> str:
    """Register, paint, learn, and only then write: the type (where it is new), its texture, its cloud and the words.

    Raises InputError, KBError, GeometryError, SensingError: nothing is written then.
    """
    if len(names) != 1:
        raise InputError(f"--photo: name the one type that it shows, not {len(names)}")
    with changing(kb_folder) as (kb, writer):
        return _learn(kb_folder, kb, names, sources, options, writer, say)


def _learn(
    kb_folder: str,
    kb: KnowledgeBase,
    names: Sequence[str],
    sources: Photo,
    options: Learning,
    writer: Writer,
    say: Callable[[str], None],
) -> str:
    """As ``learn_photo_command``, of a knowledge base that nobody else changes."""
    new, kind = _the_type(kb_folder, kb, names, sources, options.detector, say)
    for note in new.notes if new is not None else ():
        say(f"{kind.name}: {note}")
    found, mesh = _registered(kind, sources)
    say(_told(kind, found, mesh))
    with scratch() as folder:
        files = _paint_files(mesh, sources.photo.name, kind.mesh_scale)
        for name, data in files.items():
            (folder / name).write_bytes(data)
        with Work(WORK, say) as work:
            paint = replace(kind, mesh_file=folder / PAINT[0])
            found_cloud = learned([paint], (), kb, options, work, mesh)[kind.name].cloud
    if found_cloud is None:
        raise InputError(f"{kind.name}: {no_print(options.detector)}")
    cloud = with_parts(kind, found_cloud)
    known = {kind.name: kind.learned for kind in kb.types if kind.learned is not None}
    words, clouds = words_of(known | {kind.name: cloud}, options.seed)
    count = len(words.centroids)
    writer.change(_files(writer.root, new, kind.name, files, words, clouds))
    return _answer(kb_folder, kind, found, mesh, cloud, count, as_json=options.as_json)


def _the_type(
    kb_folder: str,
    kb: KnowledgeBase,
    names: Sequence[str],
    sources: Photo,
    detector: str,
    say: Callable[[str], None],
) -> tuple[NewType | None, ObjectType]:
    """The new type's files where it is new, and the type with its surface."""
    folder = Path(kb_folder)
    check_detector(kb_folder, kb, detector, names)
    kind = next((kind for kind in kb.types if kind.name == names[0]), None)
    if kind is None:
        return _new(folder, names[0], sources)
    if sources.mesh is not None:
        say(f"{kind.name}: is there already, so --mesh is not read")
    fault = _fault(kind, type_folders(folder)[kind.name])
    if fault is not None:
        raise InputError(f"{kind.name}: {fault}")
    return None, kind


def _fault(kind: ObjectType, folder: Path) -> str | None:
    """Why a type, described in ``folder``, cannot be learned from a photo."""
    if kind.surface is None or kind.mesh_file is None:
        return "has no mesh to lay the photo on"
    if kind.features and kind.learned is None:
        return BY_HAND
    material = folder / PAINT[1]
    if material.is_file() and material.read_text(encoding="utf-8", errors="replace").startswith(BY_PHOTO):
        return None
    if material.exists() or read_mesh(kind.mesh_file).texture is not None:
        return "has a texture of its own, which shows more of it than a photo: plogic kb learn without --photo"
    return None


def _new(kb_folder: Path, name: str, sources: Photo) -> tuple[NewType, ObjectType]:

    if sources.mesh is None:
        raise InputError(f"{name}: no such object type; add it with plogic kb add, or give --mesh and --units")
    check_name(name)
    check_places(kb_folder, [name])
    new = new_type(name, read_source(sources.mesh), sources.units, sources.mesh)
    if PAINT[0] in new.files:
        raise InputError(
            f"{name}: {sources.mesh} has a texture of its own, which shows more than a photo: plogic kb add, then kb learn"
        )
    with scratch() as folder:
        draft = folder / "kb"
        new_command(draft, "draft")
        place = draft / "objects" / name
        place.mkdir(parents=True)
        for file, data in new.files.items():
            (place / file).write_bytes(data)
        return new, kb_of(str(draft)).type(name)


def _registered(kind: ObjectType, sources: Photo) -> tuple[Registration, PaintedMesh]:

    assert kind.surface is not None  # noqa: S101 - _fault looked
    points = read_points(sources.points)
    photo = read_image(sources.photo)
    size = photo.shape[1], photo.shape[0]
    camera = sources.camera.of(size, str(sources.photo))
    if camera is not None:
        sized(camera, size, str(sources.camera.file), str(sources.photo))
    found = registered(points, size, kind.surface, camera)
    mesh = painted(kind.surface, photo, found.camera, found.camera_from_object)
    if len(mesh.triangles) > MAX_TRIANGLES:
        what = f"cut as finely as a photo needs, its mesh has {len(mesh.triangles)} triangles, more than the {MAX_TRIANGLES} that can be rendered"
        raise InputError(f"{kind.name}: {what}: simplify the mesh, as plogic kb add does")
    return found, mesh


def _told(kind: ObjectType, found: Registration, mesh: PaintedMesh) -> str:
    f = f"f = {found.camera.f:.0f} px" + (f" ± {found.f_error:.0f}" if found.f_error else "")
    return f"{kind.name}: {f}, rms of the points {found.rms:.2f} px, the photo shows {_share(mesh):.0%} of the surface"


def _share(mesh: PaintedMesh) -> float:

    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return float(area[mesh.shown].sum() / area.sum())


def _paint_files(mesh: PaintedMesh, photo: str, metres_per_unit: float) -> dict[str, bytes]:
    """The textured mesh in the unit of the type's own, its material and its picture."""
    lines = ["mtllib textured.mtl", "usemtl painted"]
    lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in (mesh.vertices / metres_per_unit).tolist()]
    lines += [f"vt {u:.7g} {v:.7g}" for u, v in mesh.uv.tolist()]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (mesh.triangles + 1).tolist()]
    named = photo.encode("ascii", "replace").decode().replace("\n", " ")
    material = f"{BY_PHOTO}# {named}\nnewmtl painted\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {PAINT[2]}\n"
    return {PAINT[0]: ("\n".join(lines) + "\n").encode(), PAINT[1]: material.encode(), PAINT[2]: png(mesh.texture).data}


def _files(
    folder: Path,
    new: NewType | None,
    name: str,
    paint: Mapping[str, bytes],
    words: Words,
    clouds: Mapping[str, LearnedCloud],
) -> dict[Path, bytes]:
    """All that is written: the type where it is new, its paint, and what was learned."""
    place = folder / "objects" / name if new is not None else type_folders(folder)[name]
    files = files_of(folder, words, clouds, files_in(folder, [new]) if new is not None else None)
    file = place / "object.yaml"
    content = files[file] if file in files else file.read_bytes()
    mesh = load(str(file), content).data["mesh"] | {"textured": PAINT[0]}
    files[file] = with_entry(file, content, "mesh", mesh)
    return files | {place / own: data for own, data in paint.items()}


def _answer(
    kb_folder: str,
    kind: ObjectType,
    found: Registration,
    mesh: PaintedMesh,
    cloud: LearnedCloud,
    words: int,
    *,
    as_json: bool,
) -> str:

    row = row_of(kind.name, cloud) | {
        "shown": round(_share(mesh), 3),
        "f px": round(found.camera.f, 1),
        "± px": round(found.f_error, 1),
    }
    row |= {"rms px": round(found.rms, 2)}
    if not as_json:
        return plain_table(f"learned into {kb_folder}: {words} words in all", [row])
    photo = {
        "camera": camera_to_dict(found.camera),
        "T_camera_object": found.camera_from_object.tolist(),
        "residuals_px": [round(float(off), 3) for off in found.residuals],
    }
    return json.dumps({"format": "kb_learn/1", "kb": kb_folder, "words": words, "types": [row | {"photo": photo}]})
