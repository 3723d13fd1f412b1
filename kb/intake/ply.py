"""A surface as a binary PLY, in metres and in double precision: the same bytes for the same surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kb.surfaces.surface import Surface

HEAD = """ply
format binary_little_endian 1.0
comment metres
element vertex {}
property double x
property double y
property double z
element face {}
property list uchar int vertex_indices
end_header
"""


def ply_bytes(surface: Surface) -> bytes:
    """The file's bytes."""
    facets = np.empty(len(surface.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    facets["count"], facets["corners"] = 3, surface.triangles
    head = HEAD.format(len(surface.vertices), len(surface.triangles))
    return head.encode() + surface.vertices.astype("<f8").tobytes() + facets.tobytes()
