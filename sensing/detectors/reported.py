"""What a detector reports, checked: a third party's mistake becomes one line that names the detector, never a traceback."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from sensing.appearance import Appearance
from sensing.errors import DetectorError, SensingError

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from sensing.detectors.detector import Detector


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
    if wrong is None and not (isinstance(a.type, str) and a.type and isinstance(a.detector, str) and a.detector):
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
    """An exception as one line of at most 200 letters."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}{': ' if text else ''}{text}"[:200]
