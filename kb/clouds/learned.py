"""Learned clouds: features that a keypoint detector was measured to see, as arrays, and their file ``cloud.npz``.

* ``LearnedCloud``: F features and the L appearances of them, each with its lobe: from where it is seen, how often, and
  how it looks there.
  One appearance fixes a whole pose: its lobe gives the direction of view, its ``up`` the roll, its ``size`` the
      distance.
"""

import io
import tokenize
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Ints, Mask
from kb.errors import CloudError

MAX_BYTES = 100_000_000
"""Largest ``cloud.npz``, packed and unpacked."""
MAX_LOBES = 200_000
"""Most appearances of one type."""
_SHAPES: dict[str, tuple[str, tuple[int, ...], str]] = {
    "at": ("F", (3,), "f"), "sigma": ("F", (), "f"), "normal": ("F", (3,), "f"), "word": ("F", (), "i"),
    "feature": ("L", (), "i"), "lobe_word": ("L", (), "i"), "descriptor": ("L", (-1,), "u"), "axis": ("L", (3,), "f"),
    "half_angle": ("L", (), "f"), "r_min": ("L", (), "f"), "r_max": ("L", (), "f"), "hit": ("L", (), "f"), "up": ("L", (3,), "f"),
    "size": ("L", (), "f"),
}  # fmt: skip
_OPTIONAL: dict[str, tuple[str, tuple[int, ...], str]] = {"part": ("F", (), "i"), "compound": ("F", (), "i")}
"""What files of types without parts, or without compounds, do not have."""
WORDS = 32
"""Bytes of ``kb.clouds.words.Words.digest``; files that were written before there was one have none."""
FORMAT = 2
"""Of files with compounds, which say so; those without, as all were once, say nothing."""
_KINDS = {"f": np.float64, "i": np.int64, "u": np.uint8}


@dataclass(frozen=True, eq=False)
class LearnedCloud:
    """All in metres, radians and the object's frame.

    Attributes:
        at: (F, 3) places of the features. sigma: (F,) standard deviation of a place along one axis. normal: (F, 3) unit
        outward normal of the surface there. word: (F,) index of the feature's dominant visual word. feature: (L,) whose
        appearance it is; in order. lobe_word: (L,) index of the appearance's visual word. descriptor: (L, D) uint8, 128
        of SIFT, or 138 with its colours, or 32 of ORB: its mean over the views of the lobe. axis: (L, 3) unit axis of
        the lobe, from the feature to the viewpoint. half_angle: (L,) of the lobe. r_min: (L,) least distance at the
        reference focal length. r_max: (L,) greatest. hit: (L,) how often the detector reported it within the lobe,
        measured. up: (L, 3) unit, perpendicular to the axis: what the keypoint's angle is on the screen, as a direction
        in space. size: (L,) the keypoint's diameter in space; 0 of the side of an edge
        (``sensing.detectors.keypoint_detector``), whose ``up`` is across the edge towards
            the side, and of whose descriptor bytes 128 to 132 are its looks, and 133 how much the last of them varied.
        part: (F,) which object of its type's tree the feature belongs to (``kb.clouds.lobes.object_nodes``); 0, the
        whole, where there are no parts. compound: (F,) which compound feature it is a part of (A1;
        ``kb.learning.compounds``), counted from 1; 0 of those that are in none. words: (32,) the digest of the words
        that ``word`` and ``lobe_word`` are of; (0,) where nobody knows.
    """

    at: Floats
    sigma: Floats
    normal: Floats
    word: Ints
    feature: Ints
    lobe_word: Ints
    descriptor: Bytes
    axis: Floats
    half_angle: Floats
    r_min: Floats
    r_max: Floats
    hit: Floats
    up: Floats
    size: Floats
    part: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    compound: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    words: Bytes = field(default_factory=lambda: np.zeros(0, np.uint8))

    def __post_init__(self) -> None:
        counts = {"F": len(self.at), "L": len(self.feature)}
        for name in _OPTIONAL:
            if not len(getattr(self, name)):
                object.__setattr__(self, name, np.zeros(counts["F"], np.int64))
        for name, (rows, shape, kind) in (_SHAPES | _OPTIONAL).items():
            array = np.array(getattr(self, name), dtype=_KINDS[kind])
            if array.size or -1 not in shape:
                array = array.reshape(counts[rows], *shape)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @cached_property
    def sided(self) -> Mask:
        """(L,) which are sides of edges."""
        return np.asarray(self.size == 0.0)

    @property
    def keypoints(self) -> "LearnedCloud":
        """The same without the sides of edges."""
        lobes = np.flatnonzero(~self.sided)
        used, feature = np.unique(self.feature[lobes], return_inverse=True)
        features = {
            name: getattr(self, name)[used] for name, (rows, _, _) in (_SHAPES | _OPTIONAL).items() if rows == "F"
        }
        appearances = {name: getattr(self, name)[lobes] for name, (rows, _, _) in _SHAPES.items() if rows == "L"}
        return LearnedCloud(**features | appearances | {"feature": feature, "compound": numbered(features["compound"])})

    @property
    def compounds(self) -> int:
        """How many compound features there are."""
        return int(self.compound.max(initial=0))

    @property
    def detector(self) -> str:
        """Whose descriptors these are."""
        return "orb" if self.descriptor.shape[1] == 32 else "sift"


