"""Two new folders come in one step, wherever their writer ends."""

from __future__ import annotations

import os
import signal
import sys

import pytest

from sensing.errors import SensingError
from sensing.files import two_folders
from sensing.files.two_folders import finish, two_new_folders

EVENTS = "os.rename", "os.symlink", "os.remove", "os.rmdir"


def write(one, other):
    with two_new_folders(one, other) as (first, second):
        for folder in (first, second):
            folder.mkdir()
            (folder / "file").write_text(folder.name)


def killed(one, other, last):
    """Whether a writer was killed before the operation numbered ``last``, from 0."""
    pid = os.fork()
    if not pid:
        done = []

        def audited(event, _):
            if event in EVENTS:
                if len(done) == last:
                    os.kill(os.getpid(), signal.SIGKILL)
                done.append(event)

        sys.addaudithook(audited)
        write(one, other)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) != 0


def held(folder):
    return (folder / "file").read_text() if folder.exists() else None


@pytest.mark.parametrize("place", ["other", "deep/er/other"])
def test_a_reader_finds_both_or_none_after_every_kill_and_the_next_has_whole_folders(tmp_path, place):
    found, last = [], 0
    while last is not None:
        one, other = tmp_path / str(last) / "one", tmp_path / str(last) / place
        one.parent.mkdir()
        again = killed(one, other, last)
        found.append((held(one), held(other)))
        finish(one, other)
        assert (held(one), held(other)) == found[-1]
        if not one.exists():
            write(one, other)
        assert (held(one), held(other)) == ("one", "other")
        assert not one.is_symlink()
        assert not other.is_symlink()
        assert sorted(path.name for path in one.parent.iterdir()) == sorted(["one", place.split("/")[0]])
        assert [path.name for path in one.iterdir()] == ["file"]
        last = last + 1 if again else None
    assert set(found) == {(None, None), ("one", "other")}
    assert len(found) > 4


def test_where_the_system_exchanges_nothing_both_are_there_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(two_folders, "_exchanged", lambda *_: False)
    (tmp_path / "other").mkdir()
    write(tmp_path / "one", tmp_path / "other")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "other"]
    assert (held(tmp_path / "one"), held(tmp_path / "other")) == ("one", "other")
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["file"]


def test_what_goes_wrong_leaves_nothing(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("mine")
    with pytest.raises(SensingError, match="full: exists already and is not an empty folder"):
        write(tmp_path / "one", tmp_path / "full")
    with pytest.raises(ZeroDivisionError), two_new_folders(tmp_path / "one", tmp_path / "other"):
        _ = 1 / 0
    assert [path.name for path in tmp_path.iterdir()] == ["full"]


def test_a_link_of_somebody_else_is_not_touched(tmp_path):
    (tmp_path / "other").symlink_to("nowhere")
    finish(tmp_path / "one", tmp_path / "other")
    assert (tmp_path / "other").is_symlink()
    with pytest.raises(SensingError, match="other: exists already and is not an empty folder"):
        write(tmp_path / "one", tmp_path / "other")
    assert [path.name for path in tmp_path.iterdir()] == ["other"]
