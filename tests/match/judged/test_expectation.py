"""Expected and Detected (D7, D8) of posed hypotheses, against brute force."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA, camera_pose, data, one_before_the_other, perceiver, posed_at, scene, towers

from geometry.camera import Camera
from geometry.frames import inverse
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import hidden_by, matched, pose_of
from sensing.appearance import Appearance

TOLERANCE = 3.0


def meets(start, end, triangle):
    """How far along the segment (share) it meets the triangle, None if it does not."""
    a, b, c = triangle
    try:
        share, u, v = np.linalg.solve(np.stack([start - end, b - a, c - a], axis=1), start - a)
    except np.linalg.LinAlgError:
        return None
    return share if u >= 0 and v >= 0 and u + v <= 1 and 0 < share < 1 else None


def is_behind(point, kind, viewpoint, margin):
    """Whether some facet lies on the line of sight, more than the margin before the point. All in the type's frame."""
    length = np.linalg.norm(point - viewpoint)
    found = (meets(viewpoint, point, kind.surface.vertices[t]) for t in kind.surface.triangles)
    return any(share is not None and share * length < length - margin for share in found)


def in_some_lobe(feature, viewpoint):
    view = viewpoint - feature.at
    distance = np.linalg.norm(view)
    rows = [(feature.rotation @ a.lobe.axis, a.lobe) for a in feature.appearances]
    return any(
        lobe.r_min <= distance <= lobe.r_max
        and np.arccos(np.clip(view @ axis / distance, -1, 1)) <= lobe.half_angle + 1e-9
        for axis, lobe in rows
    )


@pytest.mark.parametrize("name", ["t1", "t2"])
@pytest.mark.parametrize("seed", [7000, 7001])
def test_expected_by_brute_force(name, seed):
    """In the image, in a lobe, not behind its own host: each by its definition."""
    pose, kind = camera_pose(np.random.default_rng(seed)), towers().type(name)
    posed = pose_of(kind, pose, data_of([], CAMERA), towers())
    viewpoint = inverse(pose)[:3, 3]
    assert len(posed.uv) == len(kind.features) > 0
    for f, feature in enumerate(kind.features):
        at = pose[:3, :3] @ feature.at + pose[:3, 3]
        uv = np.array([600 * at[0] / at[2] + 319.5, 600 * at[1] / at[2] + 239.5])
        assert np.allclose(posed.uv[f], uv)
        assert posed.in_image[f] == ((uv >= -0.5).all() and uv[0] < 639.5 and uv[1] < 479.5)
        assert posed.in_lobe[f] == in_some_lobe(feature, viewpoint)
        assert posed.self_hidden[f] == is_behind(feature.at, kind, viewpoint, 0.004 * kind.surface.diameter)
        assert posed.candidate[f] == (posed.in_image[f] and posed.in_lobe[f] and not posed.self_hidden[f])


@pytest.mark.parametrize("seed", [7010, 7011, 7012])
def test_hidden_by_another_by_brute_force(seed):
    rng = np.random.default_rng(seed)
    poses = one_before_the_other(rng)
    of = data_of([], CAMERA)
    front, back = (pose_of(towers().type(n), poses[n], of, towers()) for n in ("t1", "t2"))
    t1, t1_from_camera = towers().type("t1"), inverse(poses["t1"])
    told = hidden_by(back, front)
    assert told.any()
    assert not told.all()
    for f in range(len(told)):
        point = t1_from_camera[:3, :3] @ back.at[f] + t1_from_camera[:3, 3]
        assert told[f] == is_behind(point, t1, t1_from_camera[:3, 3], 0.004 * t1.surface.diameter)
    assert not hidden_by(front, back)[front.candidate].any()


