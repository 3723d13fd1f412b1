"""``plogic simulate``: a settled scene, rendered, with its ground truth."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.commands.scenes import shapes_of
from plogic.commands.sources import kb_of

if TYPE_CHECKING:
    from pathlib import Path


def simulate_command(kb_folder: str, number: int, decoys: int, seed: int, out: Path) -> None:
    """Write image.png, camera.json and truth.json into a new folder; the types are drawn by the seed, every type once before any twice."""
    import numpy as np

    from sensing.simulated.scene import random_scene
    from sensing.simulated.scene_files import write_scene
    from sensing.whole_files import check_new_folder

    check_new_folder(out)
    shapes = shapes_of(kb_of(kb_folder))
    rng = np.random.default_rng([seed, 1])
    order = [i for _ in range(number) for i in rng.permutation(len(shapes))][:number]
    write_scene(random_scene([shapes[i] for i in order], seed, decoys=decoys), out)
