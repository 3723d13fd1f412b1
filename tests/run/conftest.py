"""The simulated towers from three places: pictures, a lossless video of them, and one that is cut off."""

from __future__ import annotations

import json
import shutil

import pytest


@pytest.fixture(scope="session")
def towers(tmp_path_factory):
    """A folder.

    ``pictures/clip_000000.png`` and so on, and ``clip.mkv``, each with its ``camera.json``; ``poses.json``;
    ``cut_clip.mkv``, which has its first frame alone.
    """
    import cv2
    from console import good
    from written_videos import cut, video

    root = tmp_path_factory.mktemp("towers")
    good("simulate", "--kb", "towers", "--seed", 1, "--robot", "ring:3", "-o", "shots", cwd=root)
    (root / "pictures").mkdir()
    for number in range(3):
        shutil.copy(root / "shots" / f"frame-00{number}" / "image.png", root / "pictures" / f"clip_{number:06d}.png")
    camera = json.loads((root / "shots" / "frame-000" / "camera.json").read_text())
    for part in (camera, camera.get("camera", {})):
        part.pop("T_world_camera", None)
    for folder in (root, root / "pictures"):
        (folder / "camera.json").write_text(json.dumps(camera))
    shutil.copy(root / "shots" / "poses.json", root / "poses.json")
    video(root / "clip.mkv", [cv2.imread(str(file)) for file in sorted((root / "pictures").glob("*.png"))])
    cut(root / "clip.mkv", 0.6)
    return root
