"""Simulated scenes of a KB's types: the wiring between meshes of Σ and the simulated camera, which knows no types."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from sensing.simulated.body import TexturedMesh


def shapes_of(kb: KnowledgeBase, names: Sequence[str] | None = None) -> list[tuple[str, TexturedMesh]]:
    """(label, textured mesh) of the named types, or of all that have a mesh. Raises InputError where a type has none."""
    types = kb.types if names is None else [kb.type(name) for name in names]
    return [(t.name, _mesh(t)) for t in types]


def tell_without_physics(say: Callable[[str], None]) -> None:
    """Say how pictures are made on this machine where pybullet is not installed."""
    from sensing.simulated.physics import INSTALL, NO_PHYSICS, has_physics

    if not has_physics():
        say(f"pictures are drawn by rays, and nothing falls or settles, for {NO_PHYSICS}: {INSTALL}")


def _mesh(object_type: ObjectType) -> TexturedMesh:
    from sensing.simulated.meshes import read_mesh

    if object_type.mesh_file is None:
        raise InputError(f"{object_type.name}: has no mesh, so that it cannot be rendered")
    return read_mesh(object_type.mesh_file, object_type.mesh_scale)
