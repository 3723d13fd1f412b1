"""Hypotheses of two views that are one stand where both explain them best; occluded rivals are judged with it."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.look_again.episode import tour
from benchmarks.look_again.scenes import scene
from benchmarks.look_again.types import look_alikes
from geometry.frames import inverse, pose_error
from plogic.run.perceive import Perceiver
from plogic.sequence.views.joint import merged

SEED = 11


@pytest.fixture(scope="module")
def perceiver():
    return Perceiver(look_alikes(SEED))


def _off(world_from_object, one):
    """Metres between a pose and that of the scene's first object."""
    seen = inverse(one.first)
    return float(pose_error(seen @ world_from_object, seen @ one.objects[0].pose)[1])


def test_two_views_place_it_better_than_one_and_once(perceiver):
    one = scene(perceiver.kb, 3)
    begun = tour(one, perceiver)
    looks = [begun.look(0), begun.look(3)]
    name = one.objects[0].kind.name
    alone = [some for some in merged(looks[:1], perceiver.models, perceiver.kb) if some.object_type.name == name]
    both = [some for some in merged(looks, perceiver.models, perceiver.kb) if some.object_type.name == name]
    assert min(_off(some.world_from_object, one) for some in both) < 0.006
    assert min(_off(some.world_from_object, one) for some in both) <= min(
        _off(some.world_from_object, one) for some in alone
    )
    first = looks[0].seen.view
    assert not any(a.same(b, first) for i, a in enumerate(alone) for b in alone[:i])


def test_one_view_leaves_hypotheses_where_they_were(perceiver):
    begun = tour(scene(perceiver.kb, 3), perceiver)
    look = begun.look(0)
    found = merged([look], perceiver.models, perceiver.kb)
    poses = [look.seen.view.world_from_camera @ belief.camera_from_object for belief in look.beliefs]
    assert len(found) == len(poses)
    assert all(np.allclose(some.world_from_object, pose) for some, pose in zip(found, poses, strict=True))


def test_a_twin_whose_mark_an_occluder_hides_stays_in_question(perceiver):
    """What the box before it hides is expected of neither twin.

    Both are told, as probable as each other, each at all of its poses.
    """
    twins = [scene(perceiver.kb, seed) for seed in (1, 4, 7, 10, 13, 16)]
    begun = next(tour(one, perceiver) for one in twins if one.objects[0].kind.name.startswith("twin"))
    state = begun.state([0])
    name = begun.scene.objects[0].kind.name[:-2]
    of = {b.id: b.cloud.name for b in state.prospect.bodies if b.cloud.name.startswith(name)}
    chances = {
        twin: sum(state.ranking.marginals[i] for i, mine in of.items() if mine == twin) for twin in set(of.values())
    }
    assert sorted(chances) == [f"{name}_a", f"{name}_b"]
    assert all(p == pytest.approx(0.5, abs=0.01) for p in chances.values())
