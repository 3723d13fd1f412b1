"""``plogic bench recognition``.

Scoring by hand-made cases, the peer on pictures of its own, claims from what was counted.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rough_learning import RoughCloud, rough_cloud

from benchmarks.recognition import bench as recognition
from benchmarks.recognition import kb as recognition_kb
from benchmarks.recognition import scenes as recognition_scenes
from benchmarks.recognition.bench import Answer, answered, judgement
from benchmarks.recognition.kb import Ours
from benchmarks.recognition.peer import RATIOS, SEEN, THRESHOLDS, Candidate, Peer, Setting, _matches, accepted
from benchmarks.recognition.scenes import Case, half_turns, ycb_meshes
from benchmarks.recognition.score import Found, Tally, Truth, errors_of, matched, pose_right, tally
from benchmarks.recognition.table import claims, judged, rows
from benchmarks.tabletop.patterns import printed_box
from benchmarks.tabletop.scene import Arrangement, TabletopScene, recognition_scene
from geometry.camera import Camera
from geometry.frames import from_rotation_translation
from plogic.base.errors import InputError

CAMERA = Camera(640, 480, np.array([[600.0, 0, 320], [0, 600.0, 240], [0, 0, 1]]), np.zeros(0))
TYPES = ("box", "can", "mug")


def pose(x=0.0, degrees=0.0, z=1.0):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return from_rotation_translation(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), (x, 0, z))


def truth(type_="box", x=0.0, *, fraction=1.0, symmetries=None, centre=(0, 0, 0)):
    u = 320 + 600 * x
    return Truth(
        type_, pose(x), fraction, np.array([(u - 50, 190), (u + 50, 290)]), np.array(centre, dtype=float), symmetries
    )


def counts(found, truths):
    t = tally(found, truths, CAMERA, TYPES)
    return t.there, t.found, t.posed, t.false, t.extra


@pytest.mark.parametrize(
    ("found", "truths", "expected"),
    [
        ([], [], (0, 0, 0, 0, 0)),
        ([], [truth()], (1, 0, 0, 0, 0)),
        ([Found("box", pose())], [truth()], (1, 1, 1, 0, 0)),
        ([Found("box", pose(degrees=4.9))], [truth()], (1, 1, 1, 0, 0)),
        ([Found("box", pose(degrees=5.1))], [truth()], (1, 1, 0, 0, 0)),
        ([Found("box", pose(z=1.049))], [truth()], (1, 1, 1, 0, 0)),
        ([Found("box", pose(z=1.051))], [truth()], (1, 1, 0, 0, 0)),
        ([Found("can", pose())], [truth()], (1, 0, 0, 1, 0)),
        ([Found("box", pose(0.1))], [truth()], (1, 0, 0, 1, 0)),
        ([Found("box", pose(z=-1.0))], [truth()], (1, 0, 0, 1, 0)),
        ([Found("box", np.full((4, 4), np.nan))], [truth()], (1, 0, 0, 1, 0)),
        ([Found("box", pose()), Found("box", pose(0.001))], [truth()], (1, 1, 1, 1, 0)),
        ([Found("box", pose(0.01, 9)), Found("box", pose())], [truth()], (1, 1, 1, 1, 0)),
        ([Found("box", pose())], [truth(fraction=0.49)], (0, 0, 0, 0, 1)),
        ([], [truth(fraction=0.49)], (0, 0, 0, 0, 0)),
        ([Found("box", pose(0.3)), Found("box", pose())], [truth(), truth(x=0.3)], (2, 2, 2, 0, 0)),
        ([Found("box", pose(0.02)), Found("box", pose(0.03))], [truth(), truth(x=0.05)], (2, 2, 2, 0, 0)),
        ([Found("other", pose())], [truth("other")], (0, 0, 0, 0, 0)),
        ([Found("box", pose())], [], (0, 0, 0, 1, 0)),
    ],
)
def test_an_image_is_scored_by_hand(found, truths, expected):
    assert counts(found, truths) == expected


def test_a_half_turn_of_a_symmetric_type_is_right():
    turned = Found("box", pose(degrees=180))
    assert not pose_right(turned, truth())
    assert pose_right(turned, truth(symmetries=np.array([np.diag([-1.0, -1, 1, 1])])))
    assert errors_of(turned, truth()) == pytest.approx((np.pi, 0))


def test_translations_are_of_the_middle_and_not_of_a_far_origin():
    far = truth(centre=(0, 0, 0.5))
    about_the_middle = Found(
        "box", far.camera_from_object @ from_rotation_translation(pose(degrees=4)[:3, :3], (0, 0, 0))
    )
    assert errors_of(about_the_middle, far) == pytest.approx((np.radians(4), 0), abs=1e-9)
    lower = replace(
        far, symmetries=half_turns(np.array([(x, y, z) for x in (0, 1) for y in (0, 2) for z in (-1, 2)], dtype=float))
    )
    assert (
        errors_of(
            Found("box", far.camera_from_object @ lower.symmetries[2]), replace(lower, centre=np.array([0.5, 1, 0.5]))
        )[1]
        < 1e-9
    )


def test_half_turns_leave_a_box_as_it_is():
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)], dtype=float)
    assert len(half_turns(corners)) == 3
    assert len(half_turns(np.vstack([corners, [(0.5, 1, 2)]]))) == 1
    for turn in half_turns(corners):
        moved = corners @ turn[:3, :3].T + turn[:3, 3]
        assert sorted(map(tuple, np.round(moved, 6) + 0.0)) == sorted(map(tuple, corners))


def test_nobody_is_stood_for_twice():
    found, truths = [Found("box", pose(0.01)), Found("box", pose(0.02))], [truth(), truth(x=0.03)]
    pairs = matched(found, truths, CAMERA)
    assert sorted(pairs) == [(0, 0), (1, 1)]


def test_tallies_add_up_and_shares_of_nothing_are_stated():
    both = Tally(10, 8, 6, 1, 0) + Tally(0, 0, 0, 1, 2)
    assert both == Tally(10, 8, 6, 2, 2)
    assert (both.recall, both.precision, both.poses) == (0.8, 0.8, 0.75)
    assert both.f1 == pytest.approx(0.8)
    assert both.pose_f1 == pytest.approx(0.6)
    assert (Tally().recall, Tally().precision, Tally().poses, Tally().f1) == (1, 1, 1, 0)


def some_case(seed=0, truths=(), hard=0.0):
    return Case(seed, hard, not truths, Path("image.png"), CAMERA, tuple(truths))


def some_answer(found, truths, peer=(), seconds=1.0):
    """``peer``: (found, inliers) at the first setting; none at the others."""
    candidates = {(s, r, t): [] for s in SEEN for r in RATIOS for t in THRESHOLDS}
    candidates[SEEN[0], RATIOS[1], THRESHOLDS[1]] = [Candidate(f, n) for f, n in peer]
    return Answer(some_case(truths=truths), tuple(found), seconds, candidates, dict.fromkeys(SEEN, 2.0))


def all_good():
    """Ours finds all of ten; of the peer's ten one is wrong at five inliers."""
    right = [some_answer([Found("box", pose())], [truth()], [(Found("box", pose()), 9)]) for _ in range(9)]
    other = some_answer([Found("can", pose())], [truth("can")], [(Found("box", pose()), 5)])
    return [*right, other, some_answer([], []), some_answer([Found("mug", pose(degrees=60))], [truth("mug")])]


