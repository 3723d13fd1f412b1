"""Photos have thousands of data of one word: pairs are looked at in pieces, which changes nothing but the memory."""

from __future__ import annotations

import tracemalloc
from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from moved_views import RATES, all_of, blob, ring, views_of

from plogic.sequence.constancy import decide, tracks
from plogic.sequence.constancy.sight_lines import sights_of


def sights_with(clutter, frames):
    rng = np.random.default_rng(3)
    views, _ = views_of(blob(rng), ring(frames), rng, clutter=clutter)
    return sights_of(views, all_of(views), RATES)


@pytest.mark.parametrize("block", [1, 7, 200])
def test_pieces_change_no_track(monkeypatch, block):
    sights = sights_with(30, 3)
    whole = tracks.tracks_of(sights)
    assert len(whole.data) > 20
    monkeypatch.setattr(tracks, "BLOCK", block)
    pieces = tracks.tracks_of(sights)
    assert np.array_equal(pieces.data, whole.data)
    assert np.array_equal(pieces.places.at, whole.places.at)


def test_pairs_of_thousands_take_little_memory(monkeypatch):
    sights = sights_with(2500, 2)
    monkeypatch.setattr(tracks, "BLOCK", 100_000)
    tracemalloc.start()
    pairs = tracks.pairs_of(sights)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    alike = sum(int((sights.kind[0] == kind).sum()) * int((sights.kind[1] == kind).sum()) for kind in range(50))
    assert alike > 1_000_000
    assert len(pairs) > 0
    assert most < 100_000 * 400 + pairs.nbytes * 3


@pytest.mark.parametrize("v", [0, 1, 2])
def test_what_a_track_takes_up_is_the_nearest_of_all_data_of_its_type(v):
    sights = sights_with(200, 3)
    some = tracks._plausible(sights, tracks.pairs_of(sights))
    expected = some.data.copy()
    ideal, spread = tracks._images(sights, some, v)
    for t in np.flatnonzero((some.data[:, v] < 0) & np.isfinite(ideal).all(axis=1)):
        data = np.flatnonzero(sights.kind[v] == some.kind[t])
        off = sights.xy[v, data] - ideal[t]
        squared = np.einsum("ni,ij,nj->n", off, np.linalg.inv(spread[t]), off)
        if len(data) and squared.min() < tracks.GATE:
            expected[t, v] = data[squared.argmin()]
    assert (expected != some.data).any()
    assert np.array_equal(tracks._taken_up(sights, some, v), expected)


def test_data_of_which_there_are_too_many_alike_are_undecided_and_change_nothing_else(monkeypatch):
    rng = np.random.default_rng(3)
    views, _ = views_of(blob(rng), ring(3), rng, clutter=30)
    whole = decide.unknown_objects(views, all_of(views), RATES)
    counts = [Counter(a.type for a in view.gamma.appearances) for view in views]
    commonest = max(counts[0], key=lambda kind: counts[0][kind] * counts[1][kind])
    most = max(one[kind] * other[kind] for one, other in combinations(counts, 2) for kind in one if kind != commonest)
    assert any(one[commonest] * other[commonest] > most for one, other in combinations(counts, 2))
    monkeypatch.setattr(decide, "MOST_ALIKE", most)
    found = decide.unknown_objects(views, all_of(views), RATES)
    alike = {view.id: {a.id for a in view.gamma.appearances if a.type == commonest} for view in views}
    assert all(alike[name] <= set(some) for name, some in found.undecided.items())
    of = {f.type for u in found.unknown for f in u.features}
    assert commonest not in of
    assert of <= {f.type for u in whole.unknown for f in u.features}
    assert of
