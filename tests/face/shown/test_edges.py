"""Edges in the picture: each stretch is hidden by exactly what a ray from the camera meets first."""

from __future__ import annotations

import copy

import numpy as np
import pytest
import shapely
from towers_scene import POSES, apply, meets, project, shape, triangles

from plogic.face.shown.edges import creases, edges_of

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CAMERA = {"width": 400, "height": 300, "K": [[400, 0, 200], [0, 400, 150], [0, 0, 1]], "dist": []}


def box(name, at, turn=0.0, **more):
    """A cube of 1 m at that place in the camera's frame, turned about two axes so that three faces are seen."""
    (a, b), (c, d) = (np.cos([turn, 0.7 * turn]), np.sin([turn, 0.7 * turn]))
    pose = np.eye(4)
    pose[:3, :3] = np.array([[1, 0, 0], [0, b, -d], [0, d, b]]) @ np.array([[a, 0, c], [0, 1, 0], [-c, 0, a]])
    pose[:3, 3] = at
    points = apply(pose, CUBE)
    uv = points[:, :2] / points[:, 2:] * 400 + [200, 150]
    hull = shapely.get_coordinates(shapely.convex_hull(shapely.MultiPoint(uv)))[:-1]
    row = {"id": name, "type": "cube", "T_camera_object": pose.tolist(), "opaque": True, "status": "accepted"}
    return row | {"features": [], "outline": [hull.tolist()]} | more


def scene(*rows, **more):
    meshes = {"cube": {"vertices": CUBE.tolist(), "triangles": triangles(FACES)}}
    return {"camera": CAMERA, "hypotheses": list(rows), "assets": {"meshes": meshes}} | more


def length(strokes, wanted):
    return sum(shapely.LineString(s.points).length for s in strokes if wanted(s))


def test_of_a_cube_seen_from_a_corner_three_edges_are_hidden():
    strokes = edges_of(scene(box("h1", (0, 0, 4), 0.7)))["h1"]
    assert len([s for s in strokes if not s.inner]) == 1
    inner = [s for s in strokes if s.inner]
    assert [s.self_hidden for s in inner].count(True) == 3
    assert [s.self_hidden for s in inner].count(False) == 3
    assert all(s.hidden_by == () for s in strokes)


@pytest.mark.parametrize("left_out", ["h2", "h3"])  # which share a volume, so that each is within the other
def test_what_an_edge_is_hidden_by_is_what_rays_meet(towers, left_out):
    edges = edges_of(towers | {"hypotheses": [h for h in towers["hypotheses"] if h["id"] != left_out]})
    meshes = {h: apply(pose, shape(kind)[0])[triangles(shape(kind)[1])] for h, (kind, pose) in POSES.items()}
    lines = {h: [shapely.LineString(s.points) for s in strokes] for h, strokes in edges.items()}
    status = {h["id"]: h["status"] for h in towers["hypotheses"]}
    told, right = 0, 0
    for name in edges:
        kind, pose = POSES[name]
        vertices, faces = shape(kind)
        sides = {tuple(sorted(pair)) for f in faces for pair in zip(f, [*f[1:], f[0]], strict=True)}
        assert len(sides) in (12, 16)
        hiding = [g for g in edges if g != name and "rejected" not in (status[g], status[name])]
        for a, b in sorted(sides):
            for t in np.linspace(0.05, 0.95, 37):
                point = apply(pose, (1 - t) * vertices[a] + t * vertices[b])
                wanted = meets(point, meshes[name]), tuple(g for g in hiding if meets(point, meshes[g]))
                apart = [line.distance(shapely.Point(project(point))) for line in lines[name]]
                best = edges[name][int(np.argmin(apart))]
                if min(apart) < 0.5:  # a crease ends just before the outline
                    told += 1
                    right += wanted == (best.self_hidden, best.hidden_by)
    assert told > 1000
    assert right > 0.99 * told  # the rest is within a step of where it changes


def test_a_box_behind_another_is_hidden_where_that_stands():
    front, back = box("h1", (-0.75, 0, 3)), box("h2", (0, 0, 5))
    strokes = edges_of(scene(front, back))
    edge = 200 + 400 * (-0.25 / 3.5)  # of the front box its right face is seen, to where that ends
    hidden, seen = (
        [u for s in strokes["h2"] if not s.inner and s.hidden_by == by for u, _ in s.points] for by in (("h1",), ())
    )
    assert max(hidden) == pytest.approx(edge, abs=3)
    assert min(seen) == pytest.approx(edge, abs=3)
    assert not any(s.hidden_by for s in strokes["h1"])


