"""The protocol of a detector, the registry, and ``detect``: one image to Γ.

A detector looks at pixels and at nothing else. Others register theirs in code (``register``) or from another
distribution by an entry point of the group ``plogic.detectors`` whose object is a factory without arguments.
"""

from __future__ import annotations

from functools import partial
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from sensing.appearance import Appearance, Gamma
from sensing.detectors.reported import made, reported, told
from sensing.errors import DetectorError, ImageError
from sensing.rounding import rounded
from sensing.uncollected import uncollected

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from sensing.detectors.keypoint_detector import WordIndex

GROUP = "plogic.detectors"
"""The entry points' group."""


class Detector(Protocol):
    """What finds appearances of its ``types`` in pixels."""

    @property
    def name(self) -> str:
        """Unique among the detectors in use."""

    @property
    def types(self) -> tuple[str, ...]:
        """The appearance types that it can report."""

    def detect(self, image_bgr: NDArray[np.uint8]) -> list[Appearance]:
        """Appearances in an (H, W, 3) uint8 image, blue first; their ids are of no account. A constant image gives none."""


def _junctions() -> Detector:
    from sensing.detectors.junctions import JunctionDetector

    return JunctionDetector()


def _patches() -> Detector:
    from sensing.detectors.patches import PatchDetector

    return PatchDetector()


def _keypoints(name: Literal["sift", "orb"], words: WordIndex | None = None) -> Detector:
    from sensing.detectors.keypoint_detector import KeypointDetector

    return KeypointDetector(name, words)


def _markers(name: str) -> Detector:
    from sensing.detectors.markers import MarkerDetector

    return MarkerDetector(name)


def _colour_blobs() -> Detector:
    from sensing.detectors.colour_blobs import ColourBlobDetector

    return ColourBlobDetector()


_FACTORIES: dict[str, Callable[[], Detector]] = {
    "junction": _junctions,
    "patch": _patches,
    "sift": partial(_keypoints, "sift"),
    "orb": partial(_keypoints, "orb"),
    "colour_blob": _colour_blobs,
    **{name: partial(_markers, name) for name in ("aruco_4x4", "aruco_5x5", "aruco_6x6", "apriltag_36h11")},
}
_OF_KEYPOINTS: tuple[Literal["sift", "orb"], ...] = ("sift", "orb")


def register(name: str, factory: Callable[[], Detector]) -> None:
    """Make a detector known under ``name`` for the rest of the process.

    Raises:
        DetectorError: The name is taken.
    """
    if name in _FACTORIES:
        raise DetectorError(f"detector {name!r}: the name is taken")
    _FACTORIES[name] = factory


def unregister(name: str) -> None:
    """Forget the detector ``name``; raises DetectorError where there is none."""
    if _FACTORIES.pop(name, None) is None:
        raise DetectorError(f"detector {name!r}: there is none of this name")


def detectors(words: WordIndex | None = None) -> dict[str, Callable[[], Detector]]:
    """Every known detector's factory by name, in the order of names: the built-in, the registered, the installed.

    Args:
        words: The KB's visual words; the detector whose descriptors they hold then reports them as its types.

    Raises:
        DetectorError: An entry point does not load, or takes a name that is taken.
    """
    known = dict(_FACTORIES)
    known |= {name: partial(_keypoints, name, words) for name in _OF_KEYPOINTS if words is not None and name in known}
    for point in entry_points(group=GROUP):
        if point.name in known:
            raise DetectorError(f"detector {point.name!r} of {point.value}: the name is taken")
        try:
            known[point.name] = point.load()
        except Exception as error:
            raise DetectorError(f"detector {point.name!r} of {point.value} does not load: {told(error)}") from error
    return dict(sorted(known.items()))


def detect(
    image_bgr: NDArray[np.uint8], camera: Camera, vocabulary: Collection[str], words: WordIndex | None = None
) -> Gamma:
    """Γ of one image by every known detector that can report a type of ``vocabulary``; other types are left out.

    Ids are ``a1``, ``a2``, ... by detector, then v, then u: the same pixels give the same Γ. Places are rounded to 1e-4
    px, angles to 1e-5. With ``words``, the keypoint detector whose descriptors they hold names its appearances by them.
    A detector none of whose types is in the vocabulary is not run.

    Raises:
        ImageError: The image is not (H, W, 3) uint8 or has another size than the camera's.
        DetectorError: A detector does not load, fails, or reports what cannot be (outside the image, not finite).
    """
    _check(image_bgr, camera)
    wanted = frozenset(vocabulary)
    with uncollected():
        known = {name: made(name, factory) for name, factory in detectors(words).items()}
        found = [
            a
            for name, d in known.items()
            if not wanted.isdisjoint(d.types)
            for a in reported(name, d, image_bgr)
            if a.type in wanted
        ]
        return Gamma(camera, _named(found))


def _check(image_bgr: NDArray[np.uint8], camera: Camera) -> None:
    if image_bgr.ndim != 3 or image_bgr.shape[2] != 3 or image_bgr.dtype.name != "uint8":
        raise ImageError(f"image: shape {image_bgr.shape} of {image_bgr.dtype} is not (H, W, 3) uint8")
    height, width = image_bgr.shape[:2]
    if (width, height) != (camera.width, camera.height):
        raise ImageError(f"image: {width}x{height} is not the camera's size, {camera.width}x{camera.height}")


def _named(found: Sequence[Appearance]) -> tuple[Appearance, ...]:
    """The appearances rounded, in their order, with their ids; there are thousands, so they are rounded by columns."""
    u, v = rounded(np.array([a.uv for a in found], float).reshape(-1, 2), 4).T
    angle, scale, score = (
        _column([getattr(a, name) for a in found], digits)
        for name, digits in (("angle", 5), ("scale", 3), ("score", 4))
    )
    detector, kind = (_places([getattr(a, name) for a in found]) for name in ("detector", "type"))
    order = np.lexsort((np.nan_to_num(scale), np.nan_to_num(angle), kind, u, v, detector))
    places = zip(u[order].tolist(), v[order].tolist(), strict=True)
    rows = zip(order.tolist(), places, *(_cells(column[order]) for column in (angle, scale, score)), strict=True)
    return tuple(_renamed(found[i], f"a{number}", uv, *rest) for number, (i, uv, *rest) in enumerate(rows, start=1))


def _column(values: Sequence[float | None], digits: int) -> NDArray[np.float64]:
    """(N,) the values rounded; NaN for None."""
    return rounded(np.array(values, float), digits)


def _cells(column: NDArray[np.float64]) -> list[float | None]:
    return [None if x != x else x for x in column.tolist()]  # noqa: PLR0124 - NaN


def _places(names: Sequence[str]) -> NDArray[np.intp]:
    """(N,) the place of each name among the different ones in alphabetical order."""
    place = {name: i for i, name in enumerate(sorted(set(names)))}
    return np.array([place[name] for name in names], np.intp)


def _renamed(
    a: Appearance, name: str, uv: tuple[float, float], angle: float | None, scale: float | None, score: float | None
) -> Appearance:
    arms = tuple(round(x, 5) for x in a.arms) if a.arms else ()
    return Appearance(name, a.type, uv, a.detector, angle, scale, score, arms, a.descriptor)
