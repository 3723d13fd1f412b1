"""Whatever a path is, what forbids to read it is a few words, never an exception."""

import os
from pathlib import Path

import pytest

from geometry.files.plain_files import fault_of, is_there


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
