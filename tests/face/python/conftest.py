"""The shipped KB ``first`` with its Γ, and the demo's picture of the towers, as a user of Python has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plogic import KnowledgeBase, perceive

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="session")
def gamma_file():
    """The Γ of the guide."""
    return EXAMPLES / "first_gamma.json"


@pytest.fixture(scope="session")
def first():
    """The guide's knowledge base."""
    return KnowledgeBase.load("first")


@pytest.fixture(scope="session")
def scene(first, gamma_file):
    """What the guide's Γ comes to."""
    return perceive(gamma_file, first)


@pytest.fixture(scope="session")
def towers_picture(tmp_path_factory):
    """A folder with ``image.png`` and ``camera.json`` of one tower, a small picture."""
    from geometry.camera import Camera, camera_to_dict
    from plogic.face.commands.demo import json_bytes
    from plogic.face.commands.simulate import shapes_of
    from plogic.run.sources import kb_of
    from sensing.simulated.scene import png, random_scene

    half = np.array([[300.0, 0, 160], [0, 300.0, 120], [0, 0, 1]])
    made = random_scene(shapes_of(kb_of("towers"))[:1], 3, camera=Camera(320, 240, half, np.zeros(0)))
    folder = tmp_path_factory.mktemp("towers")
    (folder / "image.png").write_bytes(png(made.photograph().image))
    (folder / "camera.json").write_bytes(json_bytes(camera_to_dict(made.camera)))
    return folder
