"""The frames of ``plogic bench batch``.

Γ of one tower among clutter, written to a folder, and now and then a rendered picture.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import CAMERA, random_pose
from geometry.frames import inverse
from kb.clouds.lobes import in_lobe
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

HIT, SIGMA = 0.6, 1.0
"""Share of the visible features that is reported, and the noise of their places, pixels."""
APPEARANCES = 8, 16
"""Least and most appearances of a Γ, its clutter among them."""
RENDERED = 25
"""One frame of so many is a picture."""


def write_frames(kb: KnowledgeBase, number: int, seed: int, folder: Path, say: Callable[[str], None]) -> None:
    """``number`` frames as files of a new folder.

    Those that are pictures are folders in it, with a picture and its camera.
    """
    from sensing.files.gamma_files import write_gamma
    from sensing.simulated.scene import write_scene

    folder.mkdir()
    for i in range(number):
        if i % RENDERED == RENDERED - 1:
            from benchmarks.towers.bench import PLAN, scene_of

            write_scene(scene_of(kb, PLAN[i % len(PLAN)], 1000 * seed + i), folder / f"{i:06d}")
        else:
            write_gamma(gamma(kb, np.random.default_rng([seed, i])), folder / f"{i:06d}.json")
        if i % 100 == 99:
            say(f"made {i + 1} of {number} frames")


def gamma(kb: KnowledgeBase, rng: np.random.Generator) -> Gamma:
    """What a detector reports of one object, any way up, and of clutter, in an order that tells nothing."""
    kind = kb.types[int(rng.integers(len(kb.types)))]
    uv, types = _own(kind, kb, rng)
    total = max(int(rng.integers(*APPEARANCES, endpoint=True)), len(uv))
    noise = total - len(uv)
    uv = np.concatenate([uv, rng.uniform(0.0, [CAMERA.width - 1.0, CAMERA.height - 1.0], (noise, 2))])
    types += [kb.appearance_types[i] for i in rng.integers(len(kb.appearance_types), size=noise)]
    order = rng.permutation(total)
    return Gamma(
        CAMERA,
        tuple(
            Appearance(f"a{n}", types[i], (float(uv[i, 0]), float(uv[i, 1])), "simulated")
            for n, i in enumerate(order, 1)
        ),
    )


def _own(kind: ObjectType, kb: KnowledgeBase, rng: np.random.Generator) -> tuple[NDArray[np.float64], list[str]]:
    """Places (N, 2) in pixels, and appearance types, of those of its visible features that are reported."""
    pose = random_pose(kind, rng)
    posed = pose_of(kind, pose, data_of((), CAMERA, 128), kb)
    held = np.flatnonzero(in_lobe(kind.lobes, inverse(pose)[:3, 3][None], CAMERA.f / kb.f_ref)[0])
    looks = {int(kind.lobes.feature[lobe]): kind.lobes.types[lobe] for lobe in reversed(held)}
    seen = [int(f) for f in np.flatnonzero(posed.candidate) if rng.random() < HIT]
    uv = posed.uv[seen].reshape(-1, 2) + rng.normal(0.0, SIGMA, (len(seen), 2))
    inside = np.flatnonzero(CAMERA.contains(uv))
    return uv[inside], [looks[seen[i]] for i in inside]
