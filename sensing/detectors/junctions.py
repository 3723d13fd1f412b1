"""Junctions: places where edges meet, typed by how their arms lie (appearance types ``l_junction`` ... ``multi_junction``).

Segments are found in the picture with its patches painted out (a window's corner is no object's corner), intersected
near their ends, and each place's arms are counted, those included that only the brightness shows.

=====================  ====  ====================================  ==========================================
kind                   arms  configuration                         ``angle``
=====================  ====  ====================================  ==========================================
``l_junction``         2     not straight                          bisector of the inner angle
``y_junction``         3     every gap below 168°                  the arm nearest to straight down (+v)
``t_junction``         3     the largest gap within 180° ± 12°     the stem
``arrow_junction``     3     a gap above 192°                      the shaft, the arm opposite that gap
``multi_junction``     4+    any                                   opposite to the largest gap's middle
=====================  ====  ====================================  ==========================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.appearance import Appearance
from sensing.detectors.arms import completed, steps
from sensing.detectors.meetings import find_meetings
from sensing.detectors.painting_out import without_patches
from sensing.detectors.patches import find_patches
from sensing.detectors.segments import find_segments

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sensing.detectors.meetings import Meeting

    Floats = NDArray[np.float64]

TYPES = ("l_junction", "y_junction", "arrow_junction", "t_junction", "multi_junction")
STRAIGHT = np.radians(12.0)
"""A gap this near to 180° counts as straight."""


class JunctionDetector:
    """Reports junctions with ``angle`` and ``arms`` (see the module), ``scale`` (the shortest arm) and ``score``."""

    name = "junction"
    types: tuple[str, ...] = TYPES

    def detect(self, image_bgr: NDArray[np.uint8]) -> list[Appearance]:
        """Junctions of an (H, W, 3) uint8 image."""
        import cv2

        grey = np.asarray(cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY), np.uint8)
        patches = find_patches(grey).corners
        bare = [without_patches(channel, patches) for channel in _channels(image_bgr, grey)]
        meetings = find_meetings(find_segments(bare))
        if not meetings:
            return []
        places = np.array([m.place for m in meetings])
        soft = [np.asarray(cv2.GaussianBlur(channel, (0, 0), 0.8), np.float32) for channel in bare]
        step, least = (np.max(x, axis=0) for x in zip(*(steps(channel, places) for channel in soft), strict=True))
        height, width = grey.shape
        found = [
            self._appearance(m, *completed(s, low, m.arms, m.lengths))
            for m, s, low in zip(meetings, step, least, strict=True)
        ]
        return [a for a in found if a is not None and 0 <= a.uv[0] <= width - 1 and 0 <= a.uv[1] <= height - 1]

    def _appearance(self, meeting: Meeting, arms: Floats, lengths: Floats) -> Appearance | None:
        named = kind(arms)
        if named is None:
            return None
        a_type, angle = named
        score = float(np.clip(lengths.min() / 20, 0.1, 1) / (1 + meeting.gap / 4))
        uv = (float(meeting.place[0]), float(meeting.place[1]))
        return Appearance("", a_type, uv, self.name, angle, float(lengths.min()), score, tuple(float(x) for x in arms))


def _channels(image_bgr: NDArray[np.uint8], grey: NDArray[np.uint8]) -> list[NDArray[np.float32]]:
    """Brightness, and warm against cold (red minus blue, halved): an edge between equally bright colours shows in the second alone."""
    warm = (image_bgr[:, :, 2].astype(np.float32) - image_bgr[:, :, 0].astype(np.float32)) / 2 + 128
    return [grey.astype(np.float32), warm.astype(np.float32)]


def kind(arms: Floats) -> tuple[str, float] | None:
    """The type and the angle of a junction with these arms, (k,) ascending in [0, 2π); None for fewer than two or a straight line."""
    if len(arms) < 2:
        return None
    gaps = np.mod(np.roll(arms, -1) - arms, 2 * np.pi)
    widest = int(np.argmax(gaps))
    inner = _direction(arms[widest] + gaps[widest] / 2 + np.pi)
    if len(arms) == 2:
        return None if abs(gaps[widest] - np.pi) < STRAIGHT else ("l_junction", inner)
    if len(arms) > 3:
        return "multi_junction", inner
    opposite = _direction(arms[(widest + 2) % 3])
    if gaps[widest] > np.pi + STRAIGHT:
        return "arrow_junction", opposite
    if gaps[widest] > np.pi - STRAIGHT:
        return "t_junction", opposite
    return "y_junction", _direction(arms[int(np.argmax(np.sin(arms)))])


def _direction(angle: float) -> float:
    return float(np.mod(angle, 2 * np.pi))
