"""Photos have thousands of data of one word: pairs are looked at in pieces, which changes nothing but the memory."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from moved_views import RATES, all_of, blob, ring, views_of

from plogic.sequence.constancy import tracks
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
