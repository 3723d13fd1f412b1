"""Clouds that were learnt before, by all that decides them: the mesh as it is rendered, the options, our own source, the libraries.

Nobody has to remember to change a version: what was learnt by other code, or with another threshold, is not found and learnt anew.
"""

from __future__ import annotations

import ast
import hashlib
import os
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from kb.cloud import KnowledgeBase, ObjectType
    from kb.learning.photo import PaintedMesh
    from kb.learnt import LearntCloud
    from sensing.simulated.body import TexturedMesh

ROOT = Path(__file__).parents[2]
"""The folder that our packages lie in."""
DECIDES = "plogic/commands/kb_learn_look.py"
"""What makes a cloud, with all that it imports."""
LIBRARIES = ("numpy", "scipy", "pybullet", "trimesh")
"""They read, render and compute. OpenCV, which detects, comes under several names, so it is asked itself."""


def learnt_of(
    kind: ObjectType, kb: KnowledgeBase, options: Mapping[str, Any], say: Callable[[str], None], painted: PaintedMesh | None = None
) -> LearntCloud:
    """The cloud of a type from the cache, or learnt and put there; raises as ``looked`` does."""
    from kb.errors import CloudError
    from kb.learnt import cloud_bytes, read_cloud
    from plogic.commands.kb_learn_look import looked
    from sensing.errors import SensingError
    from sensing.simulated.meshes import read_mesh
    from sensing.whole_files import write_whole

    assert kind.mesh_file is not None  # noqa: S101 - the caller looked
    folder = cache_folder()
    if folder is None:
        say(f"{kind.name}: is not remembered for the next time: there is no home folder; XDG_CACHE_HOME may name another")
        return read_cloud(cloud_bytes(looked(kind, kb, options, say, painted)))
    how = (kb.f_ref, options["detector"], options["seed"], painted is not None)
    place = folder / f"{key_of(read_mesh(kind.mesh_file, kind.mesh_scale), how)}.npz"
    try:
        remembered = read_cloud(place.read_bytes())
    except (OSError, CloudError):
        content = cloud_bytes(looked(kind, kb, options, say, painted))
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            write_whole(place, content)
        except (OSError, SensingError) as error:
            say(f"{kind.name}: is not remembered for the next time: {error}")
        return read_cloud(content)  # in the file's precision, as it will come the next time: equal hit rates stay equal
    say(f"{kind.name}: was learnt before ({place})")
    return remembered


def cache_folder() -> Path | None:
    """Where clouds are kept; None where nobody knows the user's home."""
    home = os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(home) if home else Path.home() / ".cache") / "plogic" / "clouds"
    except RuntimeError:
        return None


def key_of(mesh: TexturedMesh, how: tuple[Any, ...]) -> str:
    """SHA-256 over a mesh with its paint, ``how`` it is learnt, the source that learns, and the versions of the libraries."""
    import cv2

    total = hashlib.sha256(repr((how, cv2.__version__, [version(name) for name in LIBRARIES])).encode())
    total.update(source_digest(ROOT, sources(ROOT, DECIDES)))
    for array in (mesh.vertices, mesh.triangles, mesh.uv, mesh.texture):
        total.update(b"-" if array is None else repr(array.shape).encode() + array.tobytes())
    return total.hexdigest()


def source_digest(root: Path, files: Iterable[str]) -> bytes:
    """SHA-256 over the names and the bytes of files below ``root``, in whatever order they come."""
    total = hashlib.sha256()
    for name in sorted(files):
        total.update(name.encode() + b"\0" + hashlib.sha256((root / name).read_bytes()).digest())
    return total.digest()


def sources(root: Path, first: str) -> set[str]:
    """A source file below ``root`` and all others there that it imports, at its top or in a function, directly or by way of others.

    What is imported for the type checker alone decides nothing and is left out.
    """
    found, left = {first}, [first]
    while left:
        tree = ast.parse((root / left.pop()).read_bytes())
        names = (name.replace(".", "/") for node in _run(tree) for name in _imported(node))
        new = {file for name in names for file in (f"{name}.py", f"{name}/__init__.py") if (root / file).is_file()} - found
        found |= new
        left += new
    return found


def _run(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes below one but those of ``if TYPE_CHECKING:``."""
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield child
            yield from _run(child)


def _imported(node: ast.AST) -> list[str]:
    """The modules that an import may name: of ``from kb import words`` both ``kb`` and ``kb.words``."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module is not None:
        return [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return []
