"""A knowledge base is made ready once and serves any number of images, from several processes and threads too."""

from __future__ import annotations

import shutil
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context

import pytest
from sent import sent

import plogic
from kb.files.folder import shipped
from plogic import KnowledgeBase, perceive
from plogic.run.perceive import Perceiver


def interpreted(file, kb):
    """What a worker gives: the interpretation, and whether the KB that it has is the one it had before."""
    return perceive(file, kb), id(kb.perceiver())


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_workers_give_what_one_process_gives(start, first, scene, gamma_file):
    with ProcessPoolExecutor(2, mp_context=get_context(start)) as pool:
        found = list(pool.map(partial(interpreted, kb=first), [gamma_file] * 4))
    assert [document == scene for document, _ in found] == [True] * 4
    assert len({perceiver for _, perceiver in found}) <= 2


def test_it_is_made_ready_once(gamma_file, scene, monkeypatch):
    made = []
    monkeypatch.setattr("plogic.run.perceive.Perceiver", lambda *args: made.append(args) or Perceiver(*args))
    kb = KnowledgeBase.load("first").ready()
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda file: perceive(file, kb), [gamma_file] * 6))
    assert [one == scene for one in found] == [True] * 6
    assert len(made) == 1


def test_a_folder_that_has_changed_is_told(tmp_path):
    shutil.copytree(shipped("first"), tmp_path / "kb")
    kb = KnowledgeBase.load(tmp_path / "kb")
    assert sent(kb) == kb
    assert sent(kb) is sent(kb)
    (tmp_path / "kb" / "kb.yaml").write_text((tmp_path / "kb" / "kb.yaml").read_text() + "# more\n")
    with pytest.raises(plogic.Error, match="has changed since"):
        plogic.face.python.knowledge._again.__wrapped__(str(tmp_path / "kb"), kb.digest)
