"""The pieces that a mesh falls into: seams split none, specks are none, and every triangle belongs to one."""

from __future__ import annotations

import numpy as np
import pytest
from made_meshes import CORNERS, box_triangles, split_box
from twin_cubes import APART, cubes

from kb.surfaces.pieces import MOST, pieces_of
from kb.surfaces.surface import Surface, welded


def boxes(*rows):
    """Boxes of (side, middle), each with its own vertices."""
    vertices = np.concatenate([(CORNERS - 0.5) * side + np.asarray(middle, float) for side, middle in rows])
    return Surface(vertices, np.concatenate([box_triangles() + 8 * i for i in range(len(rows))]))


def holds_each_triangle_once(surface, pieces):
    return sorted(np.concatenate([piece.triangles for piece in pieces]).tolist()) == list(range(len(surface.triangles)))


def test_what_hangs_together_has_no_parts_though_seams_split_it():
    vertices, triangles, _ = split_box()
    assert pieces_of(welded(vertices, triangles)) == ()
    assert len(pieces_of(Surface(vertices, triangles))) == 6, "unwelded, each side is alone"


def test_two_cubes_with_seams_are_two_parts():
    vertices, triangles, _ = cubes()
    surface = welded(vertices, triangles)
    pieces = pieces_of(surface)
    assert [piece.name for piece in pieces] == ["part_1", "part_2"]
    assert sorted(piece.at[2] for piece in pieces) == pytest.approx([0.0, APART])
    assert [piece.share for piece in pieces] == pytest.approx([0.5, 0.5])
    assert holds_each_triangle_once(surface, pieces)


def test_the_largest_is_the_first_and_a_speck_joins_the_nearest():
    surface = boxes((1.0, (5, 0, 0)), (2.0, (0, 0, 0)), (0.05, (5.6, 0, 0)), (0.05, (-1.2, 0, 0)))
    pieces = pieces_of(surface)
    assert [len(piece.triangles) for piece in pieces] == [24, 24]
    assert pieces[0].at == pytest.approx([-0.1125, 0, 0])  # the box of both, the speck's 1.225 beyond
    assert str(pieces[0]) == "{part: part_1, at: [-0.1125, 0, 0]}"
    assert pieces[1].at[0] == pytest.approx((4.5 + 5.625) / 2)
    assert holds_each_triangle_once(surface, pieces)


def test_one_large_piece_among_specks_is_the_whole():
    assert pieces_of(boxes((2.0, (0, 0, 0)), *((0.05, (1.2 + 0.1 * i, 0, 0)) for i in range(5)))) == ()


def test_there_are_parts_up_to_a_limit():
    surface = boxes(*((0.5 + 0.001 * i, (i, 0, 0)) for i in range(MOST + 9)))
    pieces = pieces_of(surface)
    assert len(pieces) == MOST
    assert pieces[0].at[0] == pytest.approx(MOST + 8)
    assert holds_each_triangle_once(surface, pieces)


def test_what_touches_at_a_corner_hangs_together():
    surface = boxes((1.0, (0, 0, 0)), (1.0, (1, 1, 1)))
    assert len(pieces_of(surface)) == 2
    assert pieces_of(welded(surface.vertices, surface.triangles)) == ()


def test_nothing_but_specks_is_one():
    """400 equal pieces, none of which has a hundredth of the area: there is nothing to tell apart."""
    assert pieces_of(boxes(*((0.5, (i % 20, i // 20, 0)) for i in range(400)))) == ()
