"""From what a user names to Γ: its file, or an image and its camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.base.stopwatch import Stopwatch
    from sensing.appearance import Gamma


def is_gamma(source: str) -> bool:
    """Whether an INPUT names a Γ and no image: JSON, or stdin."""
    return source == "-" or source.lower().endswith(".json")


def image_of(source: str, camera: str | None) -> NDArray[Any]:
    """The picture (H, W, 3), BGR; without a camera file it has no geometry. Raises InputError or ImageError."""
    from sensing.files.images import read_image

    if camera is None:
        raise InputError(f"{source}: an image needs its camera: give --camera FILE (ours, ROS, OpenCV, BOP or COLMAP)")
    return read_image(source)


def gamma_of(
    source: str, picture: NDArray[Any] | None, camera_file: str | None, kb: KnowledgeBase, clock: Stopwatch
) -> tuple[Gamma, NDArray[Any] | None]:
    """Γ from its file, or detected in the picture; types that the KB does not know are mistakes of a file."""
    from sensing.files.gamma_files import read_gamma

    if picture is None:
        return read_gamma(source, kb.appearance_types), None
    from geometry.files.camera_files import read_camera

    camera = read_camera(str(camera_file))
    height, width = picture.shape[:2]
    if (camera.width, camera.height) != (width, height):
        raise InputError(
            f"{camera_file}: the camera is {camera.width}x{camera.height}, but {source} is {width}x{height}"
        )
    return detected(picture, camera, kb, clock), picture


def detected(picture: NDArray[Any], camera: Camera, kb: KnowledgeBase, clock: Stopwatch) -> Gamma:
    """Γ of a picture (H, W, 3), BGR, by all detectors that report a type of the KB. Raises InputError where none does."""
    from sensing.detectors.detector import detect

    if not detectable(kb):
        raise InputError(
            f"{kb.name}: no detector reports any of its appearance types ({', '.join(kb.appearance_types)}): give a Γ file instead"
        )
    with clock.stage("detect"):
        return detect(picture, camera, kb.sought, kb.words)


def detectable(kb: KnowledgeBase) -> bool:
    """Whether some registered detector reports a type of the KB's vocabulary."""
    from sensing.detectors.detector import detectors

    return any(set(make().types) & set(kb.appearance_types) for make in detectors(kb.words).values())
