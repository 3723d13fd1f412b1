"""What a mesh may be at most, and at least."""

MAX_FILE_BYTES = 200_000_000
"""Largest mesh file; it is refused before it is read."""
MAX_TRIANGLES = 2_000_000
"""Most triangles of a mesh."""
SMALLEST, LARGEST = 1e-4, 1e4
"""Extent of a mesh's longest side, m: what is outside is the wrong unit, or nothing that a camera sees."""
FEW, MOST = 4_000, 16_000
"""Triangles of the geometry that is kept: at most the few, or, where these would be too far from the mesh, up to the
most."""
DEVIATIONS = (0.0005, 0.001, 0.002, 0.003)
"""How far it may be from the mesh, as shares of the diameter: the first that does with the few triangles; the last is
too far."""
LARGEST_HOLE = 0.2
"""A hole is filled whose bounding box's diagonal is at most this share of the mesh's; a larger one may be meant: a
mug's mouth."""
FORMATS = ("obj", "ply", "stl", "glb", "gltf", "off", "dae")
"""Suffixes of the mesh files that are read; DAE where pycollada is installed."""
