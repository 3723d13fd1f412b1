"""Files of arrays (``.npz``) from anywhere: read whole within a limit, nothing in them run, every fault a CloudError."""

from __future__ import annotations

import io
import zipfile
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from kb.errors import CloudError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

_PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_FAULTS = (
    zipfile.BadZipFile,
    zlib.error,
    LookupError,
    ValueError,
    TypeError,
    EOFError,
    OSError,
    RuntimeError,
    MemoryError,
    OverflowError,
)


def read_arrays(
    content: bytes, names: Iterable[str], most: int, optional: Iterable[str] = ()
) -> dict[str, NDArray[Any]]:
    """The arrays of these names, and those of ``optional`` that are there.

    Raises CloudError where one is missing or no plain array, or all unpack to more than ``most`` bytes.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if sum(item.file_size for item in archive.infolist()) > most:
                raise CloudError(f"unpacks to more than {most} bytes")
            there = set(archive.namelist())
            return {
                name: _array(archive, f"{name}.npy")
                for name in (*names, *(name for name in optional if f"{name}.npy" in there))
            }
    except _FAULTS as error:
        raise CloudError(str(error).splitlines()[0] if str(error) else type(error).__name__) from None


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    if archive.getinfo(name).compress_type not in _PACKINGS:
        raise ValueError(f"{name} is packed in an unusual way")
    content = archive.read(name)
    stream = io.BytesIO(content)
    version = np.lib.format.read_magic(stream)
    if version not in {(1, 0), (2, 0)}:
        raise ValueError(f"{name} is of a version that nobody needs")
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(stream)
    count = 1
    for length in shape:
        count *= length
    longest = max(len(content), 4096)  # what is empty may be wide
    if (
        dtype.hasobject
        or any(not 0 <= length <= longest for length in shape)
        or count * dtype.itemsize != len(content) - stream.tell()
    ):
        raise ValueError(f"{name} does not hold the numbers that it says")
    return np.asarray(np.lib.format.read_array(io.BytesIO(content), allow_pickle=False))
