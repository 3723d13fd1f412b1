"""Constancy from pixels: three rendered views of the two towers, by a knowledge base of both, and by one of t2 alone.

    python benchmarks/constancy_pixels.py [SCENES]

A line a scene: of either knowledge base what is known, how many data a view leaves unexplained, the features of each
unknown object; of t2 alone, in how many of the three views the draft that is made of the largest unknown object is
accepted afterwards.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.panorama.bench import taken
from benchmarks.towers.bench import scene_of
from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from plogic.sequence.constancy.result import draft_type, seen_features
from plogic.sequence.views.panorama import Panorama, constancy_of

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase
    from plogic.sequence.constancy.result import Constancy
    from plogic.sequence.constancy.sight_lines import View

FIRST_SEED, TURNS = 79_000, (0.0, 12.0, 24.0)
"""The seed of the first scene; degrees round the vertical through the world's origin from which it is looked at."""


def views_of(kb: KnowledgeBase, seed: int) -> list[View]:
    """What is detected in the pictures."""
    scene = scene_of(kb, "beside", seed)
    pose, views = np.asarray(scene.camera.world_from_camera), []
    for number, degrees in enumerate(TURNS, 1):
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec([0.0, 0.0, np.radians(degrees)]).as_matrix()
        moved = replace(scene.camera, world_from_camera=turn @ pose)
        views.append(taken(replace(scene, camera=moved, sensor=replace(scene.sensor, seed=number)), number, kb))
    return views


def looked(kb: KnowledgeBase, views: list[View]) -> tuple[str, Constancy]:
    """What is said of a sequence, and what is unknown."""
    panorama = Panorama(Perceiver(kb), Options(reading="posterior"))
    looks = [panorama.look(view) for view in views]
    constancy = constancy_of(panorama, looks)
    known = "+".join(sorted(one.standing.object_type.name for one in panorama.known)) or "nothing"
    left = [len(look.unexplained) for look in looks]
    return f"{known} known, {left} unexplained, unknown {[len(one.features) for one in constancy.unknown]}", constancy


def main(scenes: int) -> None:
    """Print a line a scene."""
    whole = kb_of("towers")
    less = replace(whole, types=tuple(kind for kind in whole.types if kind.name != "t1"))
    for seed in range(FIRST_SEED, FIRST_SEED + scenes):
        views = views_of(whole, seed)
        both, _ = looked(whole, views)
        alone, constancy = looked(less, views)
        found = 0
        if constancy.unknown:
            draft = draft_type("draft", seen_features(constancy.unknown[0], views), whole.f_ref)
            perceiver = Perceiver(replace(less, types=(*less.types, draft)))
            found = sum(any(b.object_type is draft for b, _ in perceiver.accepted(view.gamma)) for view in views)
        sys.stdout.write(f"{seed}: both: {both}; t2 alone: {alone}; draft accepted in {found} of {len(views)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scenes", nargs="?", type=int, default=10, metavar="SCENES", help="how many (10)")
    main(parser.parse_args().scenes)
