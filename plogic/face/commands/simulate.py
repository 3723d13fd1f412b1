"""``plogic simulate``: a settled scene, rendered, with its ground truth; and such scenes as a BOP dataset.

The wiring between meshes of Σ and the simulated camera, which knows no types, is here.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from geometry.files.pose_files import read_moves
from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.base.errors import InputError
from plogic.run.bop.write import Kind, write_dataset
from plogic.run.sources import kb_of
from sensing.files.whole_files import check_new_folder
from sensing.simulated.body import TexturedMesh, read_mesh
from sensing.simulated.physics import INSTALL, NO_PHYSICS, has_physics
from sensing.simulated.robot import Robot, write_tour
from sensing.simulated.scene import Scene, random_scene, write_scene

RING = "ring:"
MOST_VIEWS = 360
"""Of a ring."""


def simulate_command(
    kb_folder: str,
    number: int,
    decoys: int,
    seed: int,
    out: Path,
    bop: Path | None = None,
    bop_images: int = 1,
    robot: str | None = None,
) -> None:
    """Write image.png, camera.json and truth.json into a new folder.

    The types are drawn by the seed, every type once before any twice.

    With ``bop``, the scenes of this seed and the next become a BOP dataset in a folder of its own; the first is the
    same. With ``robot``, the camera moves: a folder a frame, the first from where the scene's camera is, and
    ``poses.json``.
    """
    check_new_folder(out)
    if bop is not None:
        _check_apart(out, bop)
    kb = kb_of(kb_folder)
    shapes = shapes_of(kb)
    if bop is not None:
        _write_bop(kb, shapes, [seed + i for i in range(bop_images)], number, decoys, bop)
    if robot is None:
        write_scene(_scene(shapes, number, decoys, seed), out)
    else:
        _tour(_scene(shapes, number, decoys, seed), robot, out)


def _tour(scene: Scene, moves: str, out: Path) -> None:
    """The frames of a robot that goes where ``moves`` says."""
    robot = Robot(scene)
    start = robot.world_from_camera
    others = (
        robot.ring(_views(moves))[1:]
        if moves.startswith(RING)
        else [move.world(start) for move in read_moves(Path(moves))]
    )
    write_tour(robot, [start, *others], out)


def _views(moves: str) -> int:
    """N of ``ring:N``. Raises InputError."""
    text = moves.removeprefix(RING)
    if text.isascii() and text.isdecimal() and 1 <= len(text) <= len(str(MOST_VIEWS)) and 1 <= int(text) <= MOST_VIEWS:
        return int(text)
    raise InputError(f"--robot {moves}: should be a file of moves, or ring:N with N from 1 to {MOST_VIEWS}")


def _scene(shapes: Sequence[tuple[str, TexturedMesh]], number: int, decoys: int, seed: int) -> Scene:

    rng = np.random.default_rng([seed, 1])
    order = [i for _ in range(number) for i in rng.permutation(len(shapes))][:number]
    return random_scene([shapes[i] for i in order], seed, decoys=decoys)


def _write_bop(
    kb: KnowledgeBase,
    shapes: Sequence[tuple[str, TexturedMesh]],
    seeds: Sequence[int],
    number: int,
    decoys: int,
    folder: Path,
) -> None:

    kinds = [Kind(label, mesh, kb.type(label).symmetries) for label, mesh in shapes]
    write_dataset((_scene(shapes, number, decoys, seed) for seed in seeds), kinds, folder)


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
    return [(t.name, _mesh(t)) for t in types]


def tell_without_physics(say: Callable[[str], None]) -> None:
    """Say how pictures are made on this machine where pybullet is not installed."""
    if not has_physics():
        say(f"pictures are drawn by rays, and nothing falls or settles, for {NO_PHYSICS}: {INSTALL}")


def _mesh(object_type: ObjectType) -> TexturedMesh:

    if object_type.mesh_file is None:
        raise InputError(f"{object_type.name}: has no mesh, so that it cannot be rendered")
    return read_mesh(object_type.mesh_file, object_type.mesh_scale)
