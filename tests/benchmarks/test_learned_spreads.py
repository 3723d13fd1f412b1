"""The fits of ``benchmarks/learned_spreads.py`` find their true values, and the benchmark's own scenes are refused."""

import argparse
import importlib.util
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from plogic.match.learned import learned_match as looks

FOLDER = Path(__file__).parent.parent.parent / "benchmarks"


@pytest.fixture(scope="module")
def spreads():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))  # as python has it that runs the script
        spec = importlib.util.spec_from_file_location("learned_spreads", FOLDER / "learned_spreads.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module
    sys.modules.pop("learned_seen", None)


@pytest.mark.parametrize("text", ["0..59", "4999..5023", "5023..5000", "5000", "first..last"])
def test_scenes_of_the_benchmark_and_what_is_no_range_are_refused(spreads, text):
    with pytest.raises(argparse.ArgumentTypeError):
        spreads.seeds(text)


def test_a_range_of_scenes_is_read(spreads):
    assert spreads.seeds("5000..5023") == (5000, 5023)


def test_a_spread_and_an_even_share_are_found_again(spreads):
    rng = np.random.default_rng(1)
    off = np.where(rng.random(20_000) < 0.3, rng.uniform(-1.0, 1.0, 20_000), rng.normal(0.0, 0.1, 20_000))
    sigma, share, loss = spreads.fitted(partial(spreads.bell, off), np.full(len(off), 0.5), 0.1, 0.3)
    assert (sigma, share) == (pytest.approx(0.1, rel=0.05), pytest.approx(0.3, abs=0.02))
    assert 0.0 <= loss < 0.001
    assert spreads.fitted(partial(spreads.bell, off), np.full(len(off), 0.5), 0.2, 0.1)[2] > 0.05


def test_no_spread_is_told_of_a_few(spreads):
    assert np.isnan(spreads.fitted(partial(spreads.bell, np.zeros(3)), np.ones(3), 0.1, 0.1)).all()


def test_a_power_is_found_again(spreads):
    assert spreads.power(np.random.default_rng(2).random(20_000) ** (1.0 / 6.0)) == pytest.approx(6.0, rel=0.03)


def test_a_line_has_the_constant_as_it_is_now(spreads, monkeypatch):
    monkeypatch.setattr(looks, "TURNS", 0.77)
    assert spreads.line(looks, "TURNS", 0.134, "what").split() == ["learned_match.TURNS", "0.77", "0.134", "what"]
