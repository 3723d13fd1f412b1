"""What triangulates and persists is physical, the rest is noise, and what could not be told is left open (§4.4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from moved_views import CAMERA, RATES, all_of, blob, ring, views_of, without

from geometry.camera import Camera
from plogic.sequence.constancy.decide import unknown_objects
from plogic.sequence.constancy.result import constancy_document
from plogic.sequence.constancy.sight_lines import View
from sensing.appearance import Appearance, Gamma


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def features(constancy):
    return [feature for one in constancy.unknown for feature in one.features]


def data(constancy):
    return {(frozenset(f.data.items()), round(f.probability, 9)) for f in features(constancy)}


def test_points_come_out_where_they_are_and_clutter_is_noise(rng):
    points = blob(rng)
    views, causes = views_of(points, ring(3), rng, hit=0.9, clutter=20)
    found = unknown_objects(views, all_of(views), RATES)
    right = 0
    for feature in features(found):
        whose = {causes[view].get(datum) for view, datum in feature.data.items()}
        if len(whose) == 1 and None not in whose:
            off = float(np.linalg.norm(feature.at - points[whose.pop()]))
            assert off < 5.0 * feature.sigma
            right += 1
    assert right >= 20
    assert len(features(found)) - right <= 3
    clutter = {(view.id, a.id) for view in views for a in view.gamma.appearances if a.id not in causes[view.id]}
    noise = {(view, datum) for view, ids in found.noise.items() for datum in ids}
    assert len(clutter) > 50
    assert len(clutter & noise) / len(clutter) > 0.9


def test_every_datum_has_one_fate(rng):
    views, _ = views_of(blob(rng), ring(4), rng, hit=0.8, clutter=30)
    found = unknown_objects(views, all_of(views), RATES)
    fates = [(view, datum) for feature in features(found) for view, datum in feature.data.items()]
    fates += [(view, datum) for some in (found.noise, found.undecided) for view, ids in some.items() for datum in ids]
    assert sorted(fates) == sorted((view.id, a.id) for view in views for a in view.gamma.appearances)


def test_what_is_explained_is_not_asked_about(rng):
    views, causes = views_of(blob(rng), ring(3), rng)
    unexplained = {view.id: [d for d, cause in causes[view.id].items() if cause % 2] for view in views}
    found = unknown_objects(views, unexplained, RATES)
    seen = {causes[view][datum] for feature in features(found) for view, datum in feature.data.items()}
    assert seen
    assert all(cause % 2 for cause in seen)


def test_order_changes_nothing(rng):
    views, _ = views_of(blob(rng), ring(3), rng, hit=0.8, clutter=15)
    turned = [View(v.id, Gamma(CAMERA, v.gamma.appearances[::-1]), v.world_from_camera) for v in views]
    one, other = (unknown_objects(some, all_of(some), RATES) for some in (views, turned))
    assert data(one)
    assert data(one) == data(other)


def test_names_change_nothing(rng):
    views, _ = views_of(blob(rng), ring(3), rng, hit=0.8, clutter=15)
    renamed = [
        View(
            f"w{v.id}",
            Gamma(CAMERA, tuple(replace(a, id=f"x{a.id}") for a in v.gamma.appearances)),
            v.world_from_camera,
        )
        for v in views
    ]
    one, other = (unknown_objects(some, all_of(some), RATES) for some in (views, renamed))
    assert {(frozenset((f"w{v}", f"x{d}") for v, d in rows), p) for rows, p in data(one)} == data(other)


def test_a_world_elsewhere_is_the_same(rng):
    """A rigid motion of the world moves the places, and changes nothing of what is called physical."""
    views, _ = views_of(blob(rng), ring(3), rng, clutter=10)
    angle = 0.7
    moved = np.array(
        [[np.cos(angle), -np.sin(angle), 0, 5], [np.sin(angle), np.cos(angle), 0, -3], [0, 0, 1, 2], [0, 0, 0, 1.0]]
    )
    others = [View(v.id, v.gamma, moved @ v.world_from_camera) for v in views]
    one, other = (unknown_objects(some, all_of(some), RATES) for some in (views, others))
    there = {frozenset(f.data.items()): f for f in features(other)}
    assert len(features(one)) == len(there) > 15
    for feature in features(one):
        twin = there[frozenset(feature.data.items())]
        assert np.allclose(moved[:3, :3] @ feature.at + moved[:3, 3], twin.at, atol=1e-6)


def test_without_a_baseline_nothing_is_decided(rng):
    frame = ring(1)[0]
    turned = frame.copy()
    turned[:3, :3] = frame[:3, :3] @ np.array(
        [[np.cos(0.05), 0, np.sin(0.05)], [0, 1, 0], [-np.sin(0.05), 0, np.cos(0.05)]]
    )
    views, _ = views_of(blob(rng), [frame, turned], rng, clutter=10)
    found = unknown_objects(views, all_of(views), RATES)
    assert not found.unknown
    assert sum(map(len, found.undecided.values())) == sum(len(v.gamma.appearances) for v in views)


def test_one_view_decides_nothing_and_nothing_is_nothing(rng):
    views, _ = views_of(blob(rng), ring(1), rng)
    alone = unknown_objects(views, all_of(views), RATES)
    assert not alone.unknown
    assert len(alone.undecided["v1"]) == len(views[0].gamma.appearances)
    nobody = unknown_objects(views, {}, RATES)
    assert (nobody.unknown, nobody.noise, nobody.undecided) == ((), {"v1": ()}, {"v1": ()})
    assert unknown_objects([], {}, RATES).unknown == ()


def single(rng, missed):
    """A lone point seen twice; ``missed`` by two views between."""
    views, causes = views_of(np.array([[0.0, 0.0, 0.1]]), ring(4, 8.0), rng, sigma=0.3)
    gone = [without(v, causes[v.id]) if i in missed else v for i, v in enumerate(views)]
    return gone, RATES


def probability(views, rates, hidden=None):
    found = features(unknown_objects(views, all_of(views), rates, hidden))
    return max((f.probability for f in found), default=0.0)


def test_what_persists_is_likelier_than_what_does_not(rng):
    rates = replace(RATES, clutter=dict.fromkeys(RATES.clutter, 1.0))
    views, _ = single(rng, {1, 2})
    fewer = [views[0], views[3]]
    assert probability(fewer, rates) > 0.5
    assert probability(views, rates) < probability(fewer, rates)


def test_a_miss_that_a_body_explains_costs_nothing(rng):
    rates = replace(RATES, clutter=dict.fromkeys(RATES.clutter, 1.0))
    views, _ = single(rng, {1, 2})

    def hidden(view, world):
        return np.full(len(world), view in ("v2", "v3"))

    assert probability(views, rates, hidden) == pytest.approx(probability([views[0], views[3]], rates))


def test_clutter_that_is_more_frequent_explains_more(rng):
    views, _ = single(rng, set())
    rates = [replace(RATES, clutter=dict.fromkeys(RATES.clutter, n)) for n in (0.5, 5.0, 50.0)]
    said = [probability(views[:2], some) for some in rates]
    assert said[0] > said[1] > said[2]
    assert all(probability(views, some) > said[i] for i, some in enumerate(rates))


def test_data_of_other_types_are_not_one_place(rng):
    views, _ = views_of(np.array([[0.0, 0.0, 0.1]]), ring(2), rng, sigma=0.1)
    (one,), (other,) = (v.gamma.appearances for v in views)
    strange = [views[0], View("v2", Gamma(CAMERA, (replace(other, type="q"),)), views[1].world_from_camera)]
    assert one.type != "q"
    assert not unknown_objects(strange, all_of(strange), RATES).unknown


def test_two_bodies_apart_are_two_objects(rng):
    points = np.concatenate([blob(rng, 16, (-0.2, 0.0, 0.1)), blob(rng, 24, (0.2, 0.0, 0.1))])
    views, causes = views_of(points, ring(4), rng, sigma=0.5)
    found = unknown_objects(views, all_of(views), RATES)
    large = [one for one in found.unknown if len(one.features) > 8]
    owners = [{causes[v].get(d, -1) < 16 for f in one.features for v, d in f.data.items()} for one in large]
    assert owners == [{False}, {True}]
    assert [one.id for one in large] == ["u1", "u2"]
    assert all(one.probability > 0.99 for one in large)


def test_angles_tell_where_places_do_not(rng):
    """Two data that meet by chance, with angles that no direction in space has, are clutter.

    With angles that one has, physical.
    """
    views, _ = views_of(np.array([[0.0, 0.0, 0.1]]), ring(3, 10.0), rng, sigma=0.3)
    rates = replace(RATES, sigma_angle=0.05)

    def turned(angles):
        return [
            View(v.id, Gamma(CAMERA, tuple(replace(a, angle=angle) for a in v.gamma.appearances)), v.world_from_camera)
            for v, angle in zip(views, angles, strict=True)
        ]

    steady, wild = turned([1.5, 1.5, 1.5]), turned([1.5, 3.5, 5.5])
    assert probability(steady[:2], rates) > probability(views[:2], rates) > probability(wild[:2], rates)


def test_a_lens_bends_nothing_away(rng):
    """The same rays through a lens: the same places."""
    bent = Camera(640, 480, CAMERA.K, np.array([-0.2, 0.05, 0.0, 0.0, 0.0]))
    points = blob(rng)
    straight, _ = views_of(points, ring(3), rng, sigma=0.0)
    lens = []
    for view in straight:
        rows = [
            Appearance(a.id, a.type, tuple(bent.project(CAMERA.rays(np.array(a.uv))).tolist()), a.detector)
            for a in view.gamma.appearances
        ]
        lens.append(View(view.id, Gamma(bent, tuple(rows)), view.world_from_camera))
    one, other = (unknown_objects(some, all_of(some), RATES) for some in (straight, lens))
    places = {frozenset(f.data.items()): f.at for f in features(one)}
    assert len(places) >= 22
    assert all(np.allclose(places[frozenset(f.data.items())], f.at, atol=1e-5) for f in features(other))


def test_the_document_has_the_panoramas_keys(rng):
    views, _ = views_of(blob(rng), ring(3), rng, clutter=5)
    document = constancy_document(unknown_objects(views, all_of(views), RATES))
    assert set(document) == {"unknown", "noise", "undecided"}
    first = document["unknown"][0]
    assert set(first) == {"id", "probability", "features"}
    assert set(first["features"][0]) == {"id", "type", "at", "sigma", "probability", "data"}
    assert first["features"][0]["id"] == "u1/f1"
