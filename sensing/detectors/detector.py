"""The protocol of a detector, the registry, and ``detect``: one image to Γ.

A detector looks at pixels and at nothing else. Others register theirs in code (``register``) or from another
distribution by an entry point of the group ``plogic.detectors`` whose object is a factory without arguments.

What it reports is checked: a third party's mistake becomes one line that names the detector, never a traceback.
"""

from collections.abc import Callable, Collection, Sequence
from functools import partial
from importlib.metadata import entry_points
from math import isfinite
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from sensing.appearance import Appearance, Gamma
from sensing.detectors.keypoint_detector import WordIndex
from sensing.errors import DetectorError, ImageError, SensingError
from sensing.uncollected import uncollected

_DOUBTFUL = 1e-6
"""Nearer than this to the middle between two neighbours, in units of the last decimal, a product's own rounding could
decide."""
_LARGEST = 2.0**31
"""Up to here, in those units, a product is exact to less than that."""


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
        """Appearances in an (H, W, 3) uint8 image, blue first; their ids are of no account.

        A constant image gives none.
        """


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
        rounded(np.array([getattr(a, name) for a in found], float), digits)  # NaN for None
        for name, digits in (("angle", 5), ("scale", 3), ("score", 4))
    )
    detector, kind = (_places([getattr(a, name) for a in found]) for name in ("detector", "type"))
    order = np.lexsort((np.nan_to_num(scale), np.nan_to_num(angle), kind, u, v, detector))
    places = zip(u[order].tolist(), v[order].tolist(), strict=True)
    columns = [[x if x == x else None for x in column[order].tolist()] for column in (angle, scale, score)]  # noqa: PLR0124 - NaN
    rows = zip(order.tolist(), places, *columns, strict=True)
    return tuple(_renamed(found[i], f"a{number}", uv, *rest) for number, (i, uv, *rest) in enumerate(rows, start=1))


def _places(names: Sequence[str]) -> NDArray[np.intp]:
    """(N,) the place of each name among the different ones in alphabetical order."""
    place = {name: i for i, name in enumerate(sorted(set(names)))}
    return np.array([place[name] for name in names], np.intp)


def _renamed(
    a: Appearance, name: str, uv: tuple[float, float], angle: float | None, scale: float | None, score: float | None
) -> Appearance:
    arms = tuple(round(x, 5) for x in a.arms) if a.arms else ()
    return Appearance(name, a.type, uv, a.detector, angle, scale, score, arms, a.descriptor)


def rounded(values: NDArray[np.float64], digits: int) -> NDArray[np.float64]:
    """Each of ``values`` (...) as ``round(value, digits)``, for digits from 0 to 15; NaN and infinities stay."""
    unit = 10.0**digits
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = values * unit
        result = np.asarray(np.rint(scaled) / unit)
        sure = (np.abs(scaled) < _LARGEST) & (np.abs(scaled - np.floor(scaled) - 0.5) > _DOUBTFUL)
    doubtful = ~sure & np.isfinite(values)
    result[doubtful] = [round(value, digits) for value in values[doubtful].tolist()]
    return np.where(np.isfinite(values), result, values)


def made(name: str, factory: Callable[[], Detector]) -> Detector:
    """The detector that ``factory`` makes; raises DetectorError where it fails or makes something else."""
    try:
        detector = factory()
        types = detector.types
    except SensingError:
        raise
    except Exception as error:
        raise DetectorError(f"detector {name!r}: cannot be made: {told(error)}") from error
    if isinstance(types, str) or not all(isinstance(t, str) for t in types):
        raise DetectorError(f"detector {name!r}: its types are no tuple of names: {types!r:.80}")
    return detector


def reported(name: str, detector: Detector, image_bgr: NDArray[np.uint8]) -> list[Appearance]:
    """What ``detector`` sees in an (H, W, 3) image.

    Raises:
        DetectorError: It raised, or reported something that is no appearance, outside the image, or not finite.
    """
    try:
        found = list(detector.detect(image_bgr))
    except SensingError:
        raise
    except Exception as error:
        raise DetectorError(f"detector {name!r}: failed on the image: {told(error)}") from error
    height, width = image_bgr.shape[:2]
    for i, a in enumerate(found):
        wrong = mistake(a, width, height)
        if wrong is not None:
            raise DetectorError(f"detector {name!r}: appearance {i} of {len(found)}: {wrong}")
    return found


def mistake(a: object, width: int, height: int) -> str | None:
    """What is wrong with one reported appearance of an image of this size; None where nothing is."""
    if not isinstance(a, Appearance):
        return f"is no Appearance but a {type(a).__name__}"
    wrong = _number_mistake(a, width, height)
    named = a.detector is None or (isinstance(a.detector, str) and a.detector)
    if wrong is None and not (isinstance(a.type, str) and a.type and named):
        wrong = f"its type {a.type!r:.40} or its detector {a.detector!r:.40} is no name"
    if wrong is None and not isinstance(a.descriptor, bytes | None):
        wrong = f"descriptor is no bytes but a {type(a.descriptor).__name__}"
    return wrong


def _number_mistake(a: Appearance, width: int, height: int) -> str | None:
    try:
        u, v = a.uv
        whole = (
            isfinite(u) and isfinite(v) and isfinite(a.angle or 0) and isfinite(a.scale or 0) and isfinite(a.score or 0)
        )
        whole = whole and all(map(isfinite, a.arms))
        inside = -0.5 <= u <= width - 0.5 and -0.5 <= v <= height - 0.5
    except (TypeError, ValueError) as error:
        return f"has numbers that are none: {told(error)}"
    if not whole:
        return f"has a number that is not finite: uv {a.uv}, angle {a.angle}, scale {a.scale}, score {a.score}"
    if a.scale is not None and a.scale <= 0:
        return f"scale {a.scale} is not above 0"
    return None if inside else f"uv {a.uv} is outside the image of {width}x{height}"


def told(error: BaseException) -> str:
    """An exception as one line of at most 200 letters. Raises it where it is a MemoryError, which is no detector's."""
    if isinstance(error, MemoryError):
        raise error
    text = " ".join(str(error).split())
    return f"{type(error).__name__}{': ' if text else ''}{text}"[:200]
