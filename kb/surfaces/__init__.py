"""Surfaces of types (§2.8): triangles, faces, solids, symmetries, and the repair of meshes."""
