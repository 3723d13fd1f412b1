"""A folder of frames, good and bad, and what one process makes of them."""

from __future__ import annotations

import json
import shutil

import pytest


@pytest.fixture(scope="session")
def frames(tmp_path_factory):
    """A folder with ``frames`` in it.

    Five Γ, one of them bad, a picture with its camera, a corrupt one, and one without a camera.
    """
    from small_frames import CAMERA, gamma, picture

    root = tmp_path_factory.mktemp("batch")
    place = root / "frames"
    for name in ("shot", "torn"):
        (place / name).mkdir(parents=True)
        (place / name / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    for number in range(4):
        (place / f"g{number}.json").write_text(json.dumps(gamma(number)))
    (place / "bad.json").write_text('{"format": "gamma/1"}')
    picture(place / "alone.png")
    picture(place / "shot" / "image.png")
    shutil.copy(place / "shot" / "image.png", place / "torn" / "image.png")
    (place / "torn" / "image.png").write_bytes((place / "torn" / "image.png").read_bytes()[:60])
    return root


@pytest.fixture(scope="session")
def alone(frames):
    """The finished process of ``--jobs 1 --full`` over the folder, and its file."""
    from console import plogic
    from small_frames import KB

    run = plogic("batch", "frames", "--kb", KB, "--jobs", 1, "--full", "-o", "alone.jsonl", cwd=frames)
    return run, frames / "alone.jsonl"
