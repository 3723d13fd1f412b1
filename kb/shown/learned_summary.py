"""A learned type in a few lines: how much there is of it, how surely it is seen, and from where enough of it is expected."""

from dataclasses import dataclass

import numpy as np

from geometry.cones import even_directions
from kb.clouds.cloud import ObjectType
from kb.clouds.learned import LearnedCloud
from kb.clouds.lobes import in_lobe

MANY = 20
"""Expected features with which a type is found though most of them are missed."""
DIRECTIONS, AT_A_TIME = 200, 20
"""Viewpoints all around that are tried, and how many of them at a time."""


@dataclass(frozen=True)
class LearnedSummary:
    """``features``: ``keypoints`` and ``sides`` of edges; ``words``: different visual words of its appearances.

    ``hit`` and ``sigma`` (m): medians.

    ``distance`` (m at the reference focal length): where it is looked at from all around; ``share`` of these viewpoints
    expects at least ``MANY`` features; ``most``: how many the best of them expects. ``compounds``: of ``joined``
    features in all, ``largest`` of them in one.
    """

    detector: str
    features: int
    appearances: int
    words: int
    hit: float
    sigma: float
    distance: float
    share: float
    most: int
    keypoints: int
    sides: int
    compounds: int = 0
    joined: int = 0
    largest: int = 0

    @property
    def lines(self) -> tuple[str, str]:
        """For people."""
        what = (
            f"{self.keypoints} keypoints and {self.sides} sides of edges" if self.sides else f"{self.features} features"
        )
        what += f", {self.joined} of them in {compounds_text(self.compounds, self.largest)}" if self.compounds else ""
        first = f"learned with {self.detector}: {what}, {self.appearances} appearances, {self.words} visual words"
        sure = f"hit rate {self.hit:.2f} and sigma {1000.0 * self.sigma:.2g} mm (medians)"
        seen = (
            f"{MANY} or more features are expected from {self.share:.0%} of the view sphere, {self.distance:.2g} m away"
        )
        return first, f"{sure}; {seen}"


def compounds_text(count: int, largest: int) -> str:
    """How many compound features there are, and of how many parts."""
    return f"{count} compound{'' if count == 1 else 's'} of 2{f' to {largest}' if largest > 2 else ''}"


def compound_sizes(cloud: LearnedCloud) -> tuple[int, int, int]:
    """The number of compound features, of features in them, and of the parts of the largest."""
    sizes = np.bincount(cloud.compound)[1:]
    return len(sizes), int(sizes.sum()), int(sizes.max(initial=0))


def learned_summary(kind: ObjectType) -> LearnedSummary:
    """Of a type that has a learned cloud."""
    cloud = kind.learned
    assert cloud is not None  # noqa: S101 - the caller looks
    if not len(cloud.feature):
        return LearnedSummary(cloud.detector, len(cloud.at), 0, 0, 0.0, 0.0, 0.0, 0.0, 0, len(cloud.at), 0)
    distance = float(np.median(np.sqrt(np.maximum(cloud.r_min, 1e-3 * cloud.r_max) * cloud.r_max)))
    expected = _expected(kind, distance)
    sides = len(np.unique(cloud.feature[cloud.sided]))
    return LearnedSummary(
        cloud.detector,
        len(cloud.at),
        len(cloud.feature),
        len(np.unique(cloud.lobe_word)),
        float(np.median(cloud.hit)),
        float(np.median(cloud.sigma)),
        distance,
        float((expected >= MANY).mean()),
        int(expected.max()),
        len(cloud.at) - sides,
        sides,
        *compound_sizes(cloud),
    )


def _expected(kind: ObjectType, distance: float) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """(DIRECTIONS,) features with a lobe that holds the viewpoint: lobes were measured on the whole object, so it hides nothing more."""
    table = kind.lobes
    centre = kind.surface.centre if kind.surface is not None else table.at.mean(axis=0)
    viewpoints = centre + distance * even_directions(DIRECTIONS)
    counts = []
    for start in range(0, DIRECTIONS, AT_A_TIME):
        held = in_lobe(table, viewpoints[start : start + AT_A_TIME], 1.0)
        counts += [len(np.unique(table.feature[row])) for row in held]
    return np.array(counts)