def numbered(groups: Ints) -> Ints:
    """(F,) the groups of F features counted from 1 in the order of their first members.

    0 of those whose group, or 0, has no other.
    """
    _, first, which, size = np.unique(groups, return_index=True, return_inverse=True, return_counts=True)
    real = (size > 1) & (groups[first] > 0)
    place = np.zeros(len(first), np.int64)
    place[np.flatnonzero(real)[np.argsort(first[real])]] = np.arange(1, real.sum() + 1)
    return np.asarray(place[which.ravel()], np.int64)


def cloud_bytes(cloud: LearnedCloud) -> bytes:
    """The file's contents, the same for the same cloud.

    Floats are kept in single precision, indices in 32 bits; no parts, no array of them.
    """
    memory = io.BytesIO()
    arrays = {
        name: getattr(cloud, name) for name in (*_SHAPES, *(name for name in _OPTIONAL if getattr(cloud, name).any()))
    }
    if cloud.words.size:
        arrays["words"] = cloud.words
    if cloud.compounds:
        arrays["format"] = np.array(FORMAT)
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            packed = io.BytesIO()
            np.save(packed, array.astype({"f": "<f4", "i": "<i4", "u": "u1"}[array.dtype.kind]), allow_pickle=False)
            archive.writestr(
                zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)), packed.getvalue(), zipfile.ZIP_DEFLATED
            )
    return memory.getvalue()


def read_cloud(content: bytes) -> LearnedCloud:
    """The cloud of a file; nothing in it is run.

    Raises:
        CloudError: It is not a learned cloud, or a number in it cannot be.
    """
    try:
        arrays = read_arrays(content, _SHAPES, MAX_BYTES, (*_OPTIONAL, "format", "words"))
    except CloudError as error:
        raise CloudError(f"is no learned cloud: {error}") from None
    _check_format(arrays.pop("format", np.array(1)))
    words = arrays.pop("words", np.zeros(0, np.uint8))
    if words.dtype != np.uint8 or words.shape not in {(0,), (WORDS,)}:
        raise CloudError(f"words: has shape {words.shape} of {words.dtype}, not ({WORDS},) of uint8")
    _check(arrays)
    return LearnedCloud(**arrays, words=words)


def _check_format(stated: NDArray[Any]) -> None:
    if stated.shape or stated.dtype.kind != "i" or stated < 1:
        raise CloudError(f"format: has shape {stated.shape} of {stated.dtype}, not a number from 1")
    if stated > FORMAT:
        raise CloudError(f"is of format {int(stated)}, of a newer plogic: this one reads up to {FORMAT}")


