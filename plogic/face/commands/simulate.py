"""``plogic simulate``: a settled scene with its ground truth, as a picture or as Γ; and such scenes as a BOP dataset.

The wiring between meshes of Σ and the simulated camera, which knows no types, is here.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from shlex import quote

import numpy as np

from geometry.camera import camera_to_dict
from geometry.digits import whole
from geometry.files.pose_files import read_moves
from geometry.visibility.rays import RayMesh
from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.base.errors import InputError
from plogic.face.commands.scene_types import Standing, box_of, checked_names, drawn, framed, standing
from plogic.run.bop.write import Kind, write_dataset
from plogic.run.kept_meshes import mesh_of
from plogic.run.simulated_gamma import Obstacle, Posed, Reported, check_written, simulated_gamma
from plogic.run.sources import kb_of
from sensing.files.gamma_files import gamma_to_dict
from sensing.files.two_folders import finish, two_new_folders
from sensing.files.whole_files import check_new_folder, write_folder
from sensing.simulated.body import TexturedMesh
from sensing.simulated.framing import Framing
from sensing.simulated.physics import INSTALL, NO_PHYSICS, has_physics
from sensing.simulated.robot import Robot, write_tour
from sensing.simulated.scene import (
    Placement,
    Scene,
    default_camera,
    json_bytes,
    random_scene,
    truth_to_dict,
    write_scene,
)

RING = "ring:"
MOST_VIEWS = 360
"""Of a ring."""
DEFAULT_OBJECTS = 2
GAMMA_STREAM = 5


@dataclass(frozen=True)
class Wanted:
    """What is asked for of a scene besides the KB and the seed; ``number`` None: as many as are named, or two.

    ``names``: the types that may stand there, all where none is named. ``distance`` (m) of the camera, or ``size_px``
    of the largest thing; one of them at most. ``gamma``: as Γ instead of a picture. ``hiding``: one of the first two
    hides a part of the other.
    """

    number: int | None = None
    decoys: int = 0
    names: tuple[str, ...] = ()
    distance: float | None = None
    size_px: int | None = None
    gamma: bool = False
    hiding: bool = False


def simulate_command(
    kb_folder: str,
    wanted: Wanted,
    seed: int,
    out: Path,
    *,
    say: Callable[[str], None],
    bop: Path | None = None,
    bop_images: int = 1,
    robot: str | None = None,
) -> None:
    """Write image.png (or gamma.json), camera.json and truth.json into a new folder.

    The types are drawn by the seed, every type once before any twice; ``say`` tells which are left out for their size.

    With ``bop``, the scenes of this seed and the next become a BOP dataset in a folder of its own; the first is the
    same. With ``robot``, the camera moves: a folder a frame, the first from where the scene's camera is, and
    ``poses.json``.
    """
    if bop is not None:
        finish(out, bop)
        _check_apart(out, bop)
    check_new_folder(out)
    kb = kb_of(kb_folder)
    kinds = checked_names(kb, wanted.names)
    if wanted.gamma:
        check_written(kb, [kind.name for kind in kinds])
    standings = standings_of(kinds, boxes=wanted.gamma)
    with nullcontext((out, None)) if bop is None else two_new_folders(out, bop) as (folder, dataset):
        if dataset is not None:
            _write_bop(kb, standings, [seed + i for i in range(bop_images)], wanted, dataset)
        scene = scene_of(kb, standings, wanted, seed, say)
        if robot is not None:
            _tour(scene, robot, folder, _gamma_files(kb, seed) if wanted.gamma else None)
        elif wanted.gamma:
            write_folder(folder, _gamma_files(kb, seed)(scene))
        else:
            write_scene(scene, folder)
    if robot is None:
        say(_told(scene, kb_folder, out, wanted))


def _told(scene: Scene, kb_folder: str, out: Path, wanted: Wanted) -> str:
    """What stands there, and the command that looks."""
    labels = [body.label for body in scene.bodies if body.label is not None]
    image, camera, gamma = (quote(str(out / name)) for name in ("image.png", "camera.json", "gamma.json"))
    seen = gamma if wanted.gamma else f"{image} --camera {camera}"
    return f"{', '.join(labels) or 'nothing known'} there; next: plogic perceive {seen} --kb {quote(kb_folder)} -o out.json"


def _tour(scene: Scene, moves: str, out: Path, files: Callable[[Scene], Mapping[str, bytes]] | None) -> None:
    """The frames of a robot that goes where ``moves`` says."""
    robot = Robot(scene)
    start = robot.world_from_camera
    others = (
        robot.ring(_views(moves))[1:]
        if moves.startswith(RING)
        else [move.world(start) for move in read_moves(Path(moves))]
    )
    write_tour(robot, [start, *others], out, files=files)


def _views(moves: str) -> int:
    """N of ``ring:N``. Raises InputError."""
    text = moves.removeprefix(RING)
    number = whole(text, MOST_VIEWS)
    if number:
        return number
    raise InputError(f"--robot {moves}: should be a file of moves, or ring:N with N from 1 to {MOST_VIEWS}")


def standings_of(kinds: Sequence[ObjectType], *, boxes: bool = False) -> list[Standing]:
    """What is put down for each type; ``boxes``: a box for one without a mesh, which else is an InputError."""
    return [standing(kind, box_of(kind) if boxes and kind.mesh_file is None else mesh_of(kind)) for kind in kinds]


def scene_of(
    kb: KnowledgeBase,
    standings: Sequence[Standing],
    wanted: Wanted,
    seed: int,
    say: Callable[[str], None] = lambda _: None,
) -> Scene:
    """What a seed puts before the camera; ``say`` tells what is left out and why."""
    number = wanted.number if wanted.number is not None else max(DEFAULT_OBJECTS, len(wanted.names))
    chosen = drawn(standings, number, seed, named=bool(wanted.names), say=say)
    camera = default_camera()
    framing = _framing(kb, chosen or standings, camera.f, wanted, say)
    placement: Placement = "hiding" if wanted.hiding else "beside"
    shapes = [(s.label, s.mesh) for s in chosen]
    return random_scene(shapes, seed, decoys=wanted.decoys, placement=placement, camera=camera, framing=framing)


def _framing(
    kb: KnowledgeBase, standings: Sequence[Standing], focal: float, wanted: Wanted, say: Callable[[str], None]
) -> Framing:
    """Of these types; of a KB that has none, a scene's own."""
    if not standings:
        say(f"{kb.name}: has no types, so that nothing of it stands there")
        return Framing()
    return framed(standings, focal=focal, f_ref=kb.f_ref, distance=wanted.distance, size_px=wanted.size_px, say=say)


