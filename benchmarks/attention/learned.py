"""Twenty learned types for ``plogic bench attention``, and pictures of three of them on a table."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.recognition.scenes import YCB, case
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.recognition.score import Truth
    from kb.clouds.cloud import KnowledgeBase
    from sensing.appearance import Gamma

MODELS = YCB.parent / "photos" / "ycb" / "models"
"""Models of YCB objects in BOP's layout, millimetres: others' data, of which the repository carries none."""
TYPES = 20
METRES = 0.001
HARD = 0.0, 0.3
"""How hard the camera and the light are made, in turn."""
FIRST = 7000
"""Number of the first scene, so that no other benchmark has the same."""


def meshes() -> dict[str, Path]:
    """Type name to mesh file, the first twenty. Raises InputError where they are not there."""
    found = {path.stem: path for path in sorted(MODELS.glob("obj_*.ply"))[:TYPES]}
    if len(found) < TYPES:
        raise InputError(f"needs {TYPES} models in {MODELS}, and there are {len(found)}")
    return found


def learned_kb(say: Callable[[str], None], seed: int = 0) -> KnowledgeBase | None:
    """The types, learned as ``plogic bench recognition`` learns its own; None where they cannot be."""
    from benchmarks.recognition.kb import learn_into
    from kb.files.read import read_kb

    with tempfile.TemporaryDirectory(prefix="plogic-attention-") as folder:
        try:
            learn_into(Path(folder) / "kb", meshes(), say, seed, unit="mm")
        except InputError as error:
            say(f"no learned types: {error}")
            return None
        return read_kb(Path(folder) / "kb")


def pictures(kb: KnowledgeBase, count: int, seed: int) -> list[tuple[Gamma, tuple[Truth, ...]]]:
    """What the detector reports in pictures of three of the types, and what stands there."""
    from benchmarks.tabletop.scene import Arrangement, recognition_scene
    from sensing.detectors.detector import detect
    from sensing.files.images import read_image
    from sensing.simulated.body import read_mesh

    names = {kind.name for kind in kb.types}
    shapes = [(name, read_mesh(path, METRES)) for name, path in meshes().items() if name in names]
    found = []
    with tempfile.TemporaryDirectory(prefix="plogic-attention-") as folder:
        for i in range(count):
            number, hard = FIRST + count * seed + i, HARD[i % len(HARD)]
            some = case(
                recognition_scene(shapes, number, arranged=Arrangement(bodies=(3, 3)), hard=hard),
                Path(folder) / str(i),
                number,
                hard,
                {},
            )
            found.append((detect(read_image(some.image), some.camera, kb.sought, kb.words), some.truths))
    return found
