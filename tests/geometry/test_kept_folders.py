"""Arrays kept in folders: a changed one is made anew, the least used goes, and nobody else's is touched."""

import os
import shutil
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from killed_processes import killed_while

from geometry.files.begun import folder_beside
from geometry.files.remembered import FOLDERS, MANIFEST, arrays_of, forget_beside

KEY, OTHER = "ab" * 32, "cd" * 32
ARRAYS = {"one": np.arange(600.0).reshape(200, 3), "two": np.arange(50, dtype=np.uint8), "none": np.zeros((3, 0))}


def asked(place, made=None):
    """What is kept there, or made; ``made`` counts how often."""
    return arrays_of(place, ARRAYS, lambda: (made.append(1) if made is not None else None) or ARRAYS)


def right(arrays):
    return arrays.keys() == ARRAYS.keys() and all(
        np.array_equal(arrays[k], ARRAYS[k]) and arrays[k].dtype == ARRAYS[k].dtype for k in ARRAYS
    )


def harm_bit(offset):
    def harm(place):
        content = bytearray((place / "one.npy").read_bytes())
        content[offset] ^= 1
        (place / "one.npy").write_bytes(content)

    return harm


def put(content):
    return lambda place: (place / "one.npy").write_bytes(content(place / "one.npy"))


def as_file(place):
    shutil.rmtree(place)
    place.write_text("x")


def as_folder(place):
    (place / "one.npy").unlink()
    (place / "one.npy").mkdir()


def as_npz(place):
    with (place / "one.npy").open("wb") as file:
        np.savez(file, one=ARRAYS["one"])


def manifest(content):
    return lambda place: (place / MANIFEST).write_bytes(content)


HARMS = {
    "a bit of the header": harm_bit(20),
    "a bit of the data": harm_bit(-1),
    "a bit in the middle": harm_bit(1000),
    "cut": put(lambda file: file.read_bytes()[:-100]),
    "longer": put(lambda file: file.read_bytes() + b"\0"),
    "empty": put(lambda _: b""),
    "no array": put(lambda _: b"nothing of the kind"),
    "a header that is no header": put(lambda file: file.read_bytes()[:10] + b"{" * 118 + file.read_bytes()[128:]),
    "a version that nobody knows": put(lambda file: b"\x93NUMPY\x09\x00" + file.read_bytes()[8:]),
    "strings": lambda place: np.save(place / "one.npy", np.array(["a", "b"])),
    "one number": lambda place: np.save(place / "one.npy", np.array(3)),
    "pickled": lambda place: np.save(place / "one.npy", np.array([{}], object), allow_pickle=True),
    "single precision": lambda place: np.save(place / "one.npy", ARRAYS["one"].astype(np.float32)),
    "transposed": lambda place: np.save(place / "one.npy", np.ascontiguousarray(ARRAYS["one"].T)),
    "nobody's number": lambda place: np.save(place / "one.npy", ARRAYS["one"] * np.nan),
    "packed": as_npz,
    "gone": lambda place: (place / "one.npy").unlink(),
    "a folder": as_folder,
    "a file in the place of the folder": as_file,
    "an empty folder": lambda place: [file.unlink() for file in place.iterdir()],
    "pipes": lambda place: [(file.unlink(), os.mkfifo(file)) for file in place.iterdir()],
    "brackets": manifest(b"[" * 100_000),
    "no manifest": lambda place: (place / MANIFEST).unlink(),
    "an empty manifest": manifest(b""),
    "a manifest of something else": manifest(b'{"key": 3}'),
    "a manifest that is no text": manifest(b"\xff\xfe["),
    "the folder of another key": lambda place: (
        asked(place.parent / OTHER),
        shutil.rmtree(place),
        (place.parent / OTHER).rename(place),
    ),
}


@pytest.mark.parametrize("harm", HARMS.values(), ids=HARMS)
def test_what_is_harmed_is_made_anew_and_put_in_its_place(tmp_path, harm):
    place, made = tmp_path / KEY, []
    asked(place, made)
    assert right(asked(place, made))
    assert len(made) == 1
    harm(place)
    assert right(asked(place, made))
    assert len(made) == 2
    found = asked(place, made)
    assert right(found)
    assert len(made) == 2
    assert all(isinstance(array, np.memmap) and not array.flags.writeable for array in found.values())
    assert [path.name for path in tmp_path.iterdir()] == [KEY], "nothing is left beside it"


