"""A painted cube, learned from a few small pictures, is found in pictures that it was not learned from.

Where it is not, nothing is.
"""

import cv2
import numpy as np
import pytest
from painted_cube import CAMERA, CORNER, cloud, paint, picture, pose_towards, seen, write_knowledge

from geometry.frames import pose_error
from kb.clouds.learned import LearnedCloud
from kb.files.read import read_kb
from plogic.facts.interpretation import text_of
from plogic.run.perceive import Perceiver
from sensing.appearance import Gamma
from sensing.detectors.detector import detect


@pytest.fixture(scope="module")
def perceiver(tmp_path_factory):
    return Perceiver(read_kb(write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": cloud(seen())})))


def gamma(perceiver, image, camera=CAMERA):
    return detect(image, camera, perceiver.kb.appearance_types, perceiver.kb.words)


def found(perceiver, image, camera=CAMERA):
    """camera_from_object of the hypotheses of the likeliest world."""
    document = perceiver(gamma(perceiver, image, camera))
    by_id = {h["id"]: h for h in document["hypotheses"]}
    return [np.array(by_id[name]["T_camera_object"]) for name in document["worlds"][0]["present"]]


def errors(pose, truth):
    rotation, translation = pose_error(pose, truth)
    return np.degrees(rotation), translation / np.linalg.norm(truth[:3, 3])


def test_learned_types_are_ordinary_types(perceiver):
    kind = perceiver.kb.type("cube")
    assert isinstance(kind.learned, LearnedCloud)
    assert len(kind.features) == len(kind.learned.at) > 50
    assert kind.lobes.types == tuple(perceiver.kb.words.names[w] for w in kind.learned.lobe_word)
    assert set(kind.lobes.types) <= set(perceiver.kb.appearance_types)
    assert set(perceiver.kb.words.names) <= set(perceiver.kb.rates.clutter)


def test_whoever_proposes_poses_of_other_types_learned_ones_have_their_own_search(perceiver):
    image = picture([pose_towards(CORNER, 0.60, 0.0, (0.0, 0.0))], seed=3)
    plain = Perceiver(perceiver.kb, generator="quadruples")
    one, other = (ready(gamma(perceiver, image)) for ready in (perceiver, plain))
    assert [h["status"] for h in one["hypotheses"]] == ["accepted"]
    assert text_of(one) == text_of(other)


@pytest.mark.parametrize(
    ("direction", "distance", "roll", "aside"),
    [
        (CORNER, 0.60, 0.0, (0.0, 0.0)),
        ((1.0, 0.5, 0.7), 0.55, 0.4, (0.03, -0.02)),
        ((0.8, 1.0, 0.8), 0.70, 2.5, (-0.05, 0.03)),
    ],
)
def test_a_cube_is_found_where_it_is(perceiver, direction, distance, roll, aside):
    truth = pose_towards(direction, distance, roll, aside)
    poses = found(perceiver, picture([truth], seed=3))
    assert len(poses) == 1
    degrees, share = errors(poses[0], truth)
    assert degrees < 5.0
    assert share < 0.05


@pytest.mark.parametrize("larger", [2, 5])
def test_it_is_found_in_a_picture_in_which_it_is_larger_than_any_that_it_was_learned_from(perceiver, larger):
    """Here it is 290 and 720 pixels large, and was 160 at most."""
    truth = pose_towards(CORNER, 0.60)
    image = cv2.resize(picture([truth], seed=3), None, fx=larger, fy=larger, interpolation=cv2.INTER_CUBIC)
    (pose,) = found(perceiver, image, CAMERA.resized(image.shape[1], image.shape[0]))
    degrees, share = errors(pose, truth)
    assert degrees < 5.0
    assert share < 0.05


def test_two_of_a_type_are_both_found(perceiver):
    truths = [pose_towards(CORNER, 0.6, 0.2, (-0.09, 0.0)), pose_towards((0.7, 0.8, 0.9), 0.6, -0.5, (0.1, 0.0))]
    poses = found(perceiver, picture(truths))
    assert len(poses) == 2
    for truth in truths:
        assert any(degrees < 5.0 and share < 0.05 for degrees, share in (errors(pose, truth) for pose in poses))


def test_where_it_is_not_the_empty_world_is_on_top(perceiver):
    rng = np.random.default_rng(0)
    plain = picture([])
    noise = rng.integers(0, 256, plain.shape, np.uint8)
    print_of_others = paint(77)[: plain.shape[0], : plain.shape[1]].copy()
    smooth = cv2.GaussianBlur(noise, (0, 0), 2.0)
    for image in (plain, noise, smooth, print_of_others):
        assert found(perceiver, image) == []
    assert perceiver(Gamma(CAMERA, ()))["hypotheses"] == []


def test_its_mirror_image_is_not_it(perceiver):
    """Keypoints of a mirrored print lie where no turn of the cube has them."""
    image = picture([pose_towards(CORNER, 0.6)])
    assert found(perceiver, np.ascontiguousarray(image[:, ::-1])) == []


def test_in_a_noisy_picture_it_is_there_or_missed_but_nowhere_else(perceiver):
    truth = pose_towards(CORNER, 0.6)
    pictures = [picture([truth], noise=noise, seed=5) for noise in (12.0, 30.0)]
    off = [errors(pose, truth) for shown in pictures for pose in found(perceiver, shown)]
    assert [(degrees, share) for degrees, share in off if degrees >= 5.0 or share >= 0.05] == []


def test_the_same_picture_gives_the_same_answer(perceiver):
    image = picture([pose_towards(CORNER, 0.6, 0.3)], seed=1)
    assert np.array_equal(found(perceiver, image), found(perceiver, image))


def test_copies_of_the_process_change_nothing(tmp_path):
    """Five types of one look: what is told of each hypothesis is the same to the byte."""
    one = cloud(seen())
    kb = read_kb(write_knowledge(tmp_path, dict.fromkeys(("cube", "twin", "third", "fourth", "last"), one)))
    image = picture(
        [pose_towards(CORNER, 0.6, 0.2, (-0.09, 0.0)), pose_towards((0.7, 0.8, 0.9), 0.6, -0.5, (0.1, 0.0))]
    )
    texts, there = [], gamma(Perceiver(kb), image)
    for processes in (1, 2, 3):
        perceiver = Perceiver(kb, processes=processes)
        texts.append([text_of(perceiver(there)) for _ in range(2)])
    assert texts[0][0].count('"status":"accepted"') == 2
    assert texts == [[texts[0][0]] * 2] * 3


def test_what_is_accepted_is_what_the_document_says(perceiver):
    seen_now = gamma(perceiver, picture([pose_towards(CORNER, 0.6, 0.2, (-0.09, 0.0))]))
    accepted = perceiver.accepted(seen_now)
    told = [h for h in perceiver(seen_now)["hypotheses"] if h["status"] == "accepted"]
    assert [(b.object_type.name, b.camera_from_object.tolist(), chance) for b, chance in accepted] == [
        (h["type"], h["T_camera_object"], h["probability"]) for h in told
    ]
    assert len(told) == 1
