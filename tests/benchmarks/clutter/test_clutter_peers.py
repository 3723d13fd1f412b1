"""The peers of ``plogic bench clutter``.

Each finds an easy object, and answers nothing where there is nothing to be found.
"""

from __future__ import annotations

from itertools import count

import numpy as np
import pytest

from benchmarks.clutter import quadruples as of_quadruples
from benchmarks.clutter import ransac as of_ransac
from benchmarks.clutter import softposit as of_softposit
from benchmarks.clutter.pairs import typed
from benchmarks.clutter.peers import PEERS, Peer, there
from benchmarks.clutter.quadruples import _seen, quadruples
from benchmarks.clutter.ransac import lo_ransac
from benchmarks.clutter.scenes import CAMERA, trial
from benchmarks.clutter.softposit import _depths, soft_posit
from benchmarks.clutter.types import Detector, random_types
from benchmarks.recognition.score import Found, pose_right
from plogic.match.plain.quadruples import drawn
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from sensing.appearance import Appearance, Gamma

EXACT = Detector("exact", 1.0, 0.0, 0.0)
LOOKS = 10
"""Types that a peer tries, all rounds together, before its time is over."""
ASKED = [pytest.param(peer, id=peer.name) for peer in PEERS]


@pytest.fixture(scope="module")
def kb():
    """Of types whose places are known to be sharp, so that few other data lie near enough to a feature's."""
    return random_types(3, 60, 40, np.random.default_rng(2), Detector("sharp", 0.8, 0.2, 0.05))


def gamma_of(*types):
    return Gamma(CAMERA, tuple(Appearance(f"d{i}", name, (float(i), 0.0), "made") for i, name in enumerate(types)))


def asked(peer, kb, gamma, seconds):
    """The answer within so many seconds of a clock on which a second passes whenever it is looked at: no test waits."""
    if peer.package:
        pytest.importorskip(peer.package)
    clock = count()
    with pytest.MonkeyPatch.context() as patch:
        for module in (of_quadruples, of_softposit, of_ransac):
            patch.setattr(module, "processor_seconds", lambda: next(clock))
        return peer.ask(kb, gamma, seconds)


@pytest.mark.parametrize("peer", ASKED)
@pytest.mark.parametrize("seed", [1, 2])
def test_each_finds_an_easy_object_among_three_types(kb, peer, seed):
    """Of easy poses: from others, as from that of seed 0, no random start of SoftPOSIT leaves the local minima."""
    posed = trial(kb.types[seed], kb, EXACT, np.random.default_rng(seed), 80)
    answer = asked(peer, kb, posed.gamma, LOOKS)
    assert answer is not None
    assert answer[0] == posed.truth.type
    assert pose_right(Found(*answer), posed.truth)


@pytest.mark.parametrize("peer", ASKED)
def test_without_data_or_time_each_answers_nothing(peer):
    kb = random_types(2, 30, 10, np.random.default_rng(2))
    assert asked(peer, kb, gamma_of(), 0.05) is None
    assert asked(peer, kb, gamma_of("a000", "a001", "a002"), 0.05) is None
    assert asked(peer, kb, gamma_of(*["a000"] * 50), -1.0) is None


def test_a_set_is_of_four_co_visible_features_and_as_many_data_that_look_like_them(kb):
    kind, posed = kb.types[1], trial(kb.types[1], kb, EXACT, np.random.default_rng(1), 200)
    pairs = next(pairs for pairs in typed(kb, posed.gamma) if pairs.kind is kind)
    dv = distinctiveness(instance_counts(kb.types))
    rng = np.random.default_rng(0)
    feature, datum = drawn(pairs, _seen(pairs, rng), np.array([dv[f.type] for f in kind.features]), rng)
    assert feature.shape == datum.shape == (1000, 4)
    assert all(len(set(row)) == 4 for row in [*feature.tolist(), *datum.tolist()])
    assert {
        (f, d) for row in zip(feature.tolist(), datum.tolist(), strict=True) for f, d in zip(*row, strict=True)
    } <= set(zip(pairs.feature.tolist(), pairs.datum.tolist(), strict=True))
    worth = np.array([dv[f.type] for f in kind.features])[feature].sum(axis=1)
    assert (np.diff(worth) <= 0).all()
    axis = kind.lobes.axis[feature]
    assert (axis @ np.swapaxes(axis, 1, 2)).min() >= np.cos(
        np.radians(151)
    )  # two lobes of 75 degrees that hold one far viewpoint


def test_depths_hold_all_that_trials_show(kb):
    for seed in range(20):
        posed = trial(kb.types[seed % 3], kb, EXACT, np.random.default_rng(seed), 80)
        (pairs,) = (pairs for pairs in typed(kb, posed.gamma) if pairs.kind.name == posed.truth.type)
        nearest, farthest = _depths(pairs, CAMERA.f)
        assert nearest < (posed.truth.camera_from_object @ [*posed.truth.centre, 1.0])[2] < farthest


def test_the_three_of_the_issue_are_asked():
    assert [peer.ask for peer in PEERS] == [quadruples, soft_posit, lo_ransac]


def test_who_is_not_installed_is_left_out_and_it_is_said():
    said = []
    mine, absent = Peer("mine", "", lo_ransac), Peer("theirs", "no_such_package_anywhere", lo_ransac)
    assert there(said.append, (absent, mine)) == (mine,)
    assert said == ["theirs: left out, for the package no_such_package_anywhere is not installed"]