def unmet(answers):
    return [c.claim for c in claims(judged(answers)) if not c.met]


def test_all_claims_can_be_met_and_the_peer_gets_its_best():
    verdict = judged(all_good())
    assert unmet(all_good()) == []
    assert verdict.by_f1 == Setting(SEEN[0], RATIOS[1], THRESHOLDS[1], 6)
    assert verdict.peers({"box", "can"}, verdict.by_f1) == Tally(10, 9, 9, 0, 0)
    assert verdict.textured == {"box", "can"}
    assert verdict.plain == {"mug"}


@pytest.mark.parametrize(
    ("worse", "said"),
    [
        (
            [some_answer([], [truth()], [(Found("box", pose()), 9)])] * 2,
            ["identity recall", "F1 of identities less", "F1 of identities with"],
        ),
        ([some_answer([Found("can", pose())], [truth()] * 0 + [truth(fraction=0.2)])], ["identity precision"]),
        ([some_answer([Found("box", pose(degrees=20))], [truth()])] * 2, ["of the found", "F1 of identities with"]),
        ([some_answer([Found("mug", pose())], [])], ["accepted in scenes"]),
        ([some_answer([], [], seconds=9.0)] * 40, ["seconds a picture"]),
    ],
)
def test_a_claim_that_is_missed_is_not_met(worse, said):
    missed = unmet([*all_good(), *worse])
    assert missed
    for claim in missed:
        assert any(claim.startswith(s) or s in claim for s in said)


def test_rows_name_both_sides_every_type_and_every_hardness():
    listed = rows(judged(all_good()))
    assert [r["row"] for r in listed] == [
        "ours",
        "peer",
        "peer by pose F1",
        "ours, plain",
        "peer, plain",
        "peer by pose F1, plain",
        "box",
        "can",
        "mug",
        "hard 0",
    ]
    assert (listed[0]["found"], listed[1]["found"], listed[3]["posed"]) == (10, 9, 0)
    text, met = judgement(all_good(), as_json=False)
    assert met
    assert "peer at its best: keypoints, ratio 0.8, 3 px, 6 inliers" in text
    assert max(len(line) for line in text.splitlines()) < 150
    assert json.loads(judgement(all_good(), as_json=True)[0])["bench"] == "recognition"


