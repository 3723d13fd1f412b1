"""The index over many types, kept between runs.

The same answers from the files as without them, found by content alone.
"""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from oriented_scenes import a_trial, clouds

from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.match.oriented.oriented_models import MANY, ready
from plogic.match.oriented.oriented_search import Search
from plogic.run.perceive import Perceiver

LITTLE = {"count": MANY, "features": 12, "looks": 12}
MORE = LITTLE | {"count": MANY + 2}
PAIRS, SIGHTS = ("key", "entry", "turned"), ("feature", "looks", "xy", "angle", "diameter")


def kept(folder):
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def made(folder, types=None):
    some = clouds(**LITTLE).kb.types if types is None else types
    return ready(some, dict.fromkeys({f.type for kind in some for f in kind.features}, 1.0), folder)


def the_same(first, second):
    """Whether two indices say the same of the same types, to the byte."""
    arrays = [(getattr(first, name), getattr(second, name)) for name in PAIRS]
    arrays += [(getattr(first.sights, name), getattr(second.sights, name)) for name in SIGHTS]
    for one, other in zip(first.indices, second.indices, strict=True):
        arrays += [
            (getattr(one.cells, name), getattr(other.cells, name))
            for name in ("directions", "cell_from_object", "xy", "visible", "centre")
        ]
    names = [[index.object_type.name for index in side.indices] for side in (first, second)]
    return (
        names[0] == names[1]
        and first.looks == second.looks
        and all(np.array_equal(a, b) and a.dtype == b.dtype for a, b in arrays)
    )


def test_what_comes_from_the_files_is_what_was_made(tmp_path):
    first, second = made(tmp_path / "indices"), made(tmp_path / "indices")
    assert len(kept(tmp_path / "indices")) == 1
    assert isinstance(second.key, np.memmap)
    assert not isinstance(first.key, np.memmap)
    assert not second.key.flags.writeable
    assert the_same(first, second)
    some = clouds(**LITTLE)
    for seed in range(3):
        data = a_trial(some, seed)[2]
        answers = [Search(some.asked(data, index)).proposals(data) for index in (first, second)]
        assert len(answers[0]) == len(answers[1])
        assert all(a.kind == b.kind and np.array_equal(a.pose, b.pose) for a, b in zip(*answers, strict=True))


@pytest.mark.parametrize(
    "chosen",
    [slice(None, None, -1), slice(2, None), slice(0, -2), slice(1, -1)],
    ids=["reversed", "two", "others", "ends"],
)
def test_types_in_another_order_or_fewer_of_them_have_an_index_of_their_own(tmp_path, chosen):
    types = clouds(**MORE).kb.types
    all_of_them = made(tmp_path, types)
    right = made(None, types[chosen])
    for mapped in (False, True):
        one = made(tmp_path, types[chosen])
        assert the_same(one, right)
        assert isinstance(one.key, np.memmap) == mapped
        assert len(kept(tmp_path)) == 2
    again = made(tmp_path, types)
    assert isinstance(again.key, np.memmap)
    assert the_same(again, all_of_them)


def rewritten(change):
    """A harm: an array put in the place of one, a valid file."""
    return lambda file: np.save(file, change(np.load(file)))


def flipped(file):
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)


HARMS = {
    "half of it": rewritten(lambda a: a[: len(a) // 2]), "zeros": rewritten(np.zeros_like), "narrower": rewritten(lambda a: a[..., :1]),
    "other type": rewritten(lambda a: a.astype(complex)), "no number": rewritten(lambda a: np.full(a.shape, np.nan)), "one bit": flipped,
    "cut": lambda file: file.write_bytes(file.read_bytes()[:90]), "gone": lambda file: file.unlink(),
}  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with one index kept, and that index."""
    folder = tmp_path_factory.mktemp("whole")
    return folder, made(folder)


@pytest.mark.parametrize("name", ["key", "entry", "sights_looks", "sights_diameter", "cells_xy"])
@pytest.mark.parametrize("harm", HARMS.values(), ids=HARMS)
def test_what_is_harmed_is_made_anew(tmp_path, whole, name, harm):
    folder, first = whole
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    harm(next(tmp_path.iterdir()) / f"{name}.npy")
    again = made(tmp_path)
    assert the_same(again, first)
    assert not isinstance(again.key, np.memmap)
    third = made(tmp_path)
    assert isinstance(third.key, np.memmap)
    assert the_same(third, first)
    assert len(kept(tmp_path)) == 1


def test_few_types_and_places_that_cannot_be_written_are_not_kept(tmp_path):
    few = clouds(count=3, features=8, looks=8).kb.types
    made(tmp_path, few)
    assert kept(tmp_path) == []
    (tmp_path / "file").write_text("no folder")
    assert len(made(tmp_path / "file").key) == len(made(None).key)
    assert (tmp_path / "file").read_text() == "no folder"


def answer_of(kb, cache, gamma):
    delta, _, _ = Perceiver(kb, cache).delta(gamma, Options(reading="posterior"), Stopwatch())
    return {belief.object_type.name: belief.camera_from_object.tobytes() for belief in delta.beliefs.values()}


def test_a_perceiver_answers_alike_with_and_without_whatever_was_kept_before(tmp_path):
    some = clouds(**MORE | {"features": 40}, appearances=60)
    _, case, _ = a_trial(some, 4, appearances=60)
    whole, turned, fewer = (
        replace(some.kb, types=some.kb.types[chosen]) for chosen in (slice(None), slice(None, None, -1), slice(2, None))
    )
    answers = [answer_of(kb, cache, case.gamma) for kb, cache in [(whole, None), (whole, tmp_path), (whole, tmp_path)]]
    assert case.truth.type in answers[0]
    assert answers[0] == answers[1] == answers[2]
    for kb in (turned, fewer):
        assert answer_of(kb, tmp_path, case.gamma) == answer_of(kb, None, case.gamma)
    assert len(kept(tmp_path)) == 2, "the order of types is none of what is kept"
