"""Real scenes as a family: rendered by the simulator, detected from the pixels, and Δh not pruned.

Ten rivals and more an object.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.facts.situation import Situation
    from plogic.run.perceive import Perceiver
    from sensing.simulated.scene import Scene

RIVALS = 10
"""Hypotheses an object that a photograph must be asked for: at least so many."""
MOST_OBJECTS = 3
"""Objects of one photograph: the simulator seldom finds room for more in view. Larger Δh are those of several
photographs together."""

SEEDS, SEED_STEP = 10, 1_000_000
"""Seeds that are tried for one photograph, and how far they are apart."""


def photographs(number: int) -> list[tuple[int, int]]:
    """(objects, hypotheses) of each photograph for Δh of ``number``.

    As few photographs as hold ten to fourteen hypotheses an object.
    """
    count = max(1, round(number / (RIVALS + RIVALS // 3) / MOST_OBJECTS))
    shares = [number // count + (i < number % count) for i in range(count)]
    return [(min(MOST_OBJECTS, max(1, share // RIVALS)), share) for share in shares]


def simulated(perceiver: Perceiver, number: int, seed: int) -> Situation:
    """The posterior reading of ``number`` hypotheses of greatest worth, so many of each photograph.

    All appearances of each are Γ.
    """
    views = [
        photographed(perceiver, objects, share, 100 * seed + i)
        for i, (objects, share) in enumerate(photographs(number))
    ]
    return views[0] if len(views) == 1 else joined(views)


def photographed(perceiver: Perceiver, objects: int, most: int, seed: int) -> Situation:
    """One photograph of the types in turn, with a decoy, and its Δh of at most ``most`` unaccepted hypotheses."""
    from plogic.cycle.delta import Options, unpruned
    from plogic.match.gamma.data import data_of
    from sensing.detectors.detector import detect

    kb = perceiver.kb
    scene = _scene(kb, objects, seed)
    gamma = detect(scene.photograph().image, scene.camera, kb.appearance_types)
    data = data_of(gamma.appearances, gamma.camera)
    return unpruned(data, kb, perceiver.models.values(), perceiver.dv, Options(reading="posterior"), most).situation


def _scene(kb: KnowledgeBase, objects: int, seed: int) -> Scene:
    """The first scene from this seed on that the simulator finds room for."""
    from plogic.face.commands.simulate import shapes_of
    from sensing.errors import SceneError
    from sensing.simulated.scene import random_scene

    shapes = shapes_of(kb)
    chosen = [shapes[(seed + i) % len(shapes)] for i in range(objects)]
    for i in range(SEEDS - 1):
        with suppress(SceneError):
            return random_scene(chosen, seed + SEED_STEP * i, decoys=1)
    return random_scene(chosen, seed + SEED_STEP * SEEDS, decoys=1)


def joined(views: Sequence[Situation]) -> Situation:
    """Several photographs as one situation: every name gets the number of its photograph.

    Nothing of one bears on another.
    """
    parts = [_renamed(view, f"v{i}_") for i, view in enumerate(views, 1)]
    return replace(
        parts[0],
        hypotheses=tuple(h for part in parts for h in part.hypotheses),
        appearances=tuple(a for part in parts for a in part.appearances),
        overlaps=frozenset().union(*(part.overlaps for part in parts)),
        rivals=frozenset().union(*(part.rivals for part in parts)),
        exclusive=frozenset().union(*(part.exclusive for part in parts)),
        relations=tuple(r for part in parts for r in part.relations),
        part_relations=tuple(r for part in parts for r in part.part_relations),
    )


def _renamed(view: Situation, prefix: str) -> Situation:
    def pairs(some: frozenset[tuple[str, str]]) -> frozenset[tuple[str, str]]:
        return frozenset((prefix + x, prefix + y) for x, y in some)

    return replace(
        view,
        hypotheses=tuple(_renamed_hypothesis(h, prefix) for h in view.hypotheses),
        appearances=tuple(replace(a, id=prefix + a.id) for a in view.appearances),
        overlaps=pairs(view.overlaps),
        rivals=pairs(view.rivals),
        exclusive=pairs(view.exclusive),
        relations=tuple(replace(r, x=prefix + r.x, y=prefix + r.y) for r in view.relations),
        part_relations=tuple(replace(r, x=prefix + r.x, y=prefix + r.y) for r in view.part_relations),
    )


def _renamed_hypothesis(h: Hypothesis, prefix: str) -> Hypothesis:
    features = tuple(
        replace(
            f, hidden_by=tuple(prefix + g for g in f.hidden_by), match=None if f.match is None else prefix + f.match
        )
        for f in h.features
    )
    return replace(h, id=prefix + h.id, group=prefix + h.group, features=features)