def test_the_ratio_is_to_the_next_other_feature():
    """Two descriptors of one feature do not compete; exact distances."""
    learned = np.zeros((3, 128), np.float32)
    learned[0, 0], learned[1, 0], learned[2, 0] = 10, 11, 40
    seen = np.zeros((1, 128), np.uint8)
    found = _matches(np.array([[5.0, 6.0]]), seen, learned, np.array([0, 2]), np.array([(1.0, 0, 0), (2.0, 0, 0)]))
    assert found.at.tolist() == [[1, 0, 0]]
    assert found.ratio == pytest.approx(0.25)


def test_a_pose_is_accepted_from_its_inliers_on():
    candidates = {(SEEN[1], 0.8, 2.0): [Candidate(Found("box", pose()), n) for n in (5, 7, 20)]}
    assert [len(accepted(candidates, Setting(SEEN[1], 0.8, 2.0, n))) for n in (5, 6, 8, 21)] == [3, 2, 1, 0]


def boxes():
    rng = np.random.default_rng(11)
    return [
        (f"box{i}", printed_box(np.array(size), rng)) for i, size in enumerate([(0.12, 0.07, 0.16), (0.09, 0.1, 0.18)])
    ]


def test_both_sides_see_the_same_pictures_and_the_peer_finds_poses(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.recognition.peer.ITERATIONS", 500)
    monkeypatch.setattr(recognition_scenes, "QUICK_SCENES", 2)
    monkeypatch.setattr(recognition_scenes, "EMPTY_EVERY", 2)
    monkeypatch.setattr("benchmarks.tabletop.scene.TWINS", 0.0)
    real = recognition_scene
    two = Arrangement(bodies=(2, 2))
    monkeypatch.setattr("benchmarks.tabletop.scene.recognition_scene", lambda *a, **k: real(*a, **k, arranged=two))
    fine = TabletopScene.photograph
    monkeypatch.setattr(TabletopScene, "photograph", lambda scene, _: fine(scene, 1))  # one ray a pixel
    shapes, seen, said = boxes(), [], []
    mine = Ours(
        lambda image, camera: seen.append((image.shape, camera.world_from_camera)) or [],
        {n: rough_cloud(m, 8, 150, 1) for n, m in shapes},
    )
    answers = answered(mine, shapes, tmp_path, seed=90, limit=60.0, quick=True, say=said.append)
    assert seen == [((480, 640, 3), None)] * 2
    assert [a.case.empty for a in answers] == [False, True]
    assert len(said) == 2
    verdict = judged(answers)
    peers = verdict.peers(verdict.textured, verdict.by_pose_f1)
    assert peers.posed >= 1
    assert peers.false == 0
    assert verdict.mine(verdict.textured).found == 0


def test_a_peer_without_time_or_features_finds_nothing():
    cloud = RoughCloud(np.zeros((1, 3)), np.zeros(4, int), np.zeros((4, 128), np.uint8))
    image = np.random.default_rng(0).integers(0, 255, (120, 160, 3), dtype=np.uint8)
    found, seconds = Peer({"box": cloud}).candidates(image, CAMERA)
    assert set(found) == {(s, r, t) for s in SEEN for r in RATIOS for t in THRESHOLDS}
    assert not any(found.values())
    assert set(seconds) == set(SEEN)
    assert min(seconds.values()) >= 0
    assert not any(Peer({}).candidates(np.zeros((480, 640, 3), np.uint8), CAMERA, limit=0.0)[0].values())


def test_without_the_meshes_it_says_so_in_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(recognition_scenes, "YCB", tmp_path / "none")
    with pytest.raises(
        InputError, match=r"needs the textured meshes of the YCB objects in .*none, and they are not there$"
    ):
        recognition.run(seed=0, limit=1.0, quick=True, as_json=False, say=lambda _: None)


def test_what_cannot_be_learned_is_one_clear_line(monkeypatch, tmp_path):
    monkeypatch.setattr(recognition_kb, "learn_into", lambda *_: (_ for _ in ()).throw(InputError("no mesh")))
    with pytest.raises(InputError, match="no mesh"):
        recognition_kb.ours({"box": tmp_path}, tmp_path, lambda _: None)


@pytest.mark.skipif(
    not recognition_scenes.YCB.is_dir(), reason=f"the YCB meshes are not there ({recognition_scenes.YCB})"
)
def test_the_ten_types_are_named_after_their_folders():
    names = set(ycb_meshes())
    assert len(names) == 10
    assert {"cracker_box", "mug", "rubiks_cube", *recognition_scenes.PLAIN} <= names
