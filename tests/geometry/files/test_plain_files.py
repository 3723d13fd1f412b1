"""Whatever a path is, what forbids to read it is a few words, never an exception."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from geometry.files import plain_files
from geometry.files.plain_files import content_of, fault_of, is_there


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "good").write_text("12345")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "nowhere").symlink_to(tmp_path / "gone")
    os.mkfifo(tmp_path / "pipe")
    return tmp_path


FAULTS = {
    "good": (None, True),
    "good/below": ("is missing", False),
    "gone": ("is missing", False),
    "nowhere": ("is missing", True),
    "loop": ("is a link that leads back to itself", True),
    "pipe": ("is no plain file, but a pipe or a device", True),
    ".": ("is a folder, not a file", True),
    "n" * 300: ("has a name that is too long for a file", False),
    "a/" * 3000: ("has a name that is too long for a file", False),
    "nul\0": ("has a name that no file can have", False),
}


@pytest.mark.parametrize("name", FAULTS, ids=[repr(name[:12]) for name in FAULTS])
def test_a_fault_is_a_few_words(folder, name):
    assert (fault_of(folder / name), is_there(folder / name)) == FAULTS[name]


def test_the_limit_is_said(folder):
    assert fault_of(folder / "good", 5) is None
    assert fault_of(folder / "good", 4) == "has 5 bytes, more than the 4 that are read"


def test_what_may_not_be_read_says_so(folder, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, _: Path(path).name != "good")
    assert fault_of(folder / "good") == "cannot be read: Permission denied"


@pytest.mark.parametrize("name", FAULTS, ids=[repr(name[:12]) for name in FAULTS])
def test_what_cannot_be_read_is_one_line(folder, name, monkeypatch):
    monkeypatch.setattr(plain_files, "SILENCE", 0.01)
    if FAULTS[name][0] is None:
        assert content_of(folder / name, 5, OSError) == b"12345"
    else:
        with pytest.raises(LookupError, match=r"cannot be read|no file can have|nothing came through this pipe"):
            content_of(folder / name, 5, LookupError)


def test_what_never_ends_is_not_read(folder):
    (folder / "zeros").symlink_to("/dev/zero")
    for name in ("/dev/zero", str(folder / "zeros"), "/dev/null"):
        with pytest.raises(LookupError, match=f"{name}: is a device, not a file"):
            content_of(name, 5, LookupError)


def test_no_more_than_the_limit_is_read(folder):
    with pytest.raises(LookupError, match="good: has 5 bytes, more than the 4 that are read"):
        content_of(folder / "good", 4, LookupError)


def test_a_pipe_is_read_to_its_end_and_no_further_than_the_limit(folder):
    pipe = folder / "pipe"
    with ThreadPoolExecutor() as pool:
        pool.submit(pipe.write_bytes, b"x" * 300_000)
        assert content_of(pipe, 300_000, LookupError) == b"x" * 300_000
        written = pool.submit(pipe.write_bytes, b"x" * 300_000)
        with pytest.raises(LookupError, match="pipe: has more than the 10 bytes that are read"):
            content_of(pipe, 10, LookupError)
        assert written.done() or written.exception() is not None  # nobody reads the rest


def test_a_pipe_that_falls_silent_is_given_up(folder, monkeypatch):
    monkeypatch.setattr(plain_files, "SILENCE", 0.05)
    writer = os.open(folder / "pipe", os.O_RDWR)
    os.write(writer, b"some")
    with pytest.raises(LookupError, match=r"pipe: nothing came through this pipe for 0.05 s"):
        content_of(folder / "pipe", 10, LookupError)
    os.close(writer)