@pytest.mark.parametrize("more", [{"opaque": False}, {"status": "rejected"}, {"type": "unknown"}])
def test_what_is_transparent_rejected_or_without_a_surface_hides_nothing(more):
    strokes = edges_of(scene(box("h1", (-0.75, 0, 3), **more), box("h2", (0, 0, 5))))
    assert strokes["h1"]
    assert not any(s.hidden_by for s in strokes["h2"])


def test_rivals_do_not_hide_each_other():
    rows, rival = (box("h1", (-0.75, 0, 3)), box("h2", (0, 0, 5))), {"fact": "rival", "args": ["h1", "h2"]}
    assert any(s.hidden_by for s in edges_of(scene(*rows))["h2"])
    assert not any(s.hidden_by for s in edges_of(scene(*rows, facts=[rival]))["h2"])


def test_a_rejected_one_is_hidden_by_itself_alone():
    strokes = edges_of(scene(box("h1", (-0.3, 0, 3)), box("h2", (0, 0, 5), 0.7, status="rejected")))["h2"]
    assert not any(s.hidden_by for s in strokes)
    assert sum(s.self_hidden for s in strokes) == 3


def test_a_transparent_one_does_not_hide_itself():
    assert not any(s.self_hidden for s in edges_of(scene(box("h1", (0, 0, 4), 0.7, opaque=False)))["h1"])


def test_strokes_cover_the_outline_once_and_stay_in_the_image(towers):
    edges = edges_of(towers)
    for h in towers["hypotheses"]:
        ring = shapely.LinearRing(h["outline"][0])
        assert length(edges[h["id"]], lambda s: not s.inner) == pytest.approx(ring.length, rel=0.01)
    wide = scene(box("h1", (1.2, 0, 2.2)))
    strokes = edges_of(wide)["h1"]
    assert strokes
    assert all(-0.5 <= u <= 399.5 and -0.5 <= v <= 299.5 for s in strokes for u, v in s.points)


def test_the_order_of_hypotheses_changes_nothing(towers):
    turned = copy.deepcopy(towers)
    turned["hypotheses"].reverse()
    one, other = edges_of(towers), edges_of(turned)
    assert {h: [(s.points, sorted(s.hidden_by)) for s in one[h]] for h in one} == {
        h: [(s.points, sorted(s.hidden_by)) for s in other[h]] for h in one
    }


def test_creases_are_edges_between_facets_that_meet_at_an_angle_also_along_seams():
    assert len(creases(CUBE, np.array(triangles(FACES)))) == 12
    split = np.array([CUBE[i] for t in triangles(FACES) for i in t])
    assert len(creases(split, np.arange(36).reshape(-1, 3))) == 12
    assert len(creases(CUBE, np.array(triangles(FACES[:1])))) == 4


@pytest.mark.parametrize("outline", [[[]], [[[1.0, 1.0]]], [[[float("nan"), 0.0]] * 4]])
def test_an_outline_that_is_no_ring_is_not_drawn(outline):
    assert edges_of(scene(box("h1", (0, 0, 4), outline=outline))) == {}


def test_an_endless_outline_ends_at_the_image():
    strokes = edges_of(scene(box("h1", (0, 0, 4), outline=[[[-1e300, 5.0], [1e300, 5.0], [0.0, 1e300]]])))["h1"]
    places = np.concatenate([s.points for s in strokes])
    assert np.isfinite(places).all()
    assert places.min() >= -0.5
    assert places.max() <= 399.5


def test_without_meshes_or_a_camera_nothing_is_known_to_be_hidden(towers):
    bare = edges_of(towers | {"assets": {}})
    assert all(len(strokes) == 1 and not strokes[0].hidden_by for strokes in bare.values())
    assert len(bare) == 4
    assert edges_of(towers | {"camera": {}}) == {}
    empty = {"meshes": {"t1": {"vertices": [], "triangles": []}}}
    assert len(edges_of(towers | {"assets": empty})) == 4


def test_a_lens_bends_edges_as_it_bends_outlines():
    from geometry.camera import camera_from_dict
    from geometry.visibility.outline import outline

    document = scene(box("h1", (0.3, 0.1, 3), 0.7))
    document["camera"] = CAMERA | {"dist": [-0.2, 0.05, 0, 0, 0]}
    h = document["hypotheses"][0]
    area = outline(CUBE, triangles(FACES), h["T_camera_object"], camera_from_dict(document["camera"]))
    h["outline"] = [shapely.get_coordinates(area.exterior)[:-1].tolist()]
    strokes = edges_of(document)["h1"]
    inner = [s for s in strokes if s.inner]
    assert [s.self_hidden for s in inner].count(True) == 3
    assert all(area.buffer(0.5).contains(shapely.LineString(s.points)) for s in inner)
    assert max(len(s.points) for s in inner) > 2
