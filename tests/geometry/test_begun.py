"""What is begun beside its place: a killed writer's goes with the next that begins there, and nobody else's does."""

from __future__ import annotations

import os

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
        "place.plogic-begun-abcdefgh",
        ".plogic-lock",
        ".place.plogic-settings",
        ".place.plogic-begun-ABCDEFGH",
        ".a.plogic-begun-abcdefgh.txt",
    ]
    for name in names:
        (tmp_path / name).write_text("mine")
    sweep(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "swept").mkdir()
    (tmp_path / "swept" / ".a.plogic-begun-abcdefgh").symlink_to(tmp_path / "mine")
    sweep(tmp_path / "swept")
    assert (tmp_path / "mine").read_text() == "mine"


def test_a_name_as_long_as_a_name_may_be(tmp_path):
    place = tmp_path / ("ä" * 127)
    with file_beside(place, b"whole") as begun:
        begun.replace(place)
    assert place.read_bytes() == b"whole"
    assert list(tmp_path.iterdir()) == [place]


@pytest.mark.parametrize(
    ("mask", "new", "folder"), [(0o022, 0o644, 0o755), (0o077, 0o600, 0o700), (0o002, 0o664, 0o775)]
)
def test_who_may_read_it_is_what_the_user_has_set(tmp_path, mask, new, folder):
    before = os.umask(mask)
    try:
        with file_beside(tmp_path / "new", b"") as begun:
            assert begun.stat().st_mode & 0o777 == new
        with folder_beside(tmp_path / "folder") as begun:
            assert begun.stat().st_mode & 0o777 == folder
        (tmp_path / "old").touch()
        (tmp_path / "old").chmod(0o640)
        with file_beside(tmp_path / "old", b"") as begun:
            assert begun.stat().st_mode & 0o777 == 0o640
    finally:
        os.umask(before)
