"""The protocol of a detector, the registry, and ``detect``: one image to Γ.

A detector looks at pixels and at nothing else. Others register theirs in code (``register``) or from another distribution by an entry
point of the group ``plogic.detectors`` whose object is a factory without arguments.
"""

from __future__ import annotations

from functools import partial
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Literal, Protocol

from sensing.appearance import Appearance, Gamma
from sensing.errors import DetectorError, ImageError
from sensing.reported import made, reported, told

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    import numpy as np
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from sensing.keypoint_detector import WordIndex

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
    from sensing.junctions import JunctionDetector

    return JunctionDetector()


def _patches() -> Detector:
    from sensing.patches import PatchDetector

    return PatchDetector()


def _keypoints(name: Literal["sift", "orb"], words: WordIndex | None = None) -> Detector:
    from sensing.keypoint_detector import KeypointDetector

    return KeypointDetector(name, words)


def _markers(name: str) -> Detector:
    from sensing.markers import MarkerDetector

    return MarkerDetector(name)


def _colour_blobs() -> Detector:
    from sensing.colour_blobs import ColourBlobDetector

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


def detect(image_bgr: NDArray[np.uint8], camera: Camera, vocabulary: Collection[str], words: WordIndex | None = None) -> Gamma:
    """Γ of one image by every known detector that can report a type of ``vocabulary``; other types are left out.

    Ids are ``a1``, ``a2``, ... by detector, then v, then u: the same pixels give the same Γ. Places are rounded to 1e-4 px, angles to 1e-5.
    With ``words``, the keypoint detector whose descriptors they hold names its appearances by them. A detector none of whose types is in
    the vocabulary is not run.

    Raises:
        ImageError: The image is not (H, W, 3) uint8 or has another size than the camera's.
        DetectorError: A detector does not load, fails, or reports what cannot be (outside the image, not finite).
    """
    _check(image_bgr, camera)
    wanted = frozenset(vocabulary)
    known = {name: made(name, factory) for name, factory in detectors(words).items()}
    found = [a for name, d in known.items() if not wanted.isdisjoint(d.types) for a in reported(name, d, image_bgr) if a.type in wanted]
    places = [(round(a.uv[0], 4), round(a.uv[1], 4), _cut(a.angle, 5), _cut(a.scale, 3)) for a in found]
    order = sorted(range(len(found)), key=lambda i: _order(found[i], places[i]))
    return Gamma(camera, tuple(_named(f"a{number}", found[i], places[i]) for number, i in enumerate(order, start=1)))


def _check(image_bgr: NDArray[np.uint8], camera: Camera) -> None:
    if image_bgr.ndim != 3 or image_bgr.shape[2] != 3 or image_bgr.dtype.name != "uint8":
        raise ImageError(f"image: shape {image_bgr.shape} of {image_bgr.dtype} is not (H, W, 3) uint8")
    height, width = image_bgr.shape[:2]
    if (width, height) != (camera.width, camera.height):
        raise ImageError(f"image: {width}x{height} is not the camera's size, {camera.width}x{camera.height}")


def _cut(x: float | None, digits: int) -> float | None:
    return None if x is None else round(x, digits)


def _order(a: Appearance, place: tuple[float, float, float | None, float | None]) -> tuple[str, float, float, str, float, float]:
    u, v, angle, scale = place
    return a.detector, v, u, a.type, angle or 0.0, scale or 0.0


def _named(name: str, a: Appearance, place: tuple[float, float, float | None, float | None]) -> Appearance:
    """The appearance with its id, rounded; there are thousands, and ``replace`` is slow."""
    u, v, angle, scale = place
    return Appearance(name, a.type, (u, v), a.detector, angle, scale, _cut(a.score, 4), tuple(round(x, 5) for x in a.arms), a.descriptor)
