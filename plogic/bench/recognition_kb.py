"""Our side of ``plogic bench recognition``: a knowledge base of the types is learnt from their meshes, and asked what a picture shows.

``Ours`` is all that the benchmark needs of it; tests hand in one of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.bench.recognition_score import Found
from plogic.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from plogic.bench.recognition_peer import Learnt

Recognise = Callable[["NDArray[np.uint8]", "Camera"], list[Found]]
"""(H, W, 3) uint8 image, blue first, and its camera without a pose in, accepted objects out."""


@dataclass(frozen=True)
class Ours:
    """What recognises, and per type the keypoints that were learnt, which the peer is given too."""

    recognise: Recognise
    learnt: Mapping[str, Learnt]


def ours(meshes: Mapping[str, Path], folder: Path, say: Callable[[str], None]) -> Ours:
    """Learn the types into a new knowledge base in ``folder``. Raises InputError where it cannot be learnt."""
    from kb.read import read_kb
    from plogic.perceive import Perceiver

    learn_into(folder, meshes, say)
    kb = read_kb(folder)
    clouds = {t.name: getattr(t, "learnt", None) for t in kb.types}
    missing = [name for name, cloud in clouds.items() if cloud is None]
    if missing:
        raise InputError(f"bench recognition: nothing was learnt of {', '.join(missing)}")
    perceiver = Perceiver(kb)
    return Ours(lambda image, camera: recognised(kb, perceiver, image, camera), {name: c for name, c in clouds.items() if c is not None})


def learn_into(folder: Path, meshes: Mapping[str, Path], say: Callable[[str], None]) -> None:
    """``plogic kb new``, and ``kb add`` and ``kb learn`` of every mesh (metres): the newcomer's path."""
    from plogic.commands.kb_add import add_command
    from plogic.commands.kb_learn import learn_command
    from plogic.commands.kb_new import new_command

    new_command(folder, None)
    for name, mesh in meshes.items():
        say(f"adding {name}")
        add_command(name, mesh, "m", folder, as_json=False)
    learn_command(str(folder), list(meshes), {"detector": "sift", "jobs": 2, "seed": 0, "as_json": True}, say=say)


def recognised(kb: Any, perceiver: Any, image: NDArray[np.uint8], camera: Camera) -> list[Found]:  # noqa: ANN401 - the lead's types
    """The accepted hypotheses of what the perceiver makes of one picture."""
    from plogic.delta import Options
    from plogic.stopwatch import Stopwatch
    from sensing.detector import detect

    gamma = detect(image, camera, kb.appearance_types, getattr(kb, "words", None))
    document = perceiver(gamma, Options(), image, Stopwatch())
    return [
        Found(h["type"], np.array(h["T_camera_object"]), float(h.get("probability", 1.0)))
        for h in document["hypotheses"]
        if h["status"] == "accepted"
    ]
