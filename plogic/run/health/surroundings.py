"""What this machine lends: tools that may be there or not, limits in force, and the console."""

import os
import platform
import resource
import shutil
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from geometry.files.begun import temporary
from plogic.base.errors import InputError
from plogic.base.memory import VARIABLE, limit, whole
from plogic.run.health.findings import Finding, size

TOOLS, LIMITS, CONSOLE = "tools", "limits", "console"
FREE = 200_000_000
"""Fewest bytes that should be free where files are written."""
SPACE = 4 << 30
"""Bytes of address space below which commands may end for want of memory."""
FILES = 128
"""Fewest files that a process should be able to open."""
SIGNS = "ΓΔΣ ≥ × ·"
"""What commands print beside ASCII."""


def tools() -> Iterator[Finding]:
    """What is used where it is there, and what its lack means."""
    for module, without in (
        ("embreex", "rays cannot be cast: nothing is perceived"),
        ("pysdd", "programs that enumeration cannot sum, and dsharp cannot compile, are refused"),
    ):
        there = find_spec(module) is not None
        yield Finding(TOOLS, module, "fine" if there else "wrong", "is there" if there else f"is missing: {without}")
    yield _dsharp()
    physics = find_spec("pybullet") is not None
    without = "is not there: no physics; pictures are drawn by rays, and nothing settles or is held"
    yield Finding(TOOLS, "pybullet", "fine" if physics else "note", "is there: physics" if physics else without)


def _dsharp() -> Finding:
    """The compiler that ProbLog brings."""
    problog = find_spec("problog")
    systems = {"Linux": "linux", "Darwin": "darwin", "Windows": "windows"}
    places = list(problog.submodule_search_locations or ()) if problog is not None else []
    brought = [Path(place) / "bin" / systems.get(platform.system(), "") / "dsharp" for place in places]
    found = next((place for place in brought if place.is_file()), None)
    there = str(found) if found is not None else shutil.which("dsharp")
    if there is None:
        return Finding(TOOLS, "dsharp", "note", "is not there: PySDD compiles in its place, which takes longer")
    if not os.access(there, os.X_OK):
        return Finding(TOOLS, "dsharp", "wrong", f"{there} cannot be run", f"chmod +x {there}")
    return Finding(TOOLS, "dsharp", "fine", "is there")


def limits() -> Iterator[Finding]:
    """Memory, files and room on disks."""
    yield _memory()
    space = resource.getrlimit(resource.RLIMIT_AS)[0]
    if space != resource.RLIM_INFINITY:
        few = "" if space >= SPACE else ": commands may end for want of memory"
        told = f"{size(space)} of address space for a command{few}"
        yield Finding(LIMITS, "address space", "note" if few else "fine", told, "ulimit -v unlimited" if few else "")
    files = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    few = f", fewer than {FILES}" if 0 <= files < FILES else ""
    many = "any number" if files == resource.RLIM_INFINITY else str(files)
    yield Finding(
        LIMITS, "open files", "wrong" if few else "fine", f"{many} at once{few}", f"ulimit -n {FILES}" if few else ""
    )
    largest = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    if largest != resource.RLIM_INFINITY:
        yield Finding(
            LIMITS, "file size", "note", f"files of at most {size(largest)} can be written", "ulimit -f unlimited"
        )
    yield _room()


def _memory() -> Finding:
    """What there is, and what a command may take of it."""
    told = f"{size(whole())}, {os.cpu_count()} processors"
    try:
        most = limit(os.environ)
    except InputError as error:
        return Finding(LIMITS, "memory", "wrong", f"{told}; {error}", f"unset {VARIABLE}")
    return Finding(LIMITS, "memory", "fine", f"{told}; a command may take {size(most) if most else 'any part of it'}")


def _room() -> Finding:
    """Whether scratch files can be written."""
    try:
        folder = temporary()
        with tempfile.TemporaryFile() as file:
            file.write(bytes(4096))
    except OSError as error:
        return Finding(
            LIMITS,
            "scratch",
            "wrong",
            f"no file can be written: {error.strerror or error}",
            "set TMPDIR to another folder",
        )
    free = shutil.disk_usage(folder).free
    few = f", fewer than the {size(FREE)} that are wanted" if free < FREE else ""
    remedy = f"make room in {folder}, or set TMPDIR to another folder" if few else ""
    return Finding(LIMITS, "scratch", "wrong" if few else "fine", f"{size(free)} free in {folder}{few}", remedy)


def console() -> Iterator[Finding]:
    """Whether what commands print can be shown."""
    encoding = getattr(sys.stdout, "charset", sys.stdout.encoding) or "none"
    try:
        SIGNS.encode(encoding)
    except (LookupError, UnicodeEncodeError):
        told = f"writes {encoding}, which lacks signs that are printed, as {SIGNS[0]}"
        yield Finding(
            CONSOLE, "encoding", "note", told.encode("ascii", "backslashreplace").decode(), "export LC_ALL=C.UTF-8"
        )
        return
    yield Finding(CONSOLE, "encoding", "fine", encoding)
