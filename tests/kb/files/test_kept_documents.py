"""Documents kept between runs: they say the same, and a mistake beside them is told at the same place."""

import os

import pytest
from small_kb import KB, MESH, OBJECT, write_small

from kb.errors import KBErrors
from kb.files import kept_documents, kept_surfaces
from kb.files.folder import shipped, shipped_names
from kb.files.read import read_kb
from kb.shown.show import tree_document


def all_of(kb):
    """All that the documents of a knowledge base decide."""
    turns = [
        [kind.stands, [(f.name, f.at.tolist(), f.rotation.tolist()) for f in kind.all_features]] for kind in kb.types
    ]
    return tree_document(kb), kb.rates, kb.gravity, kb.maybe, kb.unknown_support, kb.ground, kb.digest, turns


def kept(folder):
    return sorted(path.name for path in (folder / "documents").glob("*"))


def nobody(*_):
    raise AssertionError("it was read before")


GRAVITY = ["", "gravity: true\n", "gravity: maybe\n", "gravity: {rests: 0.7, ground: 2 cm}\n"]


@pytest.mark.parametrize("said", GRAVITY)
def test_the_second_run_reads_no_yaml_and_asks_no_model(tmp_path, monkeypatch, said):
    text = OBJECT.replace("symmetries", "stands: [{down: [0, 0, -1], weight: 2}]\nsymmetries")
    folder = write_small(tmp_path / "kb", kb=KB + said, object=text)
    fresh, first = read_kb(folder), read_kb(folder, tmp_path)
    monkeypatch.setattr(kept_documents, "_checked", nobody)
    assert all_of(read_kb(folder, tmp_path)) == all_of(first) == all_of(fresh)
    assert len(kept(tmp_path)) == 1


def test_those_that_come_with_plogic_are_the_same(tmp_path):
    names = shipped_names()
    twice = [all_of(read_kb(shipped(name), tmp_path)) for name in names + names]
    assert twice == [all_of(read_kb(shipped(name))) for name in names] * 2
    assert len(kept(tmp_path)) == len(names) > 2


def test_a_mistake_beside_kept_documents_is_told_at_its_line(tmp_path):
    folder = write_small(tmp_path / "kb")
    read_kb(folder, tmp_path)
    (folder / "objects/tent/mesh.obj").write_text(MESH.replace("f", "# f"))
    told = []
    for place in (None, tmp_path):
        with pytest.raises(KBErrors) as error:
            read_kb(folder, place)
        told.append(str(error.value))
    assert told[0] == told[1]
    assert "object.yaml:2:" in told[0]


def test_documents_with_a_mistake_are_not_kept(tmp_path):
    folder = write_small(tmp_path / "kb", kb=KB.replace("sigma: 1.5", "sigma: -1"))
    for _ in range(2):
        with pytest.raises(KBErrors, match="from 1e-6 to 1e9"):
            read_kb(folder, tmp_path)
    assert kept(tmp_path) == []


@pytest.mark.parametrize("changed", ["kb", "object", "name", "code"])
def test_what_decides_what_they_say_is_in_their_key(tmp_path, monkeypatch, changed):
    folder = write_small(tmp_path / "kb")
    read_kb(folder, tmp_path)
    path = folder / ("kb.yaml" if changed == "kb" else "objects/tent/object.yaml")
    path.write_text(path.read_text() + "# more\n" * (changed in ("kb", "object")))
    if changed == "name":
        path.parent.rename(path.parent.with_name("other"))
    if changed == "code":
        kept_surfaces.read_by.cache_clear()
        monkeypatch.setattr(kept_surfaces, "source_digest", lambda *_: b"other code")
    read_kb(folder, tmp_path)
    kept_surfaces.read_by.cache_clear()
    assert len(kept(tmp_path)) == 2


def test_a_folder_whose_name_is_no_text_is_read_and_kept(tmp_path):
    folder = write_small(tmp_path / "kb")
    (objects,) = {path.parent for path in folder.glob("objects/*/object.yaml")}
    objects.rename(objects.with_name(os.fsdecode(b"odd\xff")))
    assert all_of(read_kb(folder, tmp_path)) == all_of(read_kb(folder, tmp_path)) == all_of(read_kb(folder))
