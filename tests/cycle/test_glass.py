"""What is not opaque occludes nothing (§3.5 to §3.7 demand Opaque throughout)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from situations import feature, hypothesis, situation
from synthetic import belief_at, data, one_before_the_other, scene

from geometry.visibility.roc import ROC20, parts_of
from plogic.cycle.delta import part_relations_of, relations_of
from plogic.facts.situation import pair_facts
from plogic.scene.asking.query import answers

GLASS, SOLID = False, True


@pytest.mark.parametrize("relation", ROC20)
def test_whoever_is_opaque_and_in_front_occludes_and_nobody_else(relation):
    _, front = parts_of(relation)
    for opaque in ((SOLID, SOLID), (GLASS, SOLID), (SOLID, GLASS), (GLASS, GLASS)):
        facts = pair_facts(relation, "x", "y", opaque=opaque)
        hiding = {name for name, solid in zip("xy", opaque, strict=True) if solid and front in (name, "both")}
        assert {f.x for f in facts if f.relation != "non_occludes"} == hiding
        assert {(f.x, f.y) for f in facts if f.relation == "non_occludes"} == (
            set() if hiding else {("x", "y"), ("y", "x")}
        )
        assert ("mutually_occludes" in {f.relation for f in facts}) == (len(hiding) == 2)
        if opaque == (SOLID, SOLID):
            assert facts == pair_facts(relation, "x", "y")
        for f in facts:
            assert not f.roc or parts_of(f.roc)[1] == ("nobody" if not hiding else "both" if len(hiding) == 2 else "x")


def test_of_a_glass_tower_before_another_no_occlusion_is_told():
    rng = np.random.default_rng(7411)
    shot = scene(rng, one_before_the_other(rng))
    posed = {name: belief_at(name, pose, data(shot)) for name, pose in shot.poses.items()}
    camera, pair = shot.gamma.camera, [("t1", "t2")]
    (before,) = relations_of(posed, pair, camera)
    assert (before.relation, before.x) == ("partially_occludes", "t1")
    glass = posed | {"t1": replace(posed["t1"], opaque=False)}
    assert {f.relation for f in relations_of(glass, pair, camera)} == {"non_occludes"}
    assert {f.relation for f in part_relations_of(glass, pair, camera)} == {"non_occludes"}
    behind = posed | {"t2": replace(posed["t2"], opaque=False)}
    assert relations_of(behind, pair, camera) == (before,)


def test_queries_answer_so():
    glass = hypothesis("h1", [feature("x")], opaque=False)
    back = hypothesis("h2", [feature("y", match="b")])
    subject = situation(
        [glass, back], relations=tuple(pair_facts("totally_occludes_ntppi", "h1", "h2", opaque=(GLASS, SOLID)))
    )
    goals = (
        "occludes(h1, h2)",
        "partially_occludes(h1, h2)",
        "totally_occludes(h1, h2)",
        "non_occludes(h1, h2)",
        "roc(R, h1, h2)",
    )
    for goal, p in zip(goals, (0.0, 0.0, 0.0, 1.0, 0.0), strict=True):
        assert max((a.probability for a in answers(subject, goal)), default=0.0) == p, goal
