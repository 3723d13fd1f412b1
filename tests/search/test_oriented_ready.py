"""The index over many types, kept between runs: the same answers from the files as without them, found by content alone."""

import numpy as np
import pytest
from oriented_scenes import HARD, a_trial, clouds

from plogic.delta import Options
from plogic.perceive import Perceiver
from plogic.search.oriented import ready as under_test
from plogic.search.oriented.generate import Search
from plogic.search.oriented.ready import MANY, ready
from plogic.stopwatch import Stopwatch

LITTLE = {"count": MANY, "features": 12, "looks": 12}


def kept(folder):
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def made(folder, digest="some"):
    some = clouds(**LITTLE)
    return ready(some.kb.types, dict.fromkeys({f.type for kind in some.kb.types for f in kind.features}, 1.0), digest, folder)


def test_what_comes_from_the_files_is_what_was_made(tmp_path):
    first, second = made(tmp_path / "indices"), made(tmp_path / "indices")
    assert len(kept(tmp_path / "indices")) == 1
    assert isinstance(second.key, np.memmap)
    assert not isinstance(first.key, np.memmap)
    assert not second.key.flags.writeable
    for name in ("key", "entry", "turned"):
        assert np.array_equal(getattr(first, name), getattr(second, name))
    for name in ("feature", "looks", "xy", "angle", "diameter"):
        assert np.array_equal(getattr(first.sights, name), getattr(second.sights, name))
    for one, other in zip(first.indices, second.indices, strict=True):
        for name in ("directions", "cell_from_object", "xy", "visible", "centre", "diameter"):
            assert np.array_equal(getattr(one.cells, name), getattr(other.cells, name))
    some = clouds(**LITTLE)
    for seed in range(3):
        data = a_trial(some, seed)[2]
        answers = [Search(some.asked(data, index)).proposals(data) for index in (first, second)]
        assert len(answers[0]) == len(answers[1])
        assert all(a.kind == b.kind and np.array_equal(a.pose, b.pose) for a, b in zip(*answers, strict=True))


def test_other_types_or_other_code_are_made_anew(tmp_path, monkeypatch):
    made(tmp_path, "some")
    made(tmp_path, "some")
    assert len(kept(tmp_path)) == 1
    made(tmp_path, "others")
    assert len(kept(tmp_path)) == 2
    monkeypatch.setattr(under_test, "_source", lambda: "other code")
    made(tmp_path, "some")
    assert len(kept(tmp_path)) == 3


@pytest.mark.parametrize("harm", ["cut", "emptied", "gone", "no array"])
def test_what_cannot_be_read_is_made_anew(tmp_path, harm):
    first = made(tmp_path)
    file = next(tmp_path.iterdir()) / "key.npy"
    if harm == "gone":
        file.unlink()
    else:
        file.write_bytes({"cut": file.read_bytes()[:90], "emptied": b"", "no array": b"nothing of the kind"}[harm])
    assert np.array_equal(made(tmp_path).key, first.key)
    assert isinstance(made(tmp_path).key, np.memmap)
    assert len(kept(tmp_path)) == 1


def test_few_types_unknown_ones_and_places_that_cannot_be_written_are_not_kept(tmp_path):
    few = clouds(count=3, features=8, looks=8)
    ready(few.kb.types, dict.fromkeys({f.type for kind in few.kb.types for f in kind.features}, 1.0), "few", tmp_path)
    made(tmp_path, "")
    assert kept(tmp_path) == []
    (tmp_path / "file").write_text("no folder")
    assert len(made(tmp_path / "file").key) == len(made(None).key)
    assert (tmp_path / "file").read_text() == "no folder"


def test_a_perceiver_answers_alike_with_and_without(tmp_path):
    some = clouds(**LITTLE, detector=HARD)
    _, case, _ = a_trial(some, 4, HARD)
    answers = []
    for cache in (None, tmp_path, tmp_path):
        delta, _, _ = Perceiver(some.kb, cache).delta(case.gamma, Options(reading="posterior"), Stopwatch())
        answers.append({name: belief.posed.camera_from_object.tobytes() for name, belief in delta.beliefs.items()})
    assert answers[0] == answers[1] == answers[2]
    assert len(kept(tmp_path)) == 1
