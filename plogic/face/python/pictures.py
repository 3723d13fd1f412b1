"""Cameras, images and Γ as a user of Python gives them."""

import warnings
from collections.abc import Sequence
from math import hypot
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry import camera as geometry_camera
from geometry.errors import CameraError
from geometry.field_of_view import focal_across
from geometry.files.camera_files import read_camera
from plogic.base.errors import InputError
from plogic.face.session.blocks import Block, Column, Rows, Table
from plogic.run.cameras import GivenCamera, Shot, image_by, shot_of, shot_with, sized
from sensing import appearance as sensing_appearance
from sensing.appearance import Appearance
from sensing.errors import ImageError

Image = str | Path | np.ndarray[tuple[int, ...], np.dtype[np.uint8]]
"""An image: its file, or its pixels (H, W, 3) uint8, blue first."""


class Camera(geometry_camera.Camera):
    """A pinhole camera with OpenCV's lens distortion: x right, y down, z forward.

    An integer pixel is a pixel's centre.
    """

    def __init__(
        self,
        width: int,
        height: int,
        K: ArrayLike,
        dist: ArrayLike = (),
        T_world_camera: ArrayLike | None = None,
    ) -> None:
        """Take the size in pixels, ``K`` (3, 3), ``dist`` (0, 4, 5, 8, 12 or 14), and the pose (4, 4) in the world, m.

        Raises:
            Error: telling everything that is wrong with the numbers.
        """
        super().__init__(width, height, K, dist, T_world_camera)  # type: ignore[arg-type]  # its checks make arrays of them

    @classmethod
    def load(
        cls,
        path: str | Path,
        frame: str | int | None = None,
        *,
        size: tuple[int, int] | None = None,
        photo: str | Path | None = None,
    ) -> Self:
        """Read a camera from a file of ours, ROS, OpenCV, BOP or COLMAP, or from a COLMAP folder.

        Args:
            path: the file, or the folder.
            frame: which camera, where there are many.
            size: (width, height) in pixels, where the file states none.
            photo: the picture whose camera it is, where BOP or COLMAP tell many by their pictures.

        Raises:
            Error: with the file, the key or the line, and what is wrong.
        """
        return cls.of(read_camera(path, frame, size=size, photo=photo))

    @classmethod
    def of(cls, camera: geometry_camera.Camera) -> Self:
        """Return the same camera as one of this class."""
        return cls(camera.width, camera.height, camera.K, camera.dist, camera.world_from_camera)

    @classmethod
    def from_fov(
        cls,
        width: int,
        height: int,
        *,
        horizontal: float | None = None,
        vertical: float | None = None,
        diagonal: float | None = None,
    ) -> Self:
        """Return an ideal camera with square pixels and one field of view, degrees, through the image's middle.

        Raises:
            Error: unless exactly one field of view is given, between 0 and 180 degrees.
        """
        sides = (horizontal, width), (vertical, height), (diagonal, hypot(width, height))
        given = [(angle, side) for angle, side in sides if angle is not None]
        if len(given) != 1:
            raise CameraError("from_fov: give one of horizontal, vertical and diagonal, in degrees")
        ((angle, side),) = given
        if not 0.0 < angle < 180.0:
            raise CameraError(f"from_fov: a field of view must be between 0 and 180 degrees, not {angle:g}")
        return cls.of(geometry_camera.centred_camera((width, height), focal_across(side, angle)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, geometry_camera.Camera):
            return NotImplemented
        return _values(self) == _values(other)

    def __hash__(self) -> int:
        return hash((self.width, self.height, self.K.tobytes()))


def _values(camera: geometry_camera.Camera) -> tuple[object, ...]:
    pose = None if camera.world_from_camera is None else camera.world_from_camera.tolist()
    return camera.width, camera.height, camera.K.tolist(), camera.dist.tolist(), pose


class Gamma(sensing_appearance.Gamma, Rows[Appearance]):
    """The data of one view: a camera, and what detectors reported. A table with a row each appearance."""

    def __init__(self, camera: geometry_camera.Camera, appearances: Sequence[Appearance] = ()) -> None:
        super().__init__(Camera.of(camera), tuple(appearances))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a ``gamma/1`` file. Raises Error with every mistake of the file."""
        from sensing.files.gamma_files import read_gamma

        return cls.of(read_gamma(path))

    @classmethod
    def of(cls, gamma: sensing_appearance.Gamma) -> Self:
        """Return the same Γ as one of this class."""
        return cls(gamma.camera, gamma.appearances)

    def save(self, path: str | Path) -> Path:
        """Write a ``gamma/1`` file, whole or not at all, and return its path."""
        from sensing.files.gamma_files import write_gamma

        write_gamma(self, path)
        return Path(path)

    @property
    def rows(self) -> tuple[Appearance, ...]:
        """The appearances."""
        return self.appearances

    def blocks(self) -> tuple[Block, ...]:
        """One table."""
        names = ("id", "type", "u", "v", "detector")
        rows = tuple((a.id, a.type, f"{a.uv[0]:.1f}", f"{a.uv[1]:.1f}", a.detector or "") for a in self.appearances)
        columns = tuple(Column(name, right=name in ("u", "v")) for name in names)
        return (Table(f"{len(rows)} appearances in {self.camera.width}x{self.camera.height}", columns, rows),)

    def __repr__(self) -> str:
        return str(self)


WAYS = "a Camera (Camera.from_fov, where its field of view is known) or its file (ours, ROS, OpenCV, BOP or COLMAP)"


def shot_for(image: Image, camera: geometry_camera.Camera | str | Path | None, above: int) -> Shot:
    """Return the pixels (H, W, 3) of a file or of an array, with their camera; a guess by EXIF is warned of.

    ``above``: how many calls above this one the user's is, where the warning belongs.

    Raises:
        Error: where the image cannot be read, nothing tells its camera, or that is of another size.
    """
    named = isinstance(image, (str, Path))
    source = str(image) if named else "the image"
    if isinstance(camera, geometry_camera.Camera):
        if named:
            return Shot(image_by(camera, source, "camera"), camera)
        pixels = pixels_of(image)
        return Shot(pixels, sized(camera, (pixels.shape[1], pixels.shape[0]), "camera", source))
    if camera is not None and not isinstance(camera, str | Path):
        raise InputError(f"camera: should be a Camera or its file, not {type(camera).__name__}")
    given = GivenCamera() if camera is None else GivenCamera(str(camera))
    shot = shot_of(source, given, WAYS) if named else shot_with(pixels_of(image), given, source, WAYS)
    for note in shot.notes:
        warnings.warn(f"{source}: {note}", stacklevel=above)
    return shot


def pixels_of(image: Image) -> NDArray[np.uint8]:
    """Return the pixels (H, W, 3) of a file or of an array. Raises ImageError for anything else."""
    from sensing.files.images import read_image

    if isinstance(image, (str, Path)):
        return read_image(image)
    if (
        not isinstance(image, np.ndarray)
        or image.dtype != np.uint8
        or image.ndim != 3
        or image.shape[2] != 3
        or not image.size
    ):
        raise ImageError(
            f"an image must be a file, or an array (H, W, 3) of uint8, blue first, not {_described(image)}"
        )
    return image


def _described(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"one {value.shape} of {value.dtype}"
    return f"{type(value).__name__}"
