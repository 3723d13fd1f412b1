"""What the key of a kept index depends on: all that decides the index, by content, and nothing else."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oriented_scenes import about_x, clouds

from benchmarks.clutter.types import random_types
from geometry.files.remembered import OURS, ROOT, sources, sources_in
from kb.clouds.lobes import FeatureAppearance
from kb.surfaces.surface import Surface
from plogic.match.hand.hand_models import type_index
from plogic.match.oriented import oriented_models as ready_key
from plogic.match.oriented.oriented_models import SOURCES, _arrays, key_of
from plogic.match.oriented.pair_index import pair_index

READY = "plogic/match/oriented/oriented_models.py"


def types():
    return clouds(count=3, features=8, looks=8).kb.types


def second_feature(**change):
    """The types with the second feature of the second changed."""

    def changed(kind):
        features = (kind.features[0], replace(kind.features[1], **change), *kind.features[2:])
        return replace(kind, features=features)

    return with_second(changed)


def with_second(change):
    one, two, *more = types()
    return [one, change(two), *more]


def other_lobe(**change):
    appearance = types()[1].features[1].appearances[0]
    return second_feature(appearances=(replace(appearance, lobe=replace(appearance.lobe, **change)),))


def with_surface(change):
    return with_second(
        lambda kind: replace(kind, surface=Surface(*change(kind.surface.vertices, kind.surface.triangles)))
    )


def second_appearance():
    appearance = types()[1].features[1].appearances[0]
    return (appearance, FeatureAppearance("a000", appearance.lobe))


CHANGES = {
    "order": lambda: types()[::-1],
    "one dropped": lambda: types()[1:],
    "one twice": lambda: [*types(), types()[0]],
    "name": lambda: with_second(lambda kind: replace(kind, name="other")),
    "opaque": lambda: with_second(lambda kind: replace(kind, opaque=False)),
    "order of features": lambda: with_second(lambda kind: replace(kind, features=kind.features[::-1])),
    "feature dropped": lambda: with_second(lambda kind: replace(kind, features=kind.features[1:])),
    "feature's name": lambda: second_feature(name="other"),
    "feature's type": lambda: second_feature(type="other"),
    "position": lambda: second_feature(at=types()[1].features[1].at + 1e-12),
    "rotation": lambda: second_feature(rotation=about_x(1e-9) @ types()[1].features[1].rotation),
    "an arm": lambda: second_feature(arms=[[0.0, 0.0, 1.0]]),
    "appearance type": lambda: second_feature(
        appearances=(replace(types()[1].features[1].appearances[0], type="other"),)
    ),
    "an appearance more": lambda: second_feature(appearances=second_appearance()),
    "lobe's axis": lambda: other_lobe(axis=(0.0, 1.0, 0.0)),
    "lobe's width": lambda: other_lobe(half_angle=0.1),
    "lobe's least range": lambda: other_lobe(r_min=0.001),
    "lobe's range": lambda: other_lobe(r_max=99.0),
    "no surface": lambda: with_second(lambda kind: replace(kind, surface=None)),
    "vertices": lambda: with_surface(lambda vertices, triangles: (vertices * 1.001, triangles)),
    "triangles": lambda: with_surface(lambda vertices, triangles: (vertices, triangles[:-1])),
    "symmetries": lambda: with_second(
        lambda kind: replace(kind, symmetries=np.array([np.eye(4), np.diag([-1.0, -1.0, 1.0, 1.0])]))
    ),
}


def test_each_kind_of_input_changes_the_key():
    keys = {name: key_of(change()) for name, change in CHANGES.items()} | {"": key_of(types())}
    assert len(set(keys.values())) == len(CHANGES) + 1
    assert all(len(key) == 64 for key in keys.values())


def test_the_same_content_has_the_same_key_whoever_holds_it():
    kb = clouds(count=3, features=8, looks=8).kb
    again = random_types(3, 8, 8, np.random.default_rng(1))
    assert key_of(again.types) == key_of(kb.types)
    assert key_of([replace(kind, mesh_scale=2.0) for kind in kb.types]) == key_of(kb.types), (
        "what the index does not look at"
    )


@pytest.mark.parametrize(("name", "value"), [("source_digest", b"other code"), ("version", "0.0")])
def test_other_code_and_other_libraries_change_the_key(monkeypatch, name, value):
    before = key_of(types())
    monkeypatch.setattr(ready_key, name, lambda *_: value)
    ready_key._made_by.cache_clear()
    assert key_of(types()) != before
    monkeypatch.undo()
    ready_key._made_by.cache_clear()
    assert key_of(types()) == before


def test_every_source_file_that_runs_while_an_index_is_made_is_hashed():
    some, ran = (
        [replace(kind) for kind in random_types(3, 8, 8, np.random.default_rng(5)).types],
        set(),
    )  # of which nothing is computed yet
    former = sys.getprofile()
    sys.setprofile(lambda frame, *_: ran.add(frame.f_code.co_filename))
    try:
        _arrays(pair_index([type_index(kind, dict.fromkeys({f.type for f in kind.features}, 1.0)) for kind in some]))
    finally:
        sys.setprofile(former)
    packages = [ROOT / name for name in OURS]  # the environment and what tests call may lie in the same folder
    ours = {Path(name).relative_to(ROOT).as_posix() for name in ran if any(map(Path(name).is_relative_to, packages))}
    assert {
        READY,
        "geometry/visibility/rays.py",
        "kb/surfaces/surface.py",
        "kb/clouds/cloud.py",
        "kb/clouds/lobes.py",
        "plogic/match/hand/hand_models.py",
    } <= ours
    assert ours <= sources_in(ROOT, SOURCES)


def test_so_is_all_that_makes_the_types_and_all_that_is_imported():
    found = sources_in(ROOT, SOURCES)
    assert {
        "kb/files/read.py",
        "kb/clouds/cloud.py",
        "geometry/visibility/rays.py",
        "plogic/match/oriented/oriented_models.py",
    } | sources(ROOT, READY) <= found
    assert {name.split("/")[0] for name in found} == {"geometry", "kb", "plogic"}, "the wheel holds them"
    assert not any("__pycache__" in name for name in found)
