"""Parts with what they hold: every Feature node is counted once, at the nearest object above it."""

from __future__ import annotations

from collections import Counter

from small_kb import write_small

from kb.files.folder import shipped
from kb.files.read import read_kb
from kb.shown.show import part_of_features, part_rows


def test_compound_features_and_their_parts_count_in_their_part(tmp_path):
    kind = read_kb(write_small(tmp_path)).types[0]
    assert part_rows(kind) == [
        {"name": "tent", "under": None, "counts": {}},
        {"name": "roof", "under": 0, "counts": {"apex": 1, "corner": 2}},
        {"name": "body", "under": 0, "counts": {}},
    ]
    assert part_of_features(kind) == [1] * len(kind.features)


def test_the_towers_parts_hold_all_their_features():
    kinds = read_kb(shipped("towers")).types
    assert len(kinds) == 2
    for kind in kinds:
        rows = part_rows(kind)
        assert sum(sum(row["counts"].values()) for row in rows) == len(kind.all_features)
        assert [rows[part]["name"] for part in part_of_features(kind)] == [f.name.split("/")[0] for f in kind.features]
        assert Counter(f.name.split("/")[0] for f in kind.all_features) == {
            row["name"]: sum(row["counts"].values()) for row in rows[1:]
        }
