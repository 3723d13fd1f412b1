"""The camera of a picture: what was given for it, else what its EXIF tells; what is said of a guess.

* ``GivenCamera(file="camera.json")``, ``GivenCamera(fov=66.0)``, ``GivenCamera()``: nothing was given
* ``Shot``: a picture, its camera, and what people should know of that
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from geometry.errors import PlogicError
from geometry.files.plain_files import is_there
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from sensing.files.exif import Exif

CONTRADICTED = 4.0 / 3.0
"""Ratio of two focal lengths that says that one is of another lens.

Rounded millimetres (4 %), equivalents told by width instead of diagonal (4 to 9 %) and a cut for steady video (10 to
20 %) stay below; the lenses of one phone are a factor 1.5 and more apart."""
WAYS = "--camera FILE, or its field of view: --fov DEG across, or --fov-diagonal DEG (75 to 84 of most phones' main cameras)"


class NoCameraError(InputError):
    """Nothing tells a picture's camera."""


@dataclass(frozen=True, slots=True)
class GivenCamera:
    """What was given for the camera of pictures: one of these, or nothing.

    ``file``: any kind of ``geometry.files.camera_files``, ``FILE#NAME`` for one of many. ``fov``: degrees across the
    picture as it is stored; ``fov_diagonal``: from corner to corner; ``focal``: px.
    """

    file: str | None = None
    fov: float | None = None
    fov_diagonal: float | None = None
    focal: float | None = None

    def __post_init__(self) -> None:
        """Raise InputError where more than one is given."""
        if len(named := self.named) > 1:
            raise InputError(f"{' and '.join(named)}: each tells the camera: give one of them")

    @property
    def named(self) -> tuple[str, ...]:
        """The options that were given."""
        ways = {"--camera": self.file, "--fov": self.fov, "--fov-diagonal": self.fov_diagonal, "--focal": self.focal}
        return tuple(name for name, value in ways.items() if value is not None)

    def source(self) -> Path | None:
        """The file that the camera is read from; None where there is none. Raises CameraError."""
        from geometry.files.colmap_files import cameras_file

        return None if self.file is None else cameras_file(Path(part_of(self.file)[0]))

    def parts(self, photo: str) -> list[Path | str]:
        """All that the camera of a picture is made of: the file, ``#NAME`` of the one of many. Raises CameraError."""
        from geometry.files.colmap_files import taken_by

        source = self.source()
        if source is None or self.file is None:
            return []
        name = part_of(self.file)[1] or taken_by(source, photo)
        return [source, *([f"#{name}"] if name else [])]

    def of(self, size: tuple[int, int], source: str) -> "Camera | None":
        """The camera of a picture of ``size`` (width, height), read from ``source``; None where nothing was given.

        Raises CameraError; whether a file's camera is of that size is not looked at.
        """
        from geometry.camera import centred_camera
        from geometry.field_of_view import focal_across, focal_diagonal

        if self.file is not None:
            return read_given(self.file, size, source)
        if self.focal is not None:
            return centred_camera(size, self.focal)
        if self.fov is not None:
            return centred_camera(size, focal_across(size[0], self.fov))
        if self.fov_diagonal is not None:
            return centred_camera(size, focal_diagonal(size, self.fov_diagonal))
        return None


NOTHING_GIVEN = GivenCamera()


class Shot(NamedTuple):
    """``image`` (H, W, 3) uint8, blue first, and its camera.

    ``notes``: what is guessed or doubtful of the camera, a line each, to be said after the picture's name.
    """

    image: "NDArray[Any]"
    camera: "Camera"
    notes: tuple[str, ...] = ()


def read_given(file: str, size: tuple[int, int] | None = None, source: str | None = None) -> "Camera":
    """The camera of a file, ``FILE#NAME`` for one of many. Raises CameraError.

    ``size`` is of use where the file states none; ``source``, a picture, where it tells many by their pictures.
    """
    from geometry.files.camera_files import read_camera

    path, name = part_of(file)
    return read_camera(path, name, size=size, photo=source)


def part_of(file: str) -> tuple[str, str | None]:
    """The path and the name in ``PATH#NAME``; a file that is there whole has no such name."""
    path, _, name = file.rpartition("#")
    return (path, name) if path and name and not is_there(Path(file)) else (file, None)


def camera_beside(source: str, given: GivenCamera) -> GivenCamera:
    """What was given for the camera of a picture's file; where nothing was, ``camera.json`` beside it, if any."""
    beside = Path(source).parent / "camera.json"
    return given if given != NOTHING_GIVEN or source == "-" or not is_there(beside) else GivenCamera(str(beside))


def shot_of(source: str, given: GivenCamera, ways: str = WAYS) -> Shot:
    """The picture of a file, or of a pipe, with its camera: the given one, else that of ``camera_beside``.

    ``ways`` to give one, for the error that there is none.

    Raises InputError, ImageError or CameraError.
    """
    from geometry.files.plain_files import content_of
    from sensing.errors import ImageError
    from sensing.files.exif import exif_of
    from sensing.files.images import MAX_BYTES, image_from, size_of

    data = content_of(source, MAX_BYTES, ImageError)
    size, exif, used = size_of(data, source), exif_of(data), camera_beside(source, given)
    try:
        camera, notes = _camera_of(size, used, source, exif, ways)
    except PlogicError as error:
        if used is given:
            raise
        raise InputError(
            f"{error}; it lies beside the picture, and no camera was given: give one, or move it"
        ) from error
    beside = () if used is given else (f"its camera is {used.file}, which lies beside it",)
    return Shot(image_from(data, source), camera, (*beside, *notes))


