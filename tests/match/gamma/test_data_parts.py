"""Parts of Γ, and parts of parts: the same data, and where they are in the whole."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA

from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import CELL
from sensing.appearance import Appearance

ARRAYS = ("uv", "ideal", "arms", "angle", "scale", "descriptors", "described")


def some(count, seed=0):
    """Junctions, keypoints and patches."""
    rng = np.random.default_rng(seed)
    rows = []
    for i in range(count):
        uv, keypoint = tuple(rng.uniform([0, 0], [639, 479]).tolist()), i % 3 == 0
        more = {"angle": 1.0 + i, "scale": 4.0, "descriptor": rng.bytes(128)} if keypoint else {"arms": (0.1 * i, 2.0)}
        rows.append(Appearance(f"a{i}", "sift" if keypoint else "corner", uv, "made", **more))
    return data_of(rows, CAMERA)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 12), st.lists(st.lists(st.booleans(), min_size=12, max_size=12), max_size=4))
def test_rows_lead_from_any_part_to_the_whole(count, choices):
    whole = some(count)
    part, rows = whole, np.arange(count)
    for choice in choices:
        keep = np.array(choice[: len(rows)], bool)
        part, rows = part.only(keep), rows[keep]
        assert part.whole is whole
        assert part.rows.tolist() == rows.tolist()
        assert part.ids == tuple(whole.ids[i] for i in rows)
        assert part.types == tuple(whole.types[i] for i in rows)
        assert part.camera is whole.camera
        assert part.namesakes.tolist() == [whole.types.count(name) for name in part.types]
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[rows])
    assert whole.whole is whole
    assert whole.rows.tolist() == list(range(count))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 12), st.lists(st.booleans(), min_size=12, max_size=12), st.floats(0, 300))
def test_the_keypoints_of_a_part_are_its_own_and_all_that_are_near_are_found_once(count, choice, reach):
    whole = some(count)
    assert whole.keypoints is whole.keypoints
    part = whole.only(np.array(choice[:count], bool))
    asked = np.array([[320.0, 240.0], [-0.5, 479.5], [700.0, -80.0]])
    place, datum = part.keypoints.near(asked, reach)
    pairs = list(zip(place.tolist(), datum.tolist(), strict=True))
    apart = np.linalg.norm(asked[:, None] - part.uv[None], axis=2)
    assert len(pairs) == len(set(pairs))
    assert set(zip(*(i.tolist() for i in np.nonzero((apart <= reach) & part.described)), strict=True)) <= set(pairs)
    assert part.described[datum].all()
    assert (np.abs(asked[place] - part.uv[datum]) < reach + CELL + 1).all()
