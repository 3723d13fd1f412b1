"""A BOP dataset's folder, read frame by frame.

* ``Truth``, one annotated object: ``Truth(5, camera_from_object, 0.93)``
* ``Frame``, one picture with its camera: ``Frame(1, 3, image, camera)``
* ``Scene``, a folder with ``scene_camera.json``; ``Dataset``, its scenes, with the targets and the models' folder where
  there are any
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from geometry.files.plain_files import fault_of, is_there
from plogic.base.errors import InputError
from plogic.run.bop.json_files import entry_of, fraction, member, motion, numbered, numbers, shown, whole

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from geometry.camera import Camera

PICTURES = tuple(
    f"{folder}/{{:06d}}.{ending}" for folder in ("rgb", "gray") for ending in ("png", "jpg", "jpeg", "tif")
)
"""Where a frame's picture may be, the first that exists."""


@dataclass(frozen=True, eq=False)
class Truth:
    """One object of a frame's ground truth: ``camera_from_object`` (4, 4) m.

    ``visible`` fraction, None where nobody says.
    """

    obj_id: int
    camera_from_object: NDArray[np.float64]
    visible: float | None = None


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture (H, W, 3) uint8, blue first, and its camera, metres."""

    scene_id: int
    im_id: int
    image: NDArray[np.uint8]
    camera: Camera


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene's folder; its JSON files are read when they are first asked for."""

    folder: Path
    scene_id: int

    @cached_property
    def cameras(self) -> Mapping[int, Any]:
        """Entries of ``scene_camera.json`` by image. Raises InputError."""
        return numbered(self.folder / "scene_camera.json")

    @cached_property
    def _annotations(self) -> Mapping[int, Any] | None:
        path = self.folder / "scene_gt.json"
        return numbered(path) if is_there(path) else None

    @cached_property
    def _visibility(self) -> Mapping[int, Any] | None:
        path = self.folder / "scene_gt_info.json"
        return numbered(path) if is_there(path) else None

    def frame(self, im_id: int) -> Frame:
        """Picture and camera of one image. Raises InputError, ImageError, CameraError: one line with file and key."""
        from sensing.files.images import read_image

        entry = entry_of(self.cameras, im_id, self.folder / "scene_camera.json")
        image = read_image(self.picture(im_id))
        return Frame(self.scene_id, im_id, image, self._camera(im_id, entry, (image.shape[1], image.shape[0])))

    def picture(self, im_id: int) -> Path:
        """The picture's file. Raises InputError where there is none."""
        found = next(
            (
                self.folder / name.format(im_id)
                for name in PICTURES
                if fault_of(self.folder / name.format(im_id)) is None
            ),
            None,
        )
        if found is None:
            raise InputError(f"{self.folder}: has no picture {im_id:06d} (png, jpg, jpeg or tif) in rgb/ or gray/")
        return found

    def truths(self, im_id: int) -> tuple[Truth, ...] | None:
        """What stands before the camera; None where the scene has no ``scene_gt.json``. Raises InputError."""
        if self._annotations is None:
            return None
        path = self.folder / "scene_gt.json"
        entries = _listed(entry_of(self._annotations, im_id, path), f"{path}: {im_id}")
        visible = self._visible(im_id, len(entries))
        return tuple(_truth(entry, visible[i], f"{path}: {im_id}.{i}") for i, entry in enumerate(entries))

    def _visible(self, im_id: int, count: int) -> list[float | None]:
        if self._visibility is None:
            return [None] * count
        path = self.folder / "scene_gt_info.json"
        infos = _listed(entry_of(self._visibility, im_id, path), f"{path}: {im_id}")
        if len(infos) != count:
            raise InputError(f"{path}: {im_id}: has {len(infos)} entries, but scene_gt.json has {count}")
        places = [f"{path}: {im_id}.{i}" for i in range(count)]
        return [
            fraction(member(info, "visib_fract", at), f"{at}.visib_fract")
            for info, at in zip(infos, places, strict=True)
        ]

    def _camera(self, im_id: int, entry: object, size: tuple[int, int]) -> Camera:
        """The camera of one entry; its size is the picture's."""
        from geometry.camera import camera_from_dict
        from geometry.errors import CameraError
        from geometry.files.camera_files import from_bop_scene

        place = f"{self.folder / 'scene_camera.json'}: {im_id}"
        numbers(member(entry, "cam_K", place), 9, f"{place}.cam_K")
        content: dict[str, Any] = {"cam_K": entry["cam_K"]} if isinstance(entry, dict) else {}
        if isinstance(entry, dict) and "cam_R_w2c" in entry:
            t_mm = numbers(member(entry, "cam_t_w2c", place), 3, f"{place}.cam_t_w2c")
            pose = motion(numbers(entry["cam_R_w2c"], 9, f"{place}.cam_R_w2c"), t_mm, f"{place}.cam_R_w2c")
            content |= {"cam_R_w2c": pose[:3, :3].ravel().tolist(), "cam_t_w2c": t_mm.tolist()}
        try:
            return camera_from_dict(from_bop_scene(content, size))
        except CameraError as error:
            raise InputError(f"{place}: {error}") from None


@dataclass(frozen=True, eq=False)
class Dataset:
    """``targets``: per (scene, image) the wanted instances by object; None: every image, every object.

    ``models``: their folder.

    ``wrong``: a line for each folder that would be a scene and is left out.
    """

    folder: Path
    scenes: tuple[Scene, ...]
    targets: Mapping[tuple[int, int], Mapping[int, int]] | None = None
    models: Path | None = None
    wrong: tuple[str, ...] = ()

    def scene(self, scene_id: int) -> Scene:
        """The scene of a number; raises KeyError."""
        return {scene.scene_id: scene for scene in self.scenes}[scene_id]

    def listed(self) -> tuple[list[tuple[int, int]], list[str]]:
        """(scene, image) of every frame that is wanted, in order, and a line for each scene that cannot be read or is left out."""
        if self.targets is not None:
            here = {scene.scene_id for scene in self.scenes}
            absent = sorted({s for s, _ in self.targets if s not in here})
            lines = [f"{self.folder}: has no scene {s:06d}, which the targets name" for s in absent]
            return sorted(key for key in self.targets if key[0] in here), [*lines, *self.wrong]
        names, lines = [], list(self.wrong)
        for scene in self.scenes:
            try:
                names += [(scene.scene_id, im_id) for im_id in sorted(scene.cameras)]
            except InputError as error:
                lines.append(str(error))
        return names, lines


def _listed(value: object, place: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{place}: must be a list, not {shown(value)}")
    return value


def _truth(entry: object, visible: float | None, place: str) -> Truth:
    R = numbers(member(entry, "cam_R_m2c", place), 9, f"{place}.cam_R_m2c")
    t_mm = numbers(member(entry, "cam_t_m2c", place), 3, f"{place}.cam_t_m2c")
    return Truth(
        whole(member(entry, "obj_id", place), f"{place}.obj_id"), motion(R, t_mm, f"{place}.cam_R_m2c"), visible
    )
