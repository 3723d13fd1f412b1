"""An output that is a link, a device or a pipe stays one."""

from __future__ import annotations

import os
from threading import Thread

import pytest

from sensing.errors import SensingError
from sensing.files.whole_files import check_places, write_files, write_whole


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
