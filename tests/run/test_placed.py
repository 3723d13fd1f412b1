"""The words in which an accepted object's place is told."""

from __future__ import annotations

import pytest

from plogic.run.document import placed_in


@pytest.mark.parametrize(
    ("origin", "told"),
    [
        ((0.12, -0.031, 0.84), "at (0.12, -0.03, 0.84) m, 0.85 m away"),
        ((-0.001, 0.0, 12.345), "at (0.00, 0.00, 12.35) m, 12.35 m away"),
        ((0.002, -0.00004, 0.0312), "at (0.002, 0.000, 0.031) m, 0.031 m away"),
    ],
)
def test_a_place_has_two_digits_of_its_distance_at_least_and_no_minus_zero(origin, told):
    pose = [[1.0, 0.0, 0.0, origin[0]], [0.0, 1.0, 0.0, origin[1]], [0.0, 0.0, 1.0, origin[2]], [0.0, 0.0, 0.0, 1.0]]
    rows = [{"id": "h1", "type": "cup", "status": "accepted", "probability": 0.5, "T_camera_object": pose}]
    (line,) = placed_in({"hypotheses": rows})
    assert line == f"h1 cup (0.500) {told}"


def test_what_its_rival_left_nothing_is_not_told_as_found():
    pose = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]]
    row = {"type": "cup", "status": "accepted", "T_camera_object": pose}
    rows = [row | {"id": "h1", "probability": 0.0004}, row | {"id": "h2", "probability": 0.0006}]
    late = row | {"id": "h3", "probability": 0.0, "interval": [0.0, 0.4]}
    assert [line.split()[0] for line in placed_in({"hypotheses": [*rows, late]})] == ["h2", "h3"]
