"""The challenge's results file: out and in again."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from results_reader import read_results

from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from plogic.run.bop.results_file import HEADER, Estimate, results_text

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
