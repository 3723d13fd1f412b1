"""A knowledge base that is changed: readers see the old or the new, whoever is killed, and writers take turns."""

from __future__ import annotations

import os
import shutil

import pytest
from killed_processes import killed_while
from small_kb import OBJECT, write_small

from kb.errors import BusyError, KBError
from kb.files import changes
from kb.files.changes import CHANGE, LOCK, holder, settle, writing
from kb.files.folder import Folder
from kb.files.read import read_kb

FEWER = OBJECT.replace("  - part: body\n    features: []\n", "")


class EndedError(Exception):
    """The writer came to its end."""


def new_files(root):
    """Of a change of two files and a new type."""
    text = (root / "kb.yaml").read_text()
    other = FEWER.replace("object: tent", "object: hut")
    return {
        root / "kb.yaml": text.replace("sigma: 1.5", "sigma: 2.5").encode(),
        root / "objects/tent/object.yaml": FEWER.encode(),
        root / "objects/hut/object.yaml": other.encode(),
        root / "objects/hut/mesh.obj": (root / "objects/tent/mesh.obj").read_bytes(),
    }


@pytest.fixture
def small(tmp_path):
    """A knowledge base, its digest, and that of the same after the change."""
    root = write_small(tmp_path / "kb")
    shutil.copytree(root, tmp_path / "new")
    with writing(tmp_path / "new") as writer:
        writer.change(new_files(tmp_path / "new"))
    return root, read_kb(root).digest, read_kb(tmp_path / "new").digest


def cut_short(root, monkeypatch, moved):
    """Change it, by a writer that ends when so many files are moved."""
    with monkeypatch.context() as patched:
        patched.setattr(changes, "_move", lambda _: None)
        with writing(root) as writer:
            writer.change(new_files(root))
    files = sorted(path for path in (root / CHANGE).rglob("*") if path.is_file())
    for path in files[:moved]:
        target = root / path.relative_to(root / CHANGE)
        target.parent.mkdir(exist_ok=True)
        path.replace(target)
    assert len(files) == 4


@pytest.mark.parametrize("moved", range(5))
def test_the_next_reader_finds_the_new_and_moves_it(small, monkeypatch, moved):
    root, old, new = small
    assert old != new
    cut_short(root, monkeypatch, moved)
    assert read_kb(root).digest == new
    assert not list(root.rglob(".*"))
    assert (root / "objects/hut/mesh.obj").is_file()


@pytest.mark.parametrize("moved", range(5))
def test_who_may_not_write_reads_the_new_where_it_lies(small, monkeypatch, moved):
    root, _, new = small
    cut_short(root, monkeypatch, moved)

    def refused(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(changes, "_locked", refused)
    kb = read_kb(root)
    assert kb.digest == new
    assert {kind.name for kind in kb.types} == {"tent", "hut"}
    assert (root / CHANGE).is_dir()


def test_a_change_in_the_midst_of_reading_is_read_whole(small, monkeypatch):
    root, _, new = small
    read, content = [], Folder.content

    def slow(self, path, *more):
        read.append(path)
        if len(read) == 2:
            with writing(root) as writer:
                writer.change(new_files(root))
        return content(self, path, *more)

    monkeypatch.setattr(Folder, "content", slow)
    assert read_kb(root).digest == new
    assert len(read) > 4, "it was read again"


def test_a_second_writer_is_told_who_the_first_is(small):
    root, old, _ = small
    with killed_while(lambda: writing(root)) as other:
        assert holder(root) == other
        with pytest.raises(BusyError, match=rf"^\S+kb: process {other} is changing it: wait until it has ended$"):
            writing(root, 0.0).__enter__()
        assert read_kb(root).digest == old, "who reads need not wait"
    assert holder(root) is None
    assert (root / LOCK).is_file(), "it was killed"
    settle(root)
    assert not (root / LOCK).exists()


def test_a_writer_that_fails_changes_nothing(small):
    root, old, _ = small
    with pytest.raises(EndedError), writing(root):
        raise EndedError
    assert read_kb(root).digest == old
    assert not list(root.rglob(".*"))


def test_nothing_is_written_outside(small, tmp_path):
    root, old, _ = small
    with writing(root) as writer, pytest.raises(KBError, match="leads out"):
        writer.change({root / "../elsewhere.yaml": b"x"})
    (tmp_path / "outside").mkdir()
    (root / "link").symlink_to(tmp_path / "outside")
    (root / CHANGE / "link").mkdir(parents=True)
    (root / CHANGE / "link" / "evil").write_text("x")
    settle(root)
    assert list((tmp_path / "outside").iterdir()) == []
    (tmp_path / "outside" / "kb.yaml").write_text("mine")
    (root / CHANGE).symlink_to(tmp_path / "outside")
    assert read_kb(root).digest == old
    assert (tmp_path / "outside" / "kb.yaml").read_text() == "mine"


def test_what_a_writer_began_is_swept_by_the_next(small):
    root, old, _ = small
    with killed_while(lambda: changes.folder_beside(root / CHANGE)):
        (begun,) = root.glob(".plogic-change.*")
    assert begun.exists()
    with writing(root):
        assert not begun.exists()
    assert read_kb(root).digest == old


@pytest.mark.parametrize("kind", ["another name", "link", "folder", "pipe"])
def test_what_stands_in_the_place_of_the_lock_is_not_written_over(small, tmp_path, kind):
    root, digest, _ = small
    (tmp_path / "mine").write_text("mine")
    lock = root / LOCK
    {
        "another name": lambda: lock.hardlink_to(tmp_path / "mine"),
        "link": lambda: lock.symlink_to(tmp_path / "mine"),
        "folder": lock.mkdir,
        "pipe": lambda: os.mkfifo(lock),
    }[kind]()
    with pytest.raises(KBError, match=r"\.plogic-lock: is no lock that plogic made"), writing(root):
        pass
    assert read_kb(root).digest == digest
    assert (tmp_path / "mine").read_text() == "mine"


def test_a_change_that_no_writer_left_harms_nothing(small):
    root, digest, _ = small
    (root / CHANGE).mkdir()
    (root / CHANGE / "objects").write_text("a file where the folder is")
    settle(root)
    assert not (root / CHANGE).exists()
    assert read_kb(root).digest == digest
