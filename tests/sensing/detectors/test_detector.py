"""The registry of detectors, and detect(): the same pixels give the same Γ."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import quads, sectors

from geometry.camera import Camera
from sensing.appearance import Appearance
from sensing.detectors.detector import detect, detectors, register, unregister
from sensing.detectors.junctions import TYPES
from sensing.errors import DetectorError, ImageError

EVERY = {"patch", *TYPES}


def camera(image):
    return Camera(image.shape[1], image.shape[0], np.array([[600.0, 0, 80], [0, 600, 80], [0, 0, 1]]), np.zeros(0))


class Middle:
    """Reports the image's middle, twice: of a type that is wanted and of one that is not."""

    name, types = "middle", ("dot", "dash")

    def detect(self, image_bgr):
        """One of each."""
        uv = (image_bgr.shape[1] / 2, image_bgr.shape[0] / 2)
        return [Appearance("x", t, uv, self.name) for t in self.types]


@pytest.fixture
def middle():
    register("middle", Middle)
    yield
    unregister("middle")


def test_ids_follow_detector_then_v_then_u():
    image = quads([[[40, 30], [60, 30], [60, 50], [40, 50]], [[100, 30], [120, 30], [120, 50], [100, 50]]])
    image[80:, 90:] = 90
    found = detect(image, camera(image), EVERY).appearances
    assert [a.id for a in found] == [f"a{i}" for i in range(1, len(found) + 1)]
    keys = [(a.detector, a.uv[1], a.uv[0]) for a in found]
    assert keys == sorted(keys)
    assert {a.detector for a in found} == {"junction", "patch"}


def test_only_the_vocabulary_s_types_are_reported():
    image = sectors(np.radians([0, 115, 235]), [200, 140, 80])
    assert {a.type for a in detect(image, camera(image), {"y_junction"}).appearances} == {"y_junction"}
    assert detect(image, camera(image), {"word"}).appearances == ()


def test_the_same_pixels_give_the_same_gamma():
    image = sectors(np.radians([0, 115, 235]), [200, 140, 80])
    assert detect(image, camera(image), EVERY).appearances == detect(image.copy(), camera(image), EVERY).appearances


def test_nothing_is_seen_in_a_constant_image():
    image = np.full((480, 640, 3), 120, np.uint8)
    assert detect(image, camera(image), EVERY).appearances == ()


def test_a_registered_detector_is_used(middle):
    image = np.full((100, 200, 3), 120, np.uint8)
    (found,) = detect(image, camera(image), {"dot", "patch"}).appearances
    assert found == Appearance("a1", "dot", (100, 50), "middle")


def test_a_name_is_taken_once(middle):
    assert list(detectors()) == sorted(detectors())
    assert {"junction", "middle", "orb", "patch", "sift"} <= set(detectors())
    with pytest.raises(DetectorError, match="'middle': the name is taken"):
        register("middle", Middle)
    with pytest.raises(DetectorError, match="none of this name"):
        unregister("nobody")


def test_an_entry_point_that_does_not_load_is_named(monkeypatch):
    from importlib.metadata import EntryPoint

    broken = EntryPoint("broken", "no_such_module_anywhere:Factory", "plogic.detectors")
    monkeypatch.setattr(
        "sensing.detectors.detector.entry_points", lambda group: [broken] if group == "plogic.detectors" else []
    )
    with pytest.raises(DetectorError, match="'broken' of no_such_module_anywhere:Factory does not load"):
        detectors()


def test_an_installed_detector_is_known(monkeypatch):
    from importlib.metadata import EntryPoint

    point = EntryPoint("other", "test_detector:Middle", "plogic.detectors")
    monkeypatch.setattr("sensing.detectors.detector.entry_points", lambda **_: [point])
    monkeypatch.setattr(EntryPoint, "load", lambda _: Middle)
    image = np.full((100, 200, 3), 120, np.uint8)
    assert [a.detector for a in detect(image, camera(image), {"dash"}).appearances] == ["middle"]


def test_an_image_that_does_not_fit_its_camera_is_refused():
    image = np.zeros((100, 200, 3), np.uint8)
    with pytest.raises(ImageError, match="200x100 is not the camera's size, 100x200"):
        detect(image, Camera(100, 200, camera(image).K, np.zeros(0)), EVERY)
    with pytest.raises(ImageError, match="uint8"):
        detect(image.astype(float), camera(image), EVERY)


class Third:
    """A third party's detector that reports, or raises, what it is given."""

    name, types = "third", ("dot",)

    def __init__(self, found):
        self.found = found

    def detect(self, _image_bgr):
        """What it was given."""
        if isinstance(self.found, Exception):
            raise self.found
        return self.found


def dot(uv=(5.0, 5.0), **others):
    return Appearance("", "dot", uv, "third", **others)


@pytest.mark.parametrize(
    ("found", "why"),
    [
        (ValueError("no\nsuch thing"), "failed on the image: ValueError: no such thing"),
        (ZeroDivisionError(), "failed on the image: ZeroDivisionError"),
        (None, "failed on the image: TypeError"),
        (["dot"], "appearance 0 of 1: is no Appearance but a str"),
        ([dot(), dot((200.0, 5.0))], r"appearance 1 of 2: uv \(200.0, 5.0\) is outside the image of 200x100"),
        ([dot((np.nan, 5.0))], "not finite"),
        ([dot(angle=np.inf)], "not finite"),
        ([dot(arms=(0.1, np.nan))], "not finite"),
        ([dot((1.0, "x"))], "has numbers that are none"),
        ([dot((1.0, 2.0, 3.0))], "has numbers that are none"),
        ([dot(scale=0.0)], "scale 0.0 is not above 0"),
        ([dot(descriptor="abc")], "descriptor is no bytes but a str"),
        ([Appearance("", "", (1.0, 1.0), "third")], "is no name"),
    ],
)
def test_what_a_third_party_gets_wrong_is_one_line_that_names_it(found, why):
    register("third", lambda: Third(found))
    try:
        with pytest.raises(
            DetectorError, match=f"^detector 'third': {why}|^detector 'third': appearance 0 of 1: .*{why}"
        ) as caught:
            detect(np.full((100, 200, 3), 120, np.uint8), camera(np.zeros((100, 200))), {"dot"})
    finally:
        unregister("third")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("factory", [lambda: 1 / 0, object, type("T", (), {"types": "dot"})])
def test_a_factory_that_makes_no_detector_is_one_line(factory):
    register("third", factory)
    try:
        with pytest.raises(DetectorError, match=r"^detector 'third': ") as caught:
            detect(np.full((100, 200, 3), 120, np.uint8), camera(np.zeros((100, 200))), {"dot"})
    finally:
        unregister("third")
    assert "\n" not in str(caught.value)


def test_every_built_in_detector_has_its_own_types_and_its_registered_name():
    made = {name: factory() for name, factory in detectors().items()}
    assert all(name == detector.name for name, detector in made.items())
    every = [t for detector in made.values() for t in detector.types]
    assert len(every) == len(set(every))
