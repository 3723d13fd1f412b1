"""An output that is a link, a device or a pipe stays one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest

from sensing.errors import SensingError
from sensing.files.whole_files import check_places, write_files, write_folder, write_whole


def test_a_link_stays_and_what_it_leads_to_is_written(tmp_path):
    link = tmp_path / "link"
    link.symlink_to("real")
    write_whole(link, b"whole")
    assert link.readlink().name == "real"
    assert (tmp_path / "real").read_bytes() == b"whole"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link", "real"]


def test_a_pipe_is_written_into(tmp_path):
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write_whole(pipe, b"much" * 100_000)
    reader.join()
    assert got == [b"much" * 100_000]
    assert pipe.is_fifo()


def test_a_full_device_is_told_and_no_other_file_is_written(tmp_path):
    full = tmp_path / "full"
    full.symlink_to("/dev/full")
    check_places([full])
    with pytest.raises(SensingError, match="full: cannot be written: No space left on device"):
        write_files({tmp_path / "other": b"x", full: b"x"})
    assert [p.name for p in tmp_path.iterdir()] == ["full"]
    assert full.is_char_device()


@pytest.mark.parametrize("name", ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"])
def test_what_is_open_already_is_gone_on_with_be_it_a_file(tmp_path, name):
    (tmp_path / "log").write_text("before\n")
    code = f"from pathlib import Path; from sensing.files.whole_files import write_whole; write_whole(Path({name!r}), b'whole')"
    with (tmp_path / "log").open("a") as log:
        subprocess.run([sys.executable, "-c", code], stdout=log, check=True)
    assert (tmp_path / "log").read_text() == "before\nwhole"


@pytest.mark.parametrize("place", ["read.json", "link", "kb/kb.yaml", "to the kb/kb.yaml"])
def test_no_place_is_what_is_read_or_lies_in_it(tmp_path, place):
    (tmp_path / "kb").mkdir()
    for name in ("read.json", "kb/kb.yaml"):
        (tmp_path / name).write_text("mine")
    (tmp_path / "link").symlink_to("read.json")
    (tmp_path / "to the kb").symlink_to("kb")
    read = [None, "no such file", tmp_path / "read.json", tmp_path / "kb"]
    with pytest.raises(SensingError, match=f"{place}: is read, too"):
        check_places([tmp_path / place], read)
    check_places([tmp_path / "kb/page.html", tmp_path / "new.json"], read)


def test_the_working_folder_may_be_the_new_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_folder(Path(), {"a": b"1", "deep/b": b"2"}, empty=["c"])
    assert sorted(path.name for path in Path().iterdir()) == ["a", "c", "deep"]
    with pytest.raises(SensingError, match="not an empty folder"):
        write_folder(Path(), {"d": b""})


def test_a_link_that_leads_nowhere_is_no_place_for_a_folder(tmp_path):
    (tmp_path / "link").symlink_to("nowhere")
    with pytest.raises(SensingError, match="exists already"):
        write_folder(tmp_path / "link", {"a": b""})
