"""``plogic bench sizes``: its knowledge bases are without mistakes, and one scene of each goes both ways."""

from __future__ import annotations

import json

from benchmarks.sizes.bench import run
from benchmarks.sizes.types import SIZES, write_kb
from plogic.run.sources import kb_of


def test_the_knowledge_bases_have_three_solid_types_of_one_size_each(tmp_path):
    for name, size in (("small", 0.05), ("middle", 0.4), ("large", 6.0)):
        write_kb(name, tmp_path / name)
        surfaces = [kind.surface for kind in kb_of(str(tmp_path / name)).types]
        assert len(surfaces) == 3
        for surface in surfaces:
            assert surface is not None
            assert surface.solid is surface
            assert surface.volume > 0
            assert 0.7 * size < surface.diameter < 1.5 * size


def test_one_scene_of_each_size_is_perceived_from_gamma_and_from_the_picture():
    told: list[str] = []
    text, met = run(seed=0, quick=False, as_json=True, say=told.append, scenes=1)
    rows = json.loads(text)["rows"]
    assert [(row["kb"], row["from"]) for row in rows] == [(name, way) for name in SIZES for way in ("gamma", "picture")]
    assert [row["there"] for row in rows] == [2] * 6
    assert sum(row["found"] for row in rows) >= 9  # of 12; how often is the benchmark's own question
    claims = json.loads(text)["claims"]
    assert met == all(claim["met"] for claim in claims)
    assert len(claims) == 12
    assert len(told) == 3
