"""What has little print is proposed in large photos as in small ones: where it covers as much of them."""

from types import SimpleNamespace

import cv2
import pytest
from painted_cube import CAMERA, CORNER, cloud, picture, pose_towards, seen, write_knowledge

from geometry.frames import pose_error
from kb.files.read import read_kb
from plogic.match.learned.learned_views import maps_for, seen_anywhere
from plogic.run.perceive import Perceiver
from sensing.pixels.photo import Photo


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The cube, as if it had no print."""
    index = Perceiver(read_kb(write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": cloud(seen())}))).models["cube"]
    return SimpleNamespace(plain=True, paint=index.paint, body=index.body)


@pytest.mark.parametrize("larger", [1, 5])
def test_it_is_among_the_first_whatever_the_photos_size(plain, larger):
    truth = pose_towards(CORNER, 0.60, 0.0, (0.05, 0.02))
    image = cv2.resize(picture([truth], seed=3), None, fx=larger, fy=larger, interpolation=cv2.INTER_CUBIC)
    data = SimpleNamespace(photo=Photo(image, CAMERA.resized(image.shape[1], image.shape[0])))
    found = seen_anywhere(plain, maps_for([plain], data, 1), data)
    off = [pose_error(pose, truth)[1] for pose in found.poses[:5]]
    assert min(off) < 0.1 * truth[2, 3]
