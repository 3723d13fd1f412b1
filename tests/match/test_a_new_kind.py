"""A new kind of type models is one folder and one row of the table of kinds.

Here one that reads printed markers, whose scale numbers features.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from synthetic import CAMERA, is_right, scene, side_by_side, towers

from geometry.poses.posit import posit
from plogic.cycle.delta import Options
from plogic.match import kinds
from plogic.match.hand.hand_models import type_index
from plogic.match.judged.evidence import evidence
from plogic.match.judged.type_models import Search, TypeModels
from plogic.match.kinds import Kind
from plogic.run.perceive import Perceiver

SEEN = []
"""What the toy kind was asked for, in turn."""


@dataclass(eq=False)
class Markers(TypeModels):
    """Types whose features are printed with their own number."""

    models: object

    @classmethod
    def of(cls, setup):
        """As hand-modelled types are."""
        return cls({kind.name: type_index(kind, setup.dv) for kind in setup.types})

    def search(self, request):
        """By markers."""
        return MarkerSearch(self.models, request.kb)


@dataclass(eq=False)
class MarkerSearch(Search):
    """One pose a type, by the markers that are free."""

    models: object
    kb: object

    def propose(self, names, left, given):
        """What POSIT makes of all markers of the image."""
        SEEN.append(tuple(names))
        for name in names:
            model, read = self.models[name], np.flatnonzero(np.isfinite(left.scale))
            poses = np.zeros((0, 4, 4))
            if len(read) >= 4:
                points, xy = model.points[left.scale[read].astype(int)], CAMERA.normalised(left.uv[read])
                poses = posit(points[None], xy[None]).camera_from_object
            posed = [model.settle(pose, left, self.kb) for pose in poses]
            found = [(evidence(each, left, self.kb).ratio, each) for each in posed]
            given.seen(found)
            yield found


def marked(shot, name):
    """The same Γ, in which each datum of a type tells which feature of it is there."""
    numbers = {f"{name}/{feature.name}": i for i, feature in enumerate(towers().type(name).features)}
    rows = [replace(a, scale=numbers.get(shot.causes.get(a.id))) for a in shot.gamma.appearances]
    return replace(shot.gamma, appearances=tuple(rows))


def test_a_kind_is_registered_by_one_row_and_perceives(monkeypatch):
    shot = scene(rng := np.random.default_rng(6300), side_by_side(rng))
    row = Kind("markers", Markers.of, lambda kind, _: kind.name == "t2")
    monkeypatch.setattr(kinds, "KINDS", (row, *kinds.KINDS))
    SEEN.clear()
    ready = Perceiver(towers())
    document = ready(marked(shot, "t2"), Options())
    poses = {h["type"]: h["T_camera_object"] for h in document["hypotheses"] if h["status"] == "accepted"}
    assert {name: list(kind.models) for name, kind in ready.models.kinds.items()} == {"markers": ["t2"], "hand": ["t1"]}
    assert set(SEEN) == {("t2",)}
    assert sorted(poses) == ["t1", "t2"]
    assert all(is_right(name, np.array(pose), shot.poses[name]) for name, pose in poses.items())


def test_without_markers_the_new_kind_finds_nothing_and_the_others_what_they_did(monkeypatch):
    shot = scene(rng := np.random.default_rng(6300), side_by_side(rng))
    row = Kind("markers", Markers.of, lambda kind, _: kind.name == "t2")
    monkeypatch.setattr(kinds, "KINDS", (row, *kinds.KINDS))
    document = Perceiver(towers())(shot.gamma, Options())
    assert {h["type"] for h in document["hypotheses"] if h["status"] == "accepted"} == {"t1"}
