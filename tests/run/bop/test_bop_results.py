"""The challenge's results file: out and in again, and what is wrong with a bad one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from plogic.base.errors import InputError
from plogic.run.bop.results_file import HEADER, Estimate, read_results, results_text

GOOD = "1,3,5,0.5,1 0 0 0 1 0 0 0 1,10 -20 1000.5,-1"
numbers = st.floats(-3, 3)
quats = st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: np.linalg.norm(q) > 0.1)
estimates = st.builds(
    lambda ids, sure, q, t: Estimate(*ids, sure, from_rotation_translation(rotation_from_quat_xyzw(q), t)),
    st.tuples(st.integers(0, 99), st.integers(0, 10**6), st.integers(0, 30)),
    st.floats(-1e9, 1e9),
    quats,
    st.tuples(numbers, numbers, numbers),
)


def test_a_line_by_hand(tmp_path):
    pose = from_rotation_translation([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [0.25, -0.5, 1])
    text = results_text([Estimate(1, 3, 5, 0.75, pose, 2.5)])
    assert text == f"{HEADER}\n1,3,5,0.75,0.0 -1.0 0.0 1.0 0.0 0.0 0.0 0.0 1.0,250.0 -500.0 1000.0,2.5\n"


@settings(max_examples=50, deadline=None)
@given(st.lists(estimates, max_size=5))
def test_round_trip(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("csv") / "sift_ycbv-test.csv"
    path.write_text(results_text(rows))
    back = read_results(path)
    assert [(e.scene_id, e.im_id, e.obj_id, e.score, e.time) for e in back] == [
        (e.scene_id, e.im_id, e.obj_id, e.score, e.time) for e in rows
    ]
    assert all(
        np.abs(a.camera_from_object - b.camera_from_object).max() < 1e-12 for a, b in zip(rows, back, strict=True)
    )


def test_no_header_and_other_line_ends(tmp_path):
    path = tmp_path / "any name.csv"
    path.write_bytes(f"{GOOD}\r\n\r\n{GOOD}".encode())
    rows = read_results(path)
    assert len(rows) == 2
    assert rows[0].camera_from_object[:3, 3].tolist() == [0.01, -0.02, 1.0005]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("1,3,5,0.5,1 0 0 0 1 0 0 0 1,0 0 1", "must have the 7 fields"),
        (GOOD.replace("1,3", "1,x", 1), "im_id: must be a whole number"),
        (GOOD.replace("1,3", "-1,3", 1), "scene_id: must be a whole number"),
        (GOOD.replace("0.5", "nan", 1), "score: must hold 1 finite"),
        (GOOD.replace("0.5", "", 1), "score: must hold 1 finite"),
        (GOOD.replace("1 0 0 0 1", "1 0 0 1", 1), "R: must hold 9 finite"),
        (GOOD.replace("1 0 0 0 1", "1 0 0 0 -1", 1), "R: must be a rotation"),
        (GOOD.replace("1 0 0 0 1", "2 0 0 0 1", 1), "R: must be a rotation"),
        (GOOD.replace("1000.5", "1e999"), "t: must hold 3 finite"),
        (GOOD.replace(",-1", ",7"), "time: scene 1, image 3: is not the same"),
    ],
)
def test_a_mistake_has_its_line(tmp_path, line, words):
    path = tmp_path / "r.csv"
    path.write_text(f"{HEADER}\n{GOOD}\n{line}\n")
    with pytest.raises(InputError, match="^" + str(path)) as caught:
        read_results(path)
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_every_mistake_is_told(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(f"{HEADER}\nno\n{GOOD}\n{GOOD[2:]}\n")
    with pytest.raises(InputError) as caught:
        read_results(path)
    assert [line.split(" ")[0] for line in str(caught.value).splitlines()] == [f"{path}:2:", f"{path}:4:"]


def test_no_such_file_and_no_text(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_results(tmp_path / "none.csv")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8"):
        read_results(tmp_path / "b.csv")
