"""Two that hide parts of each other, as only concave bodies do.

Both are found, and each says what the other hides of it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from many_objects import accepted_rows

from benchmarks.clutter.types import body_frames, made, scattered, type_names
from benchmarks.many.bench import all_told
from benchmarks.many.placing import Placed, depth_of, meet
from benchmarks.many.scenes import scene_of
from benchmarks.many.types import HALF_ANGLE, LOOKS, with_rates
from geometry.frames import from_rotation_translation, pose_error, rotation_from_quat_xyzw
from kb.surfaces.surface import Surface
from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver

FEATURES = 300
SHOWN = 0.75
LONG, DEEP, HIGH, THICK = 0.36, 0.30, 0.08, 0.07


def staple():
    """A U: two arms along x, one behind the other along z, joined at their left ends."""
    sizes = [(LONG, HIGH, THICK), (LONG, HIGH, THICK), (THICK, HIGH, DEEP)]
    places = [(0.0, 0.0, 0.5 * (THICK - DEEP)), (0.0, 0.0, 0.5 * (DEEP - THICK)), (0.5 * (THICK - LONG), 0.0, 0.0)]
    boxes = [
        trimesh.creation.box(size, from_rotation_translation(np.eye(3), at))
        for size, at in zip(sizes, places, strict=True)
    ]
    whole = trimesh.boolean.union(boxes)
    return Surface(np.asarray(whole.vertices), np.asarray(whole.faces))


@cache
def staples():
    rng, names = np.random.default_rng(11), type_names(LOOKS)
    kinds = []
    for name in ("left", "right"):
        at, normal = scattered(staple(), FEATURES, rng)
        looks = [names[i] for i in rng.integers(len(names), size=FEATURES)]
        kinds.append(made(name, staple(), at, body_frames(normal, rng), looks, np.full(FEATURES, HALF_ANGLE)))
    return Perceiver(with_rates(kinds, names))


def hooked(seed):
    """An arm of each between the arms of the other, seen from before and a little from the side; nothing touches."""
    kb, rng = staples().kb, np.random.default_rng([seed, 3])
    tilt = rotation_from_quat_xyzw([*rng.uniform(-0.2, 0.2, 3), 1.0])
    one = from_rotation_translation(tilt, [-0.05, -0.03, 1.1])
    half_turn = np.diag([-1.0, -1.0, 1.0])
    inside = from_rotation_translation(half_turn, [0.10, 0.06, 0.5 * (DEEP - THICK)])
    poses = [one, one @ inside]
    assert not meet(kb.types[0], poses[0], kb.types[1], poses[1])
    return scene_of(
        kb, [Placed(kind, pose, depth_of(kind, pose)) for kind, pose in zip(kb.types, poses, strict=True)], rng
    )


@cache
def both_to_be_seen():
    """Of some scenes those that show most of both.

    A front face alone, of a staple seen along its arms, does not tell how far that is turned.
    """
    return [shot for shot in map(hooked, range(20)) if min(truth.fraction for truth in shot.truths) >= SHOWN]


@pytest.mark.parametrize("which", range(5))
def test_two_that_hide_parts_of_each_other_are_both_found(which):
    shot = both_to_be_seen()[which]
    document = staples()(shot.gamma, Options(reading="posterior"))
    rows = {h["type"]: h for h in accepted_rows(document)}
    assert set(rows) == {"left", "right"}
    told = {found.type: found.camera_from_object for found in all_told(staples().kb, shot)}
    for truth in shot.truths:
        turned, moved = pose_error(np.array(rows[truth.type]["T_camera_object"]), truth.camera_from_object)
        best_turned, best_moved = pose_error(told[truth.type], truth.camera_from_object)
        assert turned < best_turned + np.radians(3.0)
        assert moved < best_moved + 0.01 * np.linalg.norm(truth.camera_from_object[:3, 3])
    one, other = (rows[name] for name in ("left", "right"))
    for mine, theirs in ((one, other), (other, one)):
        assert any(theirs["id"] in f["hidden_by"] for f in mine["features"])
    asked = [r for r in document["relations"] if r["args"] == [one["id"], other["id"]]]
    assert [r["relation"] for r in asked if r["probability"] > 0.9] == ["mutually_occludes"]
