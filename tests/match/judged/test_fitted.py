"""What the program is told of a pose that was fitted to its matches: the evidence of all poses about it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA, camera_pose, data, posed_at, scene, towers

from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import as_counted, as_fitted, clutter_density, log_share, sigmas


def stand(seed, hit, clutter):
    rng = np.random.default_rng(seed)
    pose = camera_pose(rng, (3.0, 6.0))
    of = data(scene(rng, {"t2": pose}, hit=hit, clutter=clutter))
    return posed_at("t2", pose, of), of


def ratios(posed, of, kb, rates, found):
    """Ln of how much likelier each match is with the object than without; and with a miss in its stead."""
    hit, near = (row[found] for row in rates)
    clutter = clutter_density(kb, of, posed.matches[found])
    return np.log((hit * near + (1 - hit) * clutter) / clutter), np.log(1 - hit)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.floats(0.1, 0.9), st.integers(0, 40), st.floats(0, 1))
def test_matches_give_up_the_share_of_poses_and_never_more_than_they_have(seed, hit, clutter, cover):
    posed, of = stand(seed, hit, clutter)
    kb, hidden = towers(), np.random.default_rng(seed).random(len(posed.uv)) < 0.5 * cover
    found = posed.candidate & posed.detected & ~hidden
    plain, told = as_counted(posed, of, kb, hidden), as_fitted(posed, of, kb, hidden)
    assert np.array_equal(told[0], plain[0])
    assert np.array_equal(told[1][~found], plain[1][~found])
    assert (told[1][found] > 0).all()
    assert (told[1][found] <= plain[1][found]).all()
    before, missed = ratios(posed, of, kb, plain, found)
    after, _ = ratios(posed, of, kb, told, found)
    share = log_share(posed.at[found], sigmas(posed, kb)[found] ** -2.0, posed.middle, of.camera)
    assert after.sum() == pytest.approx(max(before.sum() + share, missed.sum()) if found.any() else 0.0, abs=1e-4)


def test_where_nothing_is_matched_nothing_is_owed():
    of = data_of([], CAMERA)
    posed = posed_at("t2", camera_pose(np.random.default_rng(1)), of)
    assert posed.candidate.any()
    for told, plain in zip(as_fitted(posed, of, towers()), as_counted(posed, of, towers()), strict=True):
        assert np.array_equal(told, plain)
