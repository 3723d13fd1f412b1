"""``plogic bench support`` end to end, on small scenes of a painted cube."""

from __future__ import annotations

import pytest
from console import plogic
from photo_folder import photos, ran

TWO = "support", "--count", "2"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return photos(tmp_path_factory.mktemp("one"), {"cube": 1})


def test_both_sides_are_counted_claimed_and_drawn(folder):
    found, done = ran(folder, *TWO, "--pictures", "pictures")
    rows = {row["row"]: row for row in found["rows"]}
    assert list(rows) == [
        f"{group}, {side}" for side in ("with support", "without") for group in ("printed, ycb", "all")
    ]
    assert {row["there"] for row in rows.values()} == {2}
    assert done.stderr.count("scene 4000") == 4
    assert [claim["bar"] for claim in found["claims"]] == [
        ">= 0.97",
        ">= 0.95",
        "<= 0.03",
        "<= 0.03",
        ">= 1.33333",
        "<= 0.6",
        "<= 0",
    ]
    assert sum(row["there"] for row in found["by tilt"]) == 2
    assert sorted(p.name for p in (folder / "pictures").iterdir()) == ["support_40000.png", "support_40001.png"]
    again, _ = ran(folder, *TWO)
    for row in (*found["rows"], *again["rows"]):
        del row["seconds"]
    assert found == again


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("support", "--simulated"), "`support` has no such parts; `photos` has"),
        (("box", "--count", "3"), "`box` has no such pictures; `photos` and `support` have"),
        (("box", "--pictures", "out"), "`box` draws none; `photos` and `support` do"),
    ],
)
def test_options_of_support(options, said):
    done = plogic("bench", *options)
    assert done.returncode == 2
    assert said in done.stderr


def test_without_models_it_says_where_they_should_be(tmp_path):
    done = plogic("bench", *TWO, "--kb", "kbs", cwd=tmp_path, PLOGIC_PHOTOS="nowhere")
    assert done.returncode == 1
    assert "PLOGIC_PHOTOS may name their folder" in done.stderr