def test_what_cannot_be_made_is_the_callers_to_hear_of(tmp_path):
    with pytest.raises(ZeroDivisionError):
        arrays_of(tmp_path / KEY, ARRAYS, lambda: 1 / 0)
    assert list(tmp_path.iterdir()) == []


def aged(folder, number, seconds, size=10):
    """A kept folder of so many bytes that was used so long ago."""
    place = folder / f"{number:064x}"
    place.mkdir()
    (place / "one.npy").write_bytes(b"x" * size)
    then = time.time() - seconds
    os.utime(place, (then, then))
    return place


def test_those_used_last_stay(tmp_path):
    places = [aged(tmp_path, i, 1000 - i) for i in range(FOLDERS + 3)]
    forget_beside(places[0])
    assert sorted(tmp_path.iterdir()) == sorted([places[0], *places[-(FOLDERS - 1) :]]), (
        "the one that was just written is one of them"
    )


def test_they_take_no_more_than_so_many_bytes_but_one_always_stays(tmp_path):
    places = [aged(tmp_path, i, i, 100) for i in range(6)]
    forget_beside(places[0], most=350)
    assert sorted(tmp_path.iterdir()) == places[:3]
    forget_beside(places[0], most=5)
    assert list(tmp_path.iterdir()) == places[:1]


def test_what_is_read_is_used(tmp_path):
    first = tmp_path / KEY
    asked(first)
    os.utime(first, (0, 0))
    for i in range(FOLDERS - 1):
        aged(tmp_path, i, 100 - i)
    asked(first)
    asked(tmp_path / OTHER)
    left = {path.name for path in tmp_path.iterdir()}
    assert len(left) == FOLDERS
    assert {KEY, OTHER} <= left
    assert f"{0:064x}" not in left


def test_nobody_elses_is_touched(tmp_path):
    foreign = [
        "notes",
        "f" * 63,
        "f" * 65,
        "F" * 64,
        "g" * 64,
        f"{KEY}.old",
        ".hidden",
        f".{KEY}",
        f".{KEY}-short",
        f"x{KEY}",
    ]
    for name in foreign:
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine").write_text("x")
        os.utime(tmp_path / name, (0, 0))
    (tmp_path / ("e" * 64)).write_text("a file")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / ("d" * 64)).symlink_to(tmp_path / "elsewhere")
    place = aged(tmp_path, 1, 0)
    forget_beside(place, folders=1, most=0)
    assert {path.name for path in tmp_path.iterdir()} == {*foreign, "e" * 64, "d" * 64, "elsewhere", place.name}
    assert all((tmp_path / name / "mine").read_text() == "x" for name in foreign)


def test_what_a_killed_process_began_goes_and_what_is_being_written_stays(tmp_path):
    with killed_while(lambda: folder_beside(tmp_path / OTHER)):
        (used,) = tmp_path.iterdir()
        (tmp_path / f".{KEY}.plogic-begun-abcdefgh").mkdir()
        (tmp_path / f".{KEY}.plogic-begun-abcdefgh" / "one.npy").write_bytes(b"half")
        asked(tmp_path / KEY)
        assert sorted(tmp_path.iterdir()) == sorted([used, tmp_path / KEY])


def test_who_has_mapped_what_goes_keeps_it(tmp_path):
    asked(tmp_path / KEY)
    mapped = asked(tmp_path / KEY)
    forget_beside(aged(tmp_path, 1, 0), folders=1)
    assert not (tmp_path / KEY).exists()
    assert right(mapped)


def test_many_at_once_all_have_the_right_answer(tmp_path):
    def work(number):
        place = tmp_path / f"{number % 3:064x}"
        answer = right(asked(place))
        if number % 5 == 0:
            shutil.rmtree(place, ignore_errors=True)
        forget_beside(place, folders=2)
        return answer and right(asked(place))

    with ThreadPoolExecutor(6) as pool:
        assert all(pool.map(work, range(120)))
    left = [path.name for path in tmp_path.iterdir()]
    assert len(left) <= 3
    assert not any(name.startswith(".") for name in left)
