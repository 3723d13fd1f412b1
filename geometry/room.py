"""Is there room for so much memory, or for so many threads? Asked before a library takes them that ends the process.

Where memory is short, LLVM and OpenCV abort, and OpenBLAS ends the process or looks for memory for ever.
"""

import mmap
import sys
import threading
from importlib.machinery import ModuleSpec

MB = 1 << 20
NEEDS = {"numpy": (54, 104), "cv2": (16, 214), "scipy.linalg": (78, 159), "numba": (29, 231)}
"""MB of memory and of address space that are wanted before one of these is loaded.

A quarter more than they take, scipy.linalg with scipy.optimize (``tests/geometry/test_room.py`` measures it).
"""


def check_room(memory: int, reserved: int = 0) -> None:
    """Raise MemoryError where there are not so many bytes of memory, or ``reserved`` bytes of address space."""
    try:
        mmap.mmap(-1, memory, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS).close()
        if reserved > memory:
            mmap.mmap(-1, reserved, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, mmap.PROT_READ).close()
    except OSError as error:
        raise MemoryError from error


def check_threads(count: int) -> None:
    """Raise RuntimeError where not so many threads can be started, before a library that would end the process does."""
    done = threading.Event()
    started: list[threading.Thread] = []
    try:
        for _ in range(count):
            thread = threading.Thread(target=done.wait)
            thread.start()
            started.append(thread)
    finally:
        done.set()
        for thread in started:
            thread.join()


class _Looks:
    """Finds nothing: it looks whether there is room for a library that is about to be loaded."""

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:  # noqa: ARG002
        """Raise MemoryError where there is none."""
        if fullname in NEEDS:
            check_room(*(MB * need for need in NEEDS[fullname]))
        return None


def look_before_loading() -> None:
    """From now on, a library that takes much is not loaded where there is no room for it: a MemoryError."""
    if not any(isinstance(finder, _Looks) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Looks())
