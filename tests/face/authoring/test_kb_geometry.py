"""`plogic kb show --geometry`: mereology, faces, vector pencils, convergence."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from console import document, good, plogic
from synthetic import towers

from kb.clouds.lobes import feature_in_lobe
from plogic.match.hand.view_cells import view_cells
from plogic.measures.distinctiveness import distinctiveness, instance_counts


@pytest.fixture(scope="module")
def rows():
    return {row["type"]: row for row in document("kb", "show", "towers", "--geometry", "--json")["types"]}


def test_the_mereology_is_a_part_tree_of_proper_parts(rows):
    body, roof = rows["t2"]["parts"]
    assert (body["part"], body["proper_part_of"], body["discrete_from"]) == ("body", [""], ["roof"])
    assert (roof["part"], roof["proper_part_of"], roof["discrete_from"]) == ("roof", [""], ["body"])
    assert body["features"] + roof["features"] == len(towers().type("t2").features)


def test_the_pyramids_faces_have_three_corners_and_all_close_the_surface(rows):
    faces = rows["t2"]["faces"]
    assert sorted(face["corners"] for face in faces) == [3, 3, 3, 3, 4, 4, 4, 4, 4]
    flux = sum(face["area"] * np.array(face["normal"]) for face in faces)
    assert flux == pytest.approx(np.zeros(3), abs=1e-5), "Σ area · normal of a closed surface is 0"


def test_a_pencil_is_seen_from_where_a_lobe_holds_the_viewpoint_and_its_host_does_not_hide_it(rows):
    kind = towers().type("t2")
    share = {pencil["feature"]: pencil["seen"] for pencil in rows["t2"]["pencils"]}
    cells = view_cells(kind)
    places = cells.centre + 3.0 * cells.diameter * cells.directions
    inside = dict(zip([f.name for f in kind.seen_features], feature_in_lobe(kind.lobes, places).T, strict=True))
    assert len(share) == 54
    assert all(0.0 < share[name] <= inside[name].mean() for name in share)


def test_the_sets_of_four_converge_and_no_more_distinctive_set_does(rows):
    kind = towers().type("t2")
    names, dv = [f.name for f in kind.seen_features], distinctiveness(instance_counts(towers().types))
    weight = {f.name: dv[f.type] for f in kind.seen_features}
    cells = view_cells(kind)
    told = rows["t2"]["convergence"]
    for row in told:
        cell = int(np.argmax(cells.directions @ row["viewpoint"]))
        assert cells.visible[cell, [names.index(name) for name in row["features"]]].all()
        assert row["dv"] == pytest.approx(sum(weight[name] for name in row["features"]))
    heavy = [i for i, name in enumerate(names) if weight[name] > 0.5]
    together = [four for four in combinations(heavy, 4) if cells.visible[:, four].all(axis=1).any()]
    assert told[0]["dv"] == pytest.approx(max(sum(weight[names[i]] for i in four) for four in together))


def test_the_text_is_short_and_says_where_the_rest_is():
    text = good("kb", "show", "towers", "t2", "--geometry")
    assert [line for line in text.splitlines() if line.startswith("t")] == [
        "t2: mereology (A3)",
        "t2: faces, maximal convex planar polygons (m²)",
        "t2: vector pencils",
        "t2: convergence, what one viewpoint sees",
    ]
    assert " and 42 more (--json has all)" in text
    assert len(text.splitlines()) < 60
    assert plogic("kb", "show", "towers", "t2", "--geometry", "--html", "-").returncode == 2
