"""The benchmark's own frames, and how it tells bytes apart."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.batch import frames as batch_frames
from benchmarks.batch.bench import differing
from benchmarks.batch.frames import APPEARANCES, gamma, write_frames
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.facts.interpretation import text_of
from plogic.run.batch.frame_lines import Lines
from plogic.run.batch.frames import Frame, Settings, frames_of


@pytest.fixture(scope="module")
def kb():
    """The towers."""
    return read_kb(shipped("towers"))


def test_a_frame_is_that_of_its_seed_and_holds_what_detectors_report(kb):
    made = [gamma(kb, np.random.default_rng([5000, i])) for i in range(12)]
    assert made[3].appearances == gamma(kb, np.random.default_rng([5000, 3])).appearances
    for each in made:
        assert len(each.appearances) >= APPEARANCES[0]
        assert {a.type for a in each.appearances} <= set(kb.appearance_types)
        assert each.camera.contains(np.array([a.uv for a in each.appearances])).all()


def test_the_folder_is_as_many_frames_one_of_them_a_picture(kb, tmp_path, monkeypatch):
    monkeypatch.setattr(batch_frames, "RENDERED", 3)
    write_frames(kb, 4, 5000, tmp_path / "frames", lambda _: None)
    assert [frame.kind for frame in frames_of([str(tmp_path / "frames")], ())] == ["gamma", "gamma", "image", "gamma"]


def test_other_bytes_are_told_apart():
    lines = Lines(Settings("towers", full=True), {"name": "towers", "digest": "d"})
    documents = [{"format": "interpretation/1", "ä": i / 3} for i in range(3)]
    texts = [text_of(document).encode() for document in documents]
    written = [lines.perceived(Frame("a.png", None, "lost"), document, None)[1] for document in documents]
    assert json.loads(written[1])["interpretation"] == documents[1]
    assert differing(texts, written) == 0
    assert differing(texts, written[:2]) == 1
    assert differing(texts, [written[0], written[2], written[1]]) == 2
