"""Learned clouds that are kept: those used last stay, and nobody else's file is touched."""

import os
import time

from geometry.files.remembered import forget_files_beside


def kept(folder, number, age, size=10):
    """The file of a key, last used so many seconds ago."""
    path = folder / f"{number:064x}.npz"
    path.write_bytes(b"x" * size)
    os.utime(path, (time.time() - age,) * 2)
    return path


def test_the_files_used_last_stay_and_the_new_one_in_any_case(tmp_path):
    paths = [kept(tmp_path, i, age=100 * i) for i in range(6)]
    forget_files_beside(paths[5], files=3)
    assert sorted(tmp_path.iterdir()) == sorted([paths[5], paths[0], paths[1]])
    forget_files_beside(paths[0], most=15)
    assert list(tmp_path.iterdir()) == [paths[0]]
    forget_files_beside(paths[0], most=5)
    assert paths[0].exists()


def test_nothing_else_is_touched(tmp_path):
    place = kept(tmp_path, 0, age=0)
    others = [tmp_path / name for name in (f".{place.name}.abcdefgh", "mine.npz", f"{1:064x}.txt", ".hidden")]
    for path in others:
        path.write_bytes(b"x" * 100)
        os.utime(path, (0, 0))
    (tmp_path / f"{2:064x}.npz").mkdir()
    forget_files_beside(place, files=1, most=0)
    assert sorted(tmp_path.iterdir()) == sorted([place, *others, tmp_path / f"{2:064x}.npz"])
