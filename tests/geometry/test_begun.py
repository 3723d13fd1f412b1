"""What is begun beside its place: a killed writer's goes with the next that begins there, and nobody else's does."""

from __future__ import annotations

import pytest
from killed_processes import killed_while

from geometry.files.begun import file_beside, folder_beside, left_in, scratch, sweep


@pytest.mark.parametrize("begin", [lambda place: file_beside(place, b"half"), folder_beside], ids=["file", "folder"])
def test_a_killed_writers_goes_and_a_living_ones_stays(begin, tmp_path):
    with killed_while(lambda: begin(tmp_path / "place")):
        (begun,) = tmp_path.iterdir()
        sweep(tmp_path)
        assert list(tmp_path.iterdir()) == [begun], "its writer is alive"
    assert begun.exists()
    with begin(tmp_path / "other") as mine:
        assert list(tmp_path.iterdir()) == [mine], "the next that begins anything there sweeps"
    assert list(tmp_path.iterdir()) == []


def test_scratch_is_its_users_alone_and_swept_where_it_lies(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with killed_while(scratch):
        (left,) = tmp_path.iterdir()
        assert left.stat().st_mode & 0o777 == 0o700
    (left / "deep").mkdir()
    (left / "deep" / "file").write_text("half")
    assert left_in(tmp_path) == [left]
    with scratch() as mine:
        assert list(tmp_path.iterdir()) == [mine]
        assert left_in(tmp_path) == []
    assert list(tmp_path.iterdir()) == []


def test_nothing_of_another_name_is_touched(tmp_path):
    names = [
        ".place.abcdefgh",
        "place.plogic-abcdefgh",
        ".plogic-lock",
        ".place.plogic-ABCDEFGH",
        ".a.plogic-abcdefgh.txt",
    ]
    for name in names:
        (tmp_path / name).write_text("mine")
    sweep(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "swept").mkdir()
    (tmp_path / "swept" / ".a.plogic-abcdefgh").symlink_to(tmp_path / "mine")
    sweep(tmp_path / "swept")
    assert (tmp_path / "mine").read_text() == "mine"


def test_a_name_as_long_as_a_name_may_be(tmp_path):
    place = tmp_path / ("ä" * 127)
    with file_beside(place, b"whole") as begun:
        begun.replace(place)
    assert place.read_bytes() == b"whole"
    assert list(tmp_path.iterdir()) == [place]