def _check(arrays: dict[str, NDArray[Any]]) -> None:
    counts = {"F": len(np.atleast_1d(arrays["at"])), "L": len(np.atleast_1d(arrays["feature"]))}
    if counts["L"] > MAX_LOBES:
        raise CloudError(f"has {counts['L']} appearances; {MAX_LOBES} are the most")
    for name, (rows, shape, kind) in (
        _SHAPES | {name: _OPTIONAL[name] for name in _OPTIONAL if name in arrays}
    ).items():
        array = arrays[name]
        right = (
            array.ndim == 1 + len(shape)
            and array.shape[0] == counts[rows]
            and (not shape or shape[0] in (-1, array.shape[1]))
        )
        if not right or array.dtype.kind != kind or (kind == "u" and array.dtype != np.uint8):
            raise CloudError(f"{name}: has shape {array.shape} of {array.dtype}")
        if kind == "f" and not np.isfinite(array.astype(np.float64)).all():
            raise CloudError(f"{name}: has a number that is not finite")
    _check_indices(arrays, counts["F"])
    _check_numbers(
        {name: np.asarray(arrays[name], np.float64) for name, (_, _, kind) in _SHAPES.items() if kind == "f"}
    )
    if arrays["descriptor"].shape[1] not in (32, 128, 138):
        raise CloudError(f"descriptor: has {arrays['descriptor'].shape[1]} bytes, not 128 or 138 (SIFT) or 32 (ORB)")


def _check_indices(arrays: dict[str, NDArray[Any]], features: int) -> None:
    feature = np.asarray(arrays["feature"], np.int64)
    if len(feature) and not (feature.min() >= 0 and feature.max() < features and (np.diff(feature) >= 0).all()):
        raise CloudError(f"feature: must be in order and below {features}")
    for name in ("word", "lobe_word", *(name for name in _OPTIONAL if name in arrays)):
        if np.asarray(arrays[name], np.int64).min(initial=0) < 0:
            raise CloudError(f"{name}: must not be below 0")
    _check_compounds(*(np.asarray(arrays.get(name, np.zeros(features)), np.int64) for name in _OPTIONAL))


def _check_compounds(part: Ints, compound: Ints) -> None:
    if not np.array_equal(numbered(compound), compound):
        raise CloudError("compound: must be counted from 1 in order, each of two features or more")
    owners = np.unique(np.column_stack([compound, part])[compound > 0], axis=0)
    if len(owners) > compound.max(initial=0):
        raise CloudError("compound: must be of one part of the type each")


def _check_numbers(arrays: dict[str, Floats]) -> None:
    for name in ("axis", "up", "normal"):
        if np.abs(np.linalg.norm(arrays[name], axis=1) - 1.0).max(initial=0.0) > 1e-3:
            raise CloudError(f"{name}: must be of length 1")
    if np.abs((arrays["axis"] * arrays["up"]).sum(axis=1)).max(initial=0.0) > 1e-3:
        raise CloudError("up: must be perpendicular to axis")
    if arrays["size"].min(initial=0.0) < 0.0:
        raise CloudError("size: must be at least 0")
    for name in ("half_angle", "r_max", "sigma"):
        if arrays[name].min(initial=1.0) <= 0.0:
            raise CloudError(f"{name}: must be above 0")
    if arrays["hit"].min(initial=0.0) < 0.0 or arrays["hit"].max(initial=0.0) > 1.0:
        raise CloudError("hit: must be in [0, 1]")
    if arrays["r_min"].min(initial=0.0) < 0.0 or (arrays["r_min"] > arrays["r_max"]).any():
        raise CloudError("r_min: must be at least 0 and at most r_max")


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
    tokenize.TokenError,  # numpy, of the head of an array, which it reads as Python
    SyntaxError,
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
    shape, by_columns, dtype = read(stream)
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
    numbers = np.frombuffer(content, dtype, count, stream.tell()).copy()
    return numbers.reshape(shape, order="F" if by_columns else "C")
