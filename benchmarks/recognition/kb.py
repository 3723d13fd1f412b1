"""Our side of ``plogic bench recognition``.

A knowledge base of the types is learned from their meshes, and asked what a picture shows.

``Ours`` is all that the benchmark needs of it; tests hand in one of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.recognition.score import Found
from plogic.base.errors import InputError
from plogic.face.shown.options import Learning

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from benchmarks.recognition.peer import Learned
    from geometry.camera import Camera

LEARNING = Learning(detector="sift", jobs=2)
"""What ``kb learn`` is asked for besides the seed."""
Recognise = Callable[["NDArray[np.uint8]", "Camera"], list[Found]]
"""(H, W, 3) uint8 image, blue first, and its camera without a pose in, accepted objects out."""


@dataclass(frozen=True)
class Ours:
    """What recognises, and per type the keypoints that were learned, which the peer is given too."""

    recognise: Recognise
    learned: Mapping[str, Learned]


def ours(meshes: Mapping[str, Path], folder: Path, say: Callable[[str], None]) -> Ours:
    """Learn the types into a new knowledge base in ``folder``. Raises InputError where it cannot be learned."""
    from kb.files.read import read_kb
    from plogic.face.commands.bop import look_of

    learn_into(folder, meshes, say)
    kb = replace(read_kb(folder), gravity=True)  # what stands on a table: `gravity: true` in a user's kb.yaml
    clouds = {t.name: t.learned.keypoints for t in kb.types if t.learned is not None}
    missing = [t.name for t in kb.types if t.learned is None]
    if missing:
        raise InputError(f"bench recognition: nothing was learned of {', '.join(missing)}")
    look = look_of(kb)
    return Ours(
        lambda image, camera: [Found(name, np.array(pose), sure) for name, pose, sure in look(image, camera)], clouds
    )


def learn_into(
    folder: Path, meshes: Mapping[str, Path], say: Callable[[str], None], seed: int = 0, unit: str = "m"
) -> None:
    """``plogic kb new``, and ``kb add`` and ``kb learn`` of every mesh, if any: the newcomer's path."""
    from plogic.face.authoring.kb_learn import learn_command
    from plogic.face.authoring.kb_types import add_command, new_command

    new_command(folder, None)
    for name, mesh in meshes.items():
        say(f"adding {name}")
        add_command(name, mesh, unit, folder, as_json=False)
    if meshes:
        learn_command(str(folder), list(meshes), replace(LEARNING, seed=seed), say=say)
