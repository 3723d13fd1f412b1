"""``stands`` of object.yaml: how a type stands, and how often so."""

import json

import numpy as np
import pytest
from small_kb import OBJECT, write_small
from written_kb import write_kb

from kb.clouds.cloud import Stand
from kb.errors import KBErrors
from kb.files.read import read_kb
from kb.shown.show import check_report, tree_document, tree_text

MESHLESS = OBJECT.replace("mesh: {file: mesh.obj, units: cm}\n", "")


def small(folder, stands):
    return read_kb(write_small(folder, object=f"{OBJECT}stands: {stands}\n" if stands else OBJECT))


def tent(kb):
    return kb.types[0]


def test_where_nothing_is_said_it_stands_as_its_mesh_can(tmp_path):
    kb = small(tmp_path, "")
    assert tent(kb).stands is None
    np.testing.assert_allclose(tent(kb).resting.weight, [0.5, 1 / 6, 1 / 6, 1 / 6])
    assert "  stands as its mesh can, on 4 faces: [0, 0, -1] 0.5, " in tree_text(kb)


def test_what_is_said_comes_first_and_is_shared_by_what_is_alike(tmp_path):
    """The tent has three equal sides: what is said of one is said of all."""
    kb = small(tmp_path / "a", "[{down: [0, 0, -3], weight: 4}, {down: [-1, 0.05, 0.5]}]")
    faces = tent(kb).resting
    np.testing.assert_allclose(faces.weight, [0.8, 0.2 / 3, 0.2 / 3, 0.2 / 3])
    np.testing.assert_allclose(faces.down[0], [0, 0, -1], atol=1e-9)
    np.testing.assert_allclose(faces.down[1:, 2], 1 / np.sqrt(5), atol=0.01)
    rows = tree_document(kb)["types"][0]["stands"]
    assert [row["weight"] for row in rows] == pytest.approx(faces.weight.tolist())
    assert json.dumps(rows)
    assert not [line for line in check_report(kb) if "stands" in line]
    write_kb(kb, tmp_path / "b")
    first, second = tent(read_kb(tmp_path / "b")).stands
    assert first == Stand((0, 0, -1), 4.0)
    assert second.down == pytest.approx(tent(kb).stands[1].down)


def test_it_may_never_stand(tmp_path):
    kb = small(tmp_path / "a", "never")
    assert tent(kb).stands == ()
    assert tent(kb).resting.down.shape == (0, 3)
    assert "  stands as object.yaml says, on 0 faces\n" in tree_text(kb)
    write_kb(kb, tmp_path / "b")
    assert tent(read_kb(tmp_path / "b")).stands == ()


def test_a_direction_in_which_it_cannot_rest_is_taken_and_noted(tmp_path):
    """On its point."""
    kb = small(tmp_path, "[{down: [0, 0, 1]}]")
    np.testing.assert_allclose(tent(kb).resting.down, [[0, 0, 1]], atol=1e-9)
    np.testing.assert_allclose(tent(kb).resting.reach, [1.0])
    (note,) = [line for line in check_report(kb) if "stands" in line]
    assert note.startswith(
        "note: tent: stands.0: its mesh cannot stand on [0, 0, 1]: the nearest face that it can is 63 deg off"
    )


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("[]", "27:9: stands: must be never, or a list of one or more ways to stand, not []"),
        ("always", "27:9: stands: must be never, or a list"),
        ("{down: [0, 0, -1]}", "27:9: stands: must be never, or a list"),
        ("[{weight: 1}]", "27:10: stands.0.down: missing"),
        ("[{down: [0, 0, 0]}]", "27:17: stands.0.down: must be a direction"),
        ("[{down: [0, 0, 1], weight: 0}]", "stands.0.weight: must be above 0, not 0"),
        ("[{down: [0, 0, 1], often: 1}]", "stands.0.often: unknown key"),
    ],
)
def test_mistakes_have_their_place(text, where, tmp_path):
    with pytest.raises(KBErrors) as found:
        small(tmp_path, text)
    assert where in str(found.value)


def test_without_a_mesh_there_is_nothing_to_stand_on(tmp_path):
    with pytest.raises(KBErrors, match="stands: a type without a mesh stands on nothing"):
        read_kb(write_small(tmp_path / "a", object=MESHLESS + "stands: [{down: [0, 0, -1]}]\n"))
    assert tent(read_kb(write_small(tmp_path / "b", object=MESHLESS + "stands: never\n"))).resting.down.shape == (0, 3)


def test_what_is_no_number_is_told_once(tmp_path):
    with pytest.raises(KBErrors) as told:
        small(tmp_path, "[{down: [0, 0, .nan], weight: .inf}]")
    assert [str(one).partition("stands.")[2] for one in told.value.mistakes] == [
        "0.down.2: must be finite, not .nan",
        "0.weight: must be finite, not .inf",
    ]
