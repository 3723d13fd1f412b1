"""``size`` of an appearance: how wide it is that the detector's scale is the picture of."""

import math

import pytest
from small_kb import write_small
from written_kb import write_kb

from kb.errors import KBErrors
from kb.files.read import read_kb
from kb.shown.show import tree_document


def with_size(folder, size):
    path = write_small(folder)
    (found,) = path.rglob("object.yaml")
    found.write_text(found.read_text().replace("- {type: ", f"- {{size: {size}, type: ", 1))
    assert f"size: {size}" in found.read_text()
    return path


def sizes(kb):
    return [a.lobe.size for kind in kb.types for f in kind.features for a in f.appearances]


def test_it_is_read_written_and_shown(tmp_path):
    kb = read_kb(with_size(tmp_path / "a", "3 cm"))
    assert sizes(kb)[0] == 0.03
    assert all(math.isnan(size) for size in sizes(kb)[1:])
    assert kb.types[0].lobes.size[0] == 0.03
    write_kb(kb, tmp_path / "b")
    assert str(sizes(read_kb(tmp_path / "b"))) == str(sizes(kb))
    assert "'size': 0.03" in str(tree_document(kb))


@pytest.mark.parametrize("size", ["0 m", "-1 cm", "wide", "3"])
def test_what_is_no_width_is_a_mistake(tmp_path, size):
    with pytest.raises(KBErrors, match="size"):
        read_kb(with_size(tmp_path, f"'{size}'"))


def test_what_is_not_seen_itself_has_none(tmp_path):
    path = write_small(tmp_path)
    (found,) = path.rglob("object.yaml")
    text = found.read_text()
    lobe = text[text.index("{type: apex, lobe") :].splitlines()[0]
    found.write_text(text.replace(lobe, f"{{type: apex, size: 3 cm, appearances: [{lobe}]}}"))
    with pytest.raises(KBErrors, match=r"14:13: parts\.0\.features\.0\.appearances\.0: 'size' without 'lobe'"):
        read_kb(path)
