"""The pictures of ``plogic bench recognition``.

Rendered once to a folder, so that all sides read the same pixels, with their truth.

* ``Case``: one picture, ``Case(seed=7, hard=0.3, empty=False, image=PosixPath(...), camera=Camera(...),
  truths=(Truth(...), ...))``
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.recognition.score import Truth
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from benchmarks.tabletop.scene import TabletopScene
    from geometry.camera import Camera
    from sensing.simulated.body import TexturedMesh

PLAIN = ("mug", "foam_brick", "power_drill")
"""Types with little texture: reported apart, and no claim is made of them."""
SCENES, QUICK_SCENES = 60, 12
EMPTY_EVERY = 6
"""Every sixth scene has none of the types."""
HARD = (0.0, 0.3, 0.6)
"""How hard the camera and the light are made, in turn; see ``recognition_scene``."""
YCB = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "ycb"
"""``../shared/data/ycb`` seen from the project's root: others' data, of which the repository carries none."""
BOXES = ("foam_brick",)
"""Types of one colour whose half turns about the axes of their box leave them as they are: those that their holes
allow."""
NEAR = 0.05
"""Share of a mesh's size by which a half turn may miss it."""


@dataclass(frozen=True, eq=False)
class Case:
    """(S, 4, 4) the half turns about the axes of the smallest box around points (V, 3) that map all onto others."""

    seed: int
    hard: float
    empty: bool
    image: Path
    camera: Camera
    truths: tuple[Truth, ...]


def ycb_meshes() -> dict[str, Path]:
    """Type name to mesh file: ``cracker_box`` of ``003_cracker_box``. Raises InputError where they are not there."""
    folders = sorted(YCB.iterdir()) if YCB.is_dir() else []
    found = {p.name.partition("_")[2]: p / "textured.obj" for p in folders if (p / "textured.obj").is_file()}
    if not found:
        raise InputError(
            f"bench recognition: needs the textured meshes of the YCB objects in {YCB}, and they are not there"
        )
    return found


def cases(shapes: Sequence[tuple[str, TexturedMesh]], folder: Path, seed: int, *, quick: bool) -> Iterator[Case]:
    """Render the scenes, ``SCENES`` a seed, one at a time."""
    from benchmarks.tabletop.scene import recognition_scene

    symmetries = {name: half_turns(mesh.vertices) for name, mesh in shapes if name in BOXES}
    for i in range(QUICK_SCENES if quick else SCENES):
        number, empty = SCENES * seed + i, i % EMPTY_EVERY == EMPTY_EVERY - 1
        hard = HARD[(i + i // EMPTY_EVERY) % len(HARD)]
        yield case(
            recognition_scene(shapes, number, empty=empty, hard=hard),
            folder / f"{number:05d}",
            number,
            hard,
            symmetries,
        )


def case(
    scene: TabletopScene, folder: Path, seed: int, hard: float, symmetries: Mapping[str, NDArray[np.float64]]
) -> Case:
    """Write the scene's folder and keep its truth.

    The camera that is handed on does not know where in the world it is.
    """
    from benchmarks.tabletop.scene import bounds
    from sensing.simulated.scene import write_scene

    write_scene(scene, folder, supersample=2)
    rows = zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True)
    truths = tuple(
        Truth(
            b.label, pose, fraction, np.stack(bounds(b, scene.camera)), middle(b.mesh.vertices), symmetries.get(b.label)
        )
        for b, pose, fraction in rows
        if b.label is not None
    )
    return Case(seed, hard, not truths, folder / "image.png", replace(scene.camera, world_from_camera=None), truths)


def middle(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) the middle of the bounding box."""
    return np.asarray((vertices.min(axis=0) + vertices.max(axis=0)) / 2)


def half_turns(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(S, 4, 4) the half turns about the axes of the smallest box around points (V, 3) that bring all onto others."""
    import trimesh
    from scipy.spatial import cKDTree

    smallest_box: Any = trimesh.bounds.oriented_bounds
    points = np.asarray(vertices)
    box_from_object = np.asarray(smallest_box(points)[0])
    turns = np.array([np.diag([1.0, -1, -1, 1]), np.diag([-1.0, 1, -1, 1]), np.diag([-1.0, -1, 1, 1])])
    motions = np.linalg.inv(box_from_object) @ turns @ box_from_object
    there: Any = cKDTree(points)
    near = NEAR * float(np.linalg.norm(np.ptp(points, axis=0)))
    away = [there.query(points @ motion[:3, :3].T + motion[:3, 3])[0].max() for motion in motions]
    return np.asarray(motions[np.array(away) < near])