def test_ranges_of_lobes_scale_with_the_focal_length():
    """A longer lens sees from farther (§2.7): what is out of every lobe's range at f is in it at 4 f."""
    kind = towers().type("t1")
    reach = float(kind.lobes.r_max.max())
    pose = np.eye(4)
    pose[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    pose[2, 3] = 2.0 * reach
    longer = Camera(640, 480, np.array([[2400.0, 0, 319.5], [0, 2400.0, 239.5], [0, 0, 1]]))
    near = pose_of(kind, pose, data_of([], CAMERA), towers())
    far = pose_of(kind, pose, data_of([], longer), towers())
    assert not near.in_lobe.any()
    assert far.in_lobe.any()


def test_outside_the_image_is_none_of_the_four_cases():
    """Half of the tower is out of view: cells count the other half only, and what is outside takes no appearance."""
    rng = np.random.default_rng(7020)
    pose = camera_pose(rng, (4.0, 4.5))
    whole = scene(rng, {"t1": pose}, hit=1.0, clutter=0)
    at = perceiver().models["t1"].points @ pose[:3, :3].T + pose[:3, 3]
    cut = Camera(int(np.median(CAMERA.project(at)[:, 0])), 480, CAMERA.K)
    of = data_of(whole.gamma.appearances, cut)
    posed = posed_at("t1", pose, of)
    assert 5 < posed.in_image.sum() < len(posed.in_image) - 5
    assert not posed.detected[~posed.in_image].any()
    assert not posed.candidate[~posed.in_image].any()
    assert sum(c.A + c.B + c.C + c.D for c in posed.support().values()) == posed.in_image.sum()


def test_behind_the_camera_is_outside_the_image():
    pose = camera_pose(np.random.default_rng(7021))
    pose[2, 3] = -4.0
    posed = posed_at("t1", pose, data_of([Appearance("a", "patch", (9.0, 9.0), "drawn")], CAMERA))
    assert not posed.in_image.any()
    assert not posed.detected.any()
    assert posed.support() == {}


@pytest.mark.parametrize("seed", range(7030, 7034))
def test_what_is_truly_seen_is_expected_and_mostly_detected_by_its_own_appearance(seed):
    rng = np.random.default_rng(seed)
    pose = camera_pose(rng, (3.0, 6.0))
    shot = scene(rng, {"t1": pose}, clutter=0, noise=0.2)
    of = data(shot)
    posed = posed_at("t1", pose, of)
    names = [f"t1/{f.name}" for f in towers().type("t1").features]
    assert {names[f] for f in np.flatnonzero(posed.candidate)} == shot.visible
    taken = {of.ids[posed.matches[f]]: names[f] for f in np.flatnonzero(posed.detected)}
    agreeing = sum(shot.causes[a] == f for a, f in taken.items())
    assert agreeing >= len(shot.causes) - 1
    assert agreeing >= 0.95 * len(taken)


# --- D8: one assignment, by brute force over all partial injections ---


def small(features, places, expected, right):
    """A posed hypothesis with F features, laid by hand, and Γ with A data."""
    count = len(features)
    nothing = np.zeros(count, dtype=bool)
    posed = Hypothesis(
        "drawn",
        np.eye(4),
        opaque=True,
        at=np.zeros((count, 3)),
        uv=np.array(features, float).reshape(-1, 2),
        in_image=~nothing,
        in_lobe=np.array(expected, dtype=bool),
        self_hidden=nothing,
        right=np.array(right, dtype=bool).reshape(count, len(places)),
        matches=np.full(count, -1),
        residual=np.full(count, np.nan),
    )
    return posed, data_of(
        [Appearance(f"a{i}", "patch", tuple(map(float, uv)), "drawn") for i, uv in enumerate(places)], CAMERA
    )


def gain_of(rows, off):
    return sum(1.0 - 0.5 * (off[f, a] / TOLERANCE) ** 2 for f, a in rows)


def best_gain(possible, off):
    """The greatest gain over every partial injection."""
    choices = [[-1, *np.flatnonzero(row)] for row in possible]
    gains = [0.0]
    for chosen in product(*choices):
        rows = [(f, a) for f, a in enumerate(chosen) if a >= 0]
        if len({a for _, a in rows}) == len(rows):
            gains.append(gain_of(rows, off))
    return max(gains)


@st.composite
def tight_views(draw):
    """Up to four features and data within a few pixels of each other, so that everything competes."""
    spot = st.tuples(st.floats(100, 106), st.floats(100, 106))
    features, places = draw(st.lists(spot, min_size=1, max_size=4)), draw(st.lists(spot, min_size=1, max_size=4))
    flags = st.lists(st.booleans(), min_size=len(places), max_size=len(places))
    right = draw(st.lists(flags, min_size=len(features), max_size=len(features)))
    more = draw(st.lists(flags, min_size=len(features), max_size=len(features)))
    expected = draw(st.lists(st.booleans(), min_size=len(features), max_size=len(features)))
    return features, places, expected, np.array(right), np.array(right) | np.array(more), np.array(draw(flags))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(tight_views())
def test_detected_by_brute_force(view):
    """Expected features first, with the types whose lobe holds v; the rest takes what is left.

    Each appearance serves one feature.
    """
    features, places, expected, right, allowed, free = view
    posed, of = small(features, places, expected, right)
    posed = matched(posed, of, allowed, TOLERANCE, free)
    off = np.linalg.norm(np.array(features)[:, None] - np.array(places)[None], axis=2)
    taken = [(f, int(a)) for f, a in enumerate(posed.matches) if a >= 0]
    assert len({a for _, a in taken}) == len(taken)
    assert all(free[a] and off[f, a] <= TOLERANCE and (right if expected[f] else allowed)[f, a] for f, a in taken)
    near, awaited = off <= TOLERANCE, np.array(expected)
    mine = [(f, a) for f, a in taken if expected[f]]
    assert gain_of(mine, off) == pytest.approx(best_gain(near & right & free & awaited[:, None], off))
    left = free.copy()
    left[[a for _, a in mine]] = False
    others = [(f, a) for f, a in taken if not expected[f]]
    assert gain_of(others, off) == pytest.approx(best_gain(near & allowed & left & ~awaited[:, None], off))
    assert np.allclose([posed.residual[f] for f, _ in taken], [off[f, a] for f, a in taken])
    assert np.isnan(posed.residual[posed.matches < 0]).all()


def test_expected_features_come_first():
    """The nearer, unexpected feature gets nothing where the expected one wants the only appearance."""
    posed, of = small([(100, 100), (102, 100)], [(100, 100)], [False, True], [[True], [True]])
    assert matched(posed, of, np.ones((2, 1), dtype=bool), TOLERANCE).matches.tolist() == [-1, 0]


def test_an_expected_feature_takes_no_type_from_a_lobe_that_does_not_hold_the_viewpoint():
    posed, of = small([(100, 100)], [(100, 100)], [True], [[False]])
    assert matched(posed, of, np.ones((1, 1), dtype=bool), TOLERANCE).matches.tolist() == [-1]


def test_an_unexpected_feature_may_take_a_type_from_any_lobe():
    posed, of = small([(100, 100)], [(100, 100)], [False], [[False]])
    assert matched(posed, of, np.ones((1, 1), dtype=bool), TOLERANCE).matches.tolist() == [0]


def test_a_feature_that_an_occluder_hides_is_matched_as_unexpected():
    posed, of = small([(100, 100), (101, 100)], [(100, 100)], [True, True], [[True], [True]])
    hidden = np.array([True, False])
    assert matched(posed, of, np.ones((2, 1), dtype=bool), TOLERANCE, hidden=hidden).matches.tolist() == [-1, 0]


def test_the_four_cases_of_support():
    kind = replace(towers().type("t1"), features=towers().type("t1").features[:4])
    posed, of = small(
        [(100, 100), (200, 100), (300, 100), (400, 100)], [(100, 100), (300, 100)], [1, 1, 0, 0], np.ones((4, 2))
    )
    posed = replace(matched(posed, of, np.ones((4, 2), dtype=bool), TOLERANCE), known_type=kind)
    total = {case: sum(getattr(c, case) for c in posed.support().values()) for case in "ACBD"}
    assert total == {"A": 1, "C": 1, "B": 1, "D": 1}
    hidden = posed.support(np.array([False, True, False, False]))
    assert {case: sum(getattr(c, case) for c in hidden.values()) for case in "ACBD"} == {"A": 1, "C": 0, "B": 2, "D": 1}


def test_an_empty_gamma_detects_nothing():
    pose = camera_pose(np.random.default_rng(7040))
    posed = posed_at("t2", pose, data_of([], CAMERA))
    assert not posed.detected.any()
    assert posed.candidate.any()
