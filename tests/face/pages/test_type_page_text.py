"""The page of an object type as text.

Bytes that repeat, a policy that names its own hashes, data that cannot escape and that stays small.
"""

from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np
import pytest
from made_types import HOSTILE, bare, hostile, write_learned
from page_checks import check_harmless, check_policy, data_text, element
from random_cloud import random_cloud

from kb.clouds.cloud import Stand
from kb.files.read import read_kb
from plogic.face.pages.type_content import (
    LARGEST_PICTURE,
    MOST_FEATURES,
    MOST_LOBES,
    chosen,
    type_document,
    type_page,
)
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from plogic.run.painted import MOST_DRAWN

SMALL = 3_000_000
"""Bytes that a page is to stay below."""


def floats(text):
    return np.frombuffer(base64.b64decode(text), "<f4")


def shorts(text):
    return np.frombuffer(base64.b64decode(text), "<u2")


def test_the_same_kb_gives_the_same_bytes(learned_kb):
    again = read_kb(learned_kb.folder)
    assert type_page(learned_kb, learned_kb.types[0]) == type_page(again, again.types[0])


@pytest.mark.parametrize("name", ["script", "style"])
def test_the_policy_names_the_hash_of_what_is_inside(tower_kb, name):
    check_policy(type_page(tower_kb, tower_kb.types[0]), name)


def test_no_handler_no_eval_no_markup_from_data_and_nothing_loaded(tower_kb):
    text = type_page(tower_kb, tower_kb.types[0])
    check_harmless(text)
    assert "<noscript>" in text


def test_the_code_stays_small(tower_kb):
    assert len(element(type_page(tower_kb, tower_kb.types[0]), "script")) < 46_000


def test_hostile_names_stay_inside_the_data(tower_kb):
    kb, kind = hostile(tower_kb)
    text = type_page(kb, kind)
    assert text.count("</script>") == 2
    assert "<img" not in text
    assert "<!--" not in text
    data = json.loads(data_text(text))
    assert (data["kb"]["name"], data["type"]["name"]) == (HOSTILE, HOSTILE)
    assert HOSTILE in data["lobes"]["looks"]
    assert HOSTILE in [row[0] for row in data["types"]]


def stands(kb, **changes):
    return type_document(kb, replace(kb.types[1], **changes))["stands"]


def test_the_ways_to_stand_have_pictures(tower_kb):
    found = stands(tower_kb)
    assert [face["said"].split(": ")[0] for face in found["faces"]] == ["0.5"] + ["0.125"] * 4
    assert len({face["picture"]["base64"] for face in found["faces"]}) == 5
    assert "as its file says" in stands(tower_kb, stands=(Stand((0, 0, -1)),))["said"]
    assert stands(tower_kb, stands=()) == {"said": "Its file says that it never stands.", "faces": []}
    assert stands(tower_kb, surface=None)["faces"] == []


def test_a_written_type_comes_back_from_its_arrays(tower_kb):
    kind = tower_kb.types[1]
    data, dv = type_document(tower_kb, kind), distinctiveness(instance_counts(tower_kb.types))
    names = [row[0] for row in data["types"]]
    assert data["features"]["names"] == [f.name for f in kind.features]
    assert [names[i] for i in shorts(data["features"]["type"])] == [f.type for f in kind.features]
    assert np.allclose(floats(data["features"]["at"]).reshape(-1, 3), [f.at for f in kind.features], atol=1e-6)
    assert {row[0]: row[3] for row in data["types"]} == pytest.approx({n: dv[n] for n in names}, abs=1e-6)
    assert [data["lobes"]["looks"][i] for i in shorts(data["lobes"]["look"])] == list(kind.lobes.types)
    assert np.array_equal(shorts(data["lobes"]["feature"]), kind.lobes.feature)
    assert np.allclose(np.cos(floats(data["lobes"]["half_angle"])), kind.lobes.cos_half, atol=1e-6)
    assert (data["features"]["sigma"], data["lobes"]["hit"], data["type"]["detector"]) == (None, None, None)


def test_a_learned_type_carries_what_was_measured(learned_kb):
    kind = learned_kb.types[0]
    data = type_document(learned_kb, kind)
    assert data["type"]["detector"] == "sift"
    assert np.allclose(floats(data["features"]["sigma"]), kind.learned.sigma, rtol=1e-6)
    assert np.allclose(floats(data["lobes"]["hit"]), kind.learned.hit, rtol=1e-6)
    assert len(floats(data["surface"]["uv"])) == 2 * 24
    assert data["surface"]["picture"]["media_type"] == "image/jpeg"
    assert data["notes"] == []


def test_a_type_of_nothing_has_a_page(tower_kb):
    kb, kind = bare(tower_kb)
    assert type_document(kb, kind)["notes"] == ["It has no mesh: only its features are drawn."]
    assert "nothing" in type_page(kb, kind)


def test_a_mesh_whose_texture_cannot_be_read_is_drawn_plain(tower_kb, tmp_path):
    broken = tmp_path / "mesh.obj"
    broken.write_text("f what\n")
    data = type_document(tower_kb, replace(tower_kb.types[0], mesh_file=broken))
    assert data["surface"]["picture"] is None
    assert len(shorts(data["surface"]["triangles"])) == 3 * len(tower_kb.types[0].surface.triangles)
    assert data["notes"][0].startswith("It is drawn without its texture: ")


def test_a_huge_cloud_is_thinned_evenly_and_says_so(tmp_path):
    kb = read_kb(write_learned(tmp_path, random_cloud(1, MOST_FEATURES + 3000, 2 * MOST_LOBES)))
    kind = kb.types[0]
    kept, data = chosen(kind), type_document(kb, kind)
    assert len(kept) <= MOST_FEATURES
    assert 0.7 * MOST_LOBES < len(shorts(data["lobes"]["look"])) <= MOST_LOBES
    assert np.ptp(np.diff(kept)) <= 1
    assert data["features"]["names"] == [kind.features[i].name for i in kept]
    assert shorts(data["lobes"]["feature"]).max() == len(kept) - 1
    assert f"{len(kept)} features, evenly chosen, are drawn and counted" in data["notes"][0]
    assert len(type_page(kb, kind)) < SMALL


def test_a_feature_with_more_lobes_than_can_be_drawn_ends():
    lobes = type("Table", (), {"feature": np.zeros(MOST_LOBES + 1, int)})
    assert list(chosen(type("Kind", (), {"seen_features": (None,), "lobes": lobes}))) == []


def test_the_limits_together_stay_small():
    """Bytes of a corner (place, texture coordinate), triangle, lobe and feature, as base64, and 300 kB for the rest."""
    arrays = MOST_DRAWN * (20 + 6) + MOST_LOBES * (2 * 2 + 7 * 4) + MOST_FEATURES * (2 * 2 + 4 * 4) + LARGEST_PICTURE
    assert arrays * 4 / 3 + 300_000 < SMALL
