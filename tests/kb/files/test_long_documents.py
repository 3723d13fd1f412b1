"""A KB's files of tens of thousands of rows, each with a mistake.

All are said, at their places, and none costs a walk through the others.
"""

import pytest
from small_kb import KB, MESH, write_small

from kb.errors import KBErrors
from kb.files.branches import held, path_to, without
from kb.files.read import read_kb
from kb.files.yaml_text import load

MANY = 30_000


def mistakes(folder):
    with pytest.raises(KBErrors) as caught:
        read_kb(folder)
    return [str(mistake) for mistake in caught.value.mistakes]


def test_every_unknown_key_is_said_at_its_place(tmp_path):
    found = mistakes(write_small(tmp_path, kb=KB + "".join(f"k{i}: 1\n" for i in range(MANY))))
    lines = KB.count("\n")
    assert found == [f"kb.yaml:{lines + 1 + i}:1: k{i}: unknown key" for i in range(MANY)]


def test_every_name_given_twice_is_said_at_its_place(tmp_path):
    rows = "".join(f"  - {{feature: f{i // 2}, type: apex, at: [0, 0, 0]}}\n" for i in range(MANY))
    found = [
        line
        for line in mistakes(write_small(tmp_path, object=f"object: tent\nfeatures:\n{rows}"))
        if "another feature" in line
    ]
    assert found == [
        f"objects/tent/object.yaml:{i + 3}:5: features.{i}: 'f{i // 2}' is the name of another feature of 'tent'"
        for i in range(1, MANY, 2)
    ]


def test_of_keys_given_twice_the_first_is_the_place():
    document = load("x.yaml", b"a: 1\nb: 2\n[1]: 3\na: 4\n")
    assert [document.place(("a",)), document.place(("b",), key=True), document.place(("c",))] == [
        (1, 4),
        (2, 1),
        (1, 1),
    ]


def test_the_way_to_a_node_is_that_by_which_it_hangs():
    raw = {
        "parts": [{"part": "a"}, {"feature": "b", "appearances": [{}, {}]}],
        "features": 3,
        "appearances": [{"feature": "c"}],
    }
    assert [len(list(held(item))) for _, _, item in held(raw)] == [0, 2, 0]
    for i, (step, _, item) in enumerate(held(raw)):
        assert path_to(raw, (i,)) == step
        for j, (below, _, _) in enumerate(held(item)):
            assert path_to(raw, (i, j)) == step + below


def test_what_is_said_of_a_place_is_not_said_again_below_it():
    document = load("x.yaml", b"a: [1, 2]\nab: 1\n")
    rows = [document.mistake(path, "no") for path in ((), ("a",), ("a", 0), ("a", 1), ("ab",))]
    assert [m.path for m in without(rows, [("a",)])] == ["", "ab"]
    assert [m.path for m in without(rows, [("a", 0), ()])] == ["", "a", "a.1", "ab"]
    assert without(rows, []) == rows


def test_of_many_mistakes_a_hundred_are_told(tmp_path):
    with pytest.raises(KBErrors) as caught:
        read_kb(write_small(tmp_path, kb=KB + "".join(f"k{i}: 1\n" for i in range(5000))))
    lines = str(caught.value).splitlines()
    assert len(caught.value.mistakes) >= 5000
    assert (len(lines), lines[-1]) == (101, f"and {len(caught.value.mistakes) - 100} more")


def test_one_mistake_in_many_places_is_one_line_with_the_first_places(tmp_path):
    """And an open mesh of one type is told beside the mistakes of another."""
    many = "\n".join(
        f"  - {{feature: f{i}, type: apex, at: [0, 0, {i}], appearances: [{{type: knob}}]}}" for i in range(50)
    )
    folder = write_small(tmp_path, mesh="\n".join(MESH.splitlines()[:-1]) + "\n")
    (folder / "objects" / "rod").mkdir()
    (folder / "objects" / "rod" / "object.yaml").write_text(f"object: rod\nfeatures:\n{many}\n")
    with pytest.raises(KBErrors) as caught:
        read_kb(folder)
    found = str(caught.value).splitlines()
    (line,) = [line for line in found if "unknown appearance type 'knob'" in line]
    assert line.startswith("objects/rod/object.yaml:3:")
    assert "; the same at 4:" in line
    assert line.endswith(" and 46 more places")
    assert line.count("; the same at ") == 1
    (mesh,) = [line for line in found if line.startswith("objects/tent/object.yaml:2:")]
    assert "mesh.file: warning: the mesh is not closed (" in mesh
    assert sum("knob" in mistake.message for mistake in caught.value.mistakes) == 50