def shot_with(image: "NDArray[Any]", given: GivenCamera, source: str, ways: str = WAYS) -> Shot:
    """A picture (H, W, 3) that was read from ``source`` and has no EXIF, with its camera.

    Raises NoCameraError where nothing was given, InputError where a file's is of another size; CameraError.
    """
    return Shot(image, *_camera_of((image.shape[1], image.shape[0]), given, source, None, ways))


def _camera_of(
    size: tuple[int, int], given: GivenCamera, source: str, exif: "Exif | None", ways: str
) -> "tuple[Camera, tuple[str, ...]]":
    """The camera of a picture of this size (width, height), and notes on it."""
    from sensing.files.exif import Exif

    camera = given.of(size, source)
    if camera is None and exif is None:
        raise NoCameraError(f"{source}: an image needs its camera: give {ways}")
    exif = exif or Exif()
    if camera is None:
        return _guessed(size, source, exif, ways)
    if given.file is not None:
        sized(camera, size, given.file, source)
        return camera, _contradicted(camera, exif, given)
    return camera, (*_turned(exif, size), *_contradicted(camera, exif, given))


def image_by(camera: "Camera", source: str, named: str) -> "NDArray[Any]":
    """The picture (H, W, 3) of a file, which must be of the camera's size; ``named`` is what errors call the camera.

    Raises InputError before anything is decoded, or ImageError.
    """
    from geometry.files.plain_files import content_of
    from sensing.errors import ImageError
    from sensing.files.images import MAX_BYTES, image_from, size_of

    data = content_of(source, MAX_BYTES, ImageError)
    sized(camera, size_of(data, source), named, source)
    return image_from(data, source)


def sized(camera: "Camera", size: tuple[int, int], named: str, source: str) -> "Camera":
    """The camera itself. Raises InputError where the picture, from ``source``, is of another size (width, height)."""
    if (camera.width, camera.height) != size:
        what = f"{named}: the camera is {camera.width}x{camera.height}, but {source} is {size[0]}x{size[1]}"
        raise InputError(f"{what}: {_resized(camera, size)}")
    return camera


def _resized(camera: "Camera", size: tuple[int, int]) -> str:
    """What to do about a picture of another size than its camera."""
    own, scale = (camera.width, camera.height), size[0] / camera.width
    if own == size[::-1]:
        return "it is turned by a quarter; turn it back, or give a camera of the turned picture"
    if abs(camera.height * scale - size[1]) > 1.0:
        return (
            "it is of another shape, so it was cut, or is another camera's; give the picture uncut, or its own camera"
        )
    (fx, _, cx), (_, fy, cy) = camera.K[:2].tolist()
    K = f"fx {fx * scale:.6g}, fy {fy * scale:.6g}, cx {(cx + 0.5) * scale - 0.5:.6g}, cy {(cy + 0.5) * scale - 0.5:.6g}"
    even = abs(fx - fy) < 0.01 * fx and abs(cx - (own[0] - 1) / 2) < 0.01 * own[0]
    even = even and abs(cy - (own[1] - 1) / 2) < 0.01 * own[1]
    rest = ", dist as it is" * bool(camera.dist.any()) or f", or --focal {(fx + fy) / 2 * scale:.6g}" * even
    return f"of the same shape; if it was scaled by {scale:.6g}, give its camera with {K}{rest}"


def _guessed(size: tuple[int, int], source: str, exif: "Exif", ways: str) -> "tuple[Camera, tuple[str, ...]]":
    """The camera that EXIF tells, and that it is a guess. Raises InputError where there is none."""
    from geometry.camera import centred_camera
    from sensing.files.exif import focal_guess, is_cut

    guess = focal_guess(exif, size)
    if guess is None:
        why = "its EXIF tells no focal length"
        if is_cut(exif, size) and exif.size is not None:
            why = f"its EXIF is of {exif.size[0]}x{exif.size[1]} and the picture of {size[0]}x{size[1]}, so it was cut"
        raise NoCameraError(f"{source}: an image needs its camera: give {ways}; {why}")
    said = f"camera guessed from EXIF: {guess.source}, focal {guess.f:.0f} px; no lens distortion known"
    return centred_camera(size, guess.f), (said, *_turned(exif, size))


def _turned(exif: "Exif", size: tuple[int, int]) -> tuple[str, ...]:
    """That a picture which viewers turn is taken as it is stored."""
    if exif.orientation == 1:
        return ()
    how = f"its orientation tag ({exif.orientation}) is not applied"
    return (f"{how}: pixels, and --fov across, are of the picture as it is stored, {size[0]}x{size[1]}",)


def _contradicted(camera: "Camera", exif: "Exif", given: GivenCamera) -> tuple[str, ...]:
    """That EXIF tells another lens than was given."""
    from sensing.files.exif import focal_guess

    guess = focal_guess(exif, (camera.width, camera.height))
    if guess is None or 1.0 / CONTRADICTED <= guess.f / camera.f <= CONTRADICTED:
        return ()
    ours = given.file or given.named[0]
    return (f"{ours} has a focal length of {camera.f:.0f} px, but EXIF tells {guess.f:.0f} px ({guess.source})",)