def reported_of(kb: KnowledgeBase, scene: Scene, rng: np.random.Generator) -> Reported:
    """What detectors as good as the KB says report of a scene."""
    rows = list(zip(scene.bodies, scene.camera_from_bodies, strict=True))
    typed = [Posed(body.label, pose) for body, pose in rows if body.label is not None]
    others = [Obstacle(RayMesh(b.mesh.vertices, b.mesh.triangles), pose) for b, pose in rows if b.label is None]
    return simulated_gamma(kb, typed, scene.camera, rng, others)


def noise_of(seed: int) -> np.random.Generator:
    """The random numbers of the detectors of a scene, which are none of those that place things."""
    return np.random.default_rng([seed, GAMMA_STREAM])


def _gamma_files(kb: KnowledgeBase, seed: int) -> Callable[[Scene], Mapping[str, bytes]]:
    """What makes gamma.json, camera.json and truth.json of a scene; each look has noise that no other has."""
    rng = noise_of(seed)

    def files(scene: Scene) -> Mapping[str, bytes]:
        reported = reported_of(kb, scene, rng)
        return {
            "gamma.json": json_bytes(gamma_to_dict(reported.gamma)),
            "camera.json": json_bytes(camera_to_dict(scene.camera)),
            "truth.json": json_bytes(truth_to_dict(scene) | {"causes": dict(reported.causes)}),
        }

    return files


def _write_bop(
    kb: KnowledgeBase, standings: Sequence[Standing], seeds: Sequence[int], wanted: Wanted, folder: Path
) -> None:
    kinds = [Kind(s.label, s.mesh, kb.type(s.label).symmetries) for s in standings]
    write_dataset((scene_of(kb, standings, wanted, seed) for seed in seeds), kinds, folder)


def _check_apart(out: Path, bop: Path) -> None:
    """Both are new folders, and neither lies in the other."""
    a, b = out.resolve(), bop.resolve()
    if a == b or a in b.parents or b in a.parents:
        raise InputError(f"{bop}: is named for two outputs, or lies in the other")
    check_new_folder(bop)


def shapes_of(kb: KnowledgeBase, names: Sequence[str] | None = None) -> list[tuple[str, TexturedMesh]]:
    """(label, textured mesh) of the named types, or of all that have a mesh.

    Raises InputError where a type has none.
    """
    types = kb.types if names is None else [kb.type(name) for name in names]
    return [(t.name, mesh_of(t)) for t in types]


def tell_without_physics(say: Callable[[str], None]) -> None:
    """Say how pictures are made on this machine where pybullet is not installed."""
    if not has_physics():
        say(f"pictures are drawn by rays, and nothing falls or settles, for {NO_PHYSICS}: {INSTALL}")
