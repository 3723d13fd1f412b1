"""Clouds that were learned before, by all that decides them: the mesh as it is rendered, the options, our own source, the libraries.

Nobody has to remember to change a version: what was learned by other code, or with another threshold, is not found and
learned anew.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from plogic.base.remembered import ROOT, cache_folder, forget_files_beside, source_digest, sources

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from kb.clouds.learned import LearnedCloud
    from kb.learning.photo import PaintedMesh
    from sensing.simulated.body import TexturedMesh

DECIDES = "plogic/face/authoring/kb_learn_look.py"
"""What makes a cloud, with all that it imports."""
LIBRARIES = ("numpy", "scipy", "embreex", "trimesh")
"""They read, render and compute. OpenCV, which detects, and pybullet, which draws where it is installed, come under several names."""


def learned_of(
    kind: ObjectType,
    kb: KnowledgeBase,
    options: Mapping[str, Any],
    say: Callable[[str], None],
    painted: PaintedMesh | None = None,
) -> LearnedCloud:
    """The cloud of a type from the cache, or learned and put there; raises as ``looked`` does."""
    from kb.clouds.learned import cloud_bytes, read_cloud
    from kb.errors import CloudError
    from plogic.face.authoring.kb_learn_look import looked
    from sensing.errors import SensingError
    from sensing.files.whole_files import write_whole
    from sensing.simulated.body import read_mesh

    assert kind.mesh_file is not None  # noqa: S101 - the caller looked
    folder = cache_folder("clouds")
    if folder is None:
        say(
            f"{kind.name}: is not remembered for the next time: there is no home folder; XDG_CACHE_HOME may name another"
        )
        return read_cloud(cloud_bytes(looked(kind, kb, options, say, painted)))
    how = (kb.f_ref, options["detector"], options["seed"], painted is not None)
    place = folder / f"{key_of(read_mesh(kind.mesh_file, kind.mesh_scale), how)}.npz"
    try:
        remembered = _kept(place.read_bytes())
    except (OSError, CloudError):
        content = cloud_bytes(looked(kind, kb, options, say, painted))
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            write_whole(place, content)
            forget_files_beside(place)
        except (OSError, SensingError) as error:
            say(f"{kind.name}: is not remembered for the next time: {error}")
        return read_cloud(content)  # in the file's precision, as it will come the next time: equal hit rates stay equal
    with suppress(OSError):  # who may only read it uses it all the same
        os.utime(place)
    say(f"{kind.name}: was learned before ({place})")
    return remembered


def _kept(content: bytes) -> LearnedCloud:
    """The cloud of a file; raises CloudError where it is not what was written: an archive's own checksums are of its arrays, not of their names."""
    from kb.clouds.learned import cloud_bytes, read_cloud
    from kb.errors import CloudError

    cloud = read_cloud(content)
    if cloud_bytes(cloud) != content:
        raise CloudError("is not what was written")
    return cloud


def key_of(mesh: TexturedMesh, how: tuple[Any, ...]) -> str:
    """SHA-256 over a mesh with its paint, ``how`` it is learned, the source that learns, and the versions of the libraries."""
    import cv2

    from sensing.simulated.physics import physics_version

    total = hashlib.sha256(
        repr((how, cv2.__version__, physics_version(), [version(name) for name in LIBRARIES])).encode()
    )
    total.update(source_digest(ROOT, sources(ROOT, DECIDES)))
    for array in (mesh.vertices, mesh.triangles, mesh.uv, mesh.texture):
        total.update(b"-" if array is None else repr(array.shape).encode() + array.tobytes())
    return total.hexdigest()
