"""Targets, matching and recalls, by hand."""

import numpy as np
import pytest

from geometry.camera import Camera
from plogic.run.bop.dataset import Truth
from plogic.run.bop.models import Model
from plogic.run.bop.recalls import Recalls, View, matched, score, taken, targets_of
from plogic.run.bop.results_file import Estimate

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05
DIAMETER = 0.1 * np.sqrt(3)
QUARTERS = np.array([np.block([[c, -s], [s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))])
WIDE = Camera(1280, 960, np.array([[1000.0, 0, 640], [0, 1000, 480], [0, 0, 1]]))
VGA = Camera(640, 480, np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]]))

SHIFTS = [(VGA, 4.9, 10), (VGA, 5.1, 9), (VGA, 22, 6), (WIDE, 9.8, 10), (WIDE, 10.2, 9), (WIDE, 101, 0)]


def model(symmetries=None):
    return Model(CUBE, DIAMETER, np.eye(4)[None] if symmetries is None else symmetries)


def at(x=0.0, y=0.0, z=1.0, quarter=0):
    pose = np.eye(4)
    pose[:2, :2] = QUARTERS[quarter]
    pose[:3, 3] = x, y, z
    return pose


def found(pose, obj_id=1, sure=1.0):
    return Estimate(1, 0, obj_id, sure, pose)


def view(truths, estimates, camera=VGA, wanted=None):
    return View(tuple(truths), tuple(estimates), camera, wanted)


def together(*views, **models):
    return score(views, {1: model(), 2: model(), **{int(k[1:]): m for k, m in models.items()}}).together


def test_the_truth_itself_scores_one():
    assert together(view([Truth(1, at())], [found(at())])) == Recalls(1, 1.0, 1.0, 1.0)


def test_nothing_found_scores_zero():
    assert together(view([Truth(1, at())], [], camera=None)) == Recalls(1, 0.0, 0.0, 0.0)


def test_nothing_to_find_has_no_recall():
    scores = score([view([], [found(at(), 7)])], {})
    assert scores.together == Recalls(0, None, None, None)
    assert scores.together.mean_of_the_two is None
    assert (scores.images, scores.estimates, scores.absent) == (1, 1, 1)


@pytest.mark.parametrize(("share", "passed"), [(0.049, 10), (0.051, 9), (0.22, 6), (0.499, 1), (0.501, 0)])
def test_mssd_counts_thresholds_of_the_diameter(share, passed):
    """A translation along the optical axis: MSSD is its length."""
    recalls = together(view([Truth(1, at())], [found(at(z=1 + share * DIAMETER))]))
    assert recalls.ar_mssd == pytest.approx(passed / 10)


@pytest.mark.parametrize(("camera", "pixels", "passed"), SHIFTS)
def test_mspd_counts_pixels_of_an_image_640_wide(camera, pixels, passed):
    """The nearest face, at 0.95 m, sets the shift: f · x / 0.95 px.

    Twice the pixels are let pass where the image is twice as wide.
    """
    x = pixels * 0.95 / camera.K[0, 0]
    recalls = together(view([Truth(1, at())], [found(at(x=x))], camera))
    assert recalls.ar_mspd == pytest.approx(passed / 10)


@pytest.mark.parametrize(("share", "recall"), [(0.099, 1.0), (0.101, 0.0)])
def test_add_counts_a_tenth_of_the_diameter(share, recall):
    assert together(view([Truth(1, at())], [found(at(z=1 + share * DIAMETER))])).add == recall


def test_symmetric_objects_count_by_add_s():
    """A quarter turn: a side long by ADD, nothing by ADD-S; which of the two counts is the model's to say."""
    turned = view([Truth(1, at())], [found(at(quarter=1))])
    group = np.array([at(0, 0, 0, quarter=i) for i in range(4)])
    assert together(turned).add == 0
    assert together(turned, _1=model(group)) == Recalls(1, 1.0, 1.0, 1.0)


def test_the_mean_of_the_two():
    recalls = Recalls(3, 0.2, 0.6, 0.5)
    assert recalls.mean_of_the_two == pytest.approx(0.4)


def test_matching_goes_by_score_and_takes_the_lowest_error():
    assert matched([[0.3, 0.1], [0.2, 0.05]], 0.5) == [(0, 1), (1, 0)]
    assert matched([[0.3, 0.1], [0.6, 0.05]], 0.5) == [(0, 1)]
    assert matched([[0.5]], 0.5) == []
    assert matched(np.zeros((2, 0)), 0.5) == []
    assert matched(np.zeros((3, 1)), 0.5) == [(0, 0)]


def test_only_the_best_scored_estimates_count():
    """One instance is wanted, so that the second-best estimate is not tried: BOP's localization."""
    truths = [Truth(1, at())]
    assert together(view(truths, [found(at(), sure=0.4), found(at(x=1), sure=0.9)])) == Recalls(1, 0.0, 0.0, 0.0)
    assert together(view(truths, [found(at(), sure=0.9), found(at(x=1), sure=0.4)])) == Recalls(1, 1.0, 1.0, 1.0)


def test_two_instances_of_one_object():
    truths = [Truth(1, at()), Truth(1, at(x=0.5))]
    both = [found(at(x=0.5), sure=0.4), found(at(), sure=0.9)]
    assert together(view(truths, both)).ar_mssd == 1
    assert together(view(truths, [found(at(), sure=0.4), found(at(), sure=0.9)])).ar_mssd == 0.5


def test_hidden_objects_are_no_targets():
    truths = [Truth(1, at(), 0.09), Truth(1, at(x=0.5), 0.1), Truth(2, at(y=0.3))]
    assert {n: len(rows) for n, rows in targets_of(view(truths, [])).items()} == {1: 1, 2: 1}
    assert together(view(truths, [found(at(x=0.5)), found(at(y=0.3), 2)])) == Recalls(2, 1.0, 1.0, 1.0)


def test_a_list_of_targets_rules():
    """The most visible as many as are wanted, whatever their visibility.

    Others and their estimates count for nothing.
    """
    truths = [Truth(1, at(), 0.05), Truth(1, at(x=0.5), 0.07), Truth(2, at(y=0.3), 1.0)]
    one = view(truths, [found(at(x=0.5)), found(at(), sure=0.5), found(at(y=0.3), 2)], wanted={1: 1})
    assert [t.visible for t in targets_of(one)[1]] == [0.07]
    assert list(targets_of(one)) == [1]
    assert len(taken(one, 1, 1)) == 1
    assert together(one) == Recalls(1, 1.0, 1.0, 1.0)


def test_estimates_of_absent_objects_are_counted():
    scores = score([view([Truth(1, at(), 0.0)], [found(at()), found(at(), 2), found(at(), 2)])], {})
    assert (scores.estimates, scores.absent, scores.together.targets) == (3, 2, 0)


def test_objects_apart_and_together():
    """Recall is over all instances, not the mean of the objects'."""
    truths = [Truth(1, at()), Truth(1, at(x=0.5)), Truth(1, at(x=-0.5)), Truth(2, at(y=0.3))]
    scores = score([view(truths, [found(at(y=0.3), 2)])], {1: model(), 2: model()})
    assert scores.together.ar_mssd == 0.25
    assert {n: (r.targets, r.ar_mssd) for n, r in scores.objects.items()} == {1: (3, 0.0), 2: (1, 1.0)}
