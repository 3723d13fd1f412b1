"""The shipped towers are the output of `python -m benchmarks.author.towers towers`, with Table 1's composition.

(§5.6)
"""

from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import pytest

import kb
from benchmarks.author.texture import frame
from benchmarks.author.towers import author, t1, t2
from kb.files.read import read_kb

SHIPPED = Path(kb.__file__).parent / "towers"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("towers")
    author("towers", folder)
    return folder


def names(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def test_the_same_files(written):
    assert names(written) == names(SHIPPED)
    assert len(names(SHIPPED)) == 9


@pytest.mark.parametrize("name", [n for n in names(SHIPPED) if not n.endswith(".png")])
def test_the_same_bytes(written, name):
    assert (written / name).read_bytes() == (SHIPPED / name).read_bytes()


@pytest.mark.parametrize("tower", ["t1", "t2"])
def test_the_same_texture(written, tower):
    """Compared as pixels: another zlib packs them otherwise."""
    a, b = (cv2.imread(str(folder / "objects" / tower / "texture.png")) for folder in (written, SHIPPED))
    assert np.array_equal(a, b)


def test_counts_are_table_ones():
    kinds = {kind.name: Counter(feature.type for feature in kind.features) for kind in read_kb(SHIPPED).types}
    assert kinds == {"t1": {"corner": 8, "patch": 50}, "t2": {"apex": 1, "corner": 8, "patch": 45}}


@pytest.mark.parametrize("tower", [t1(), t2()])
def test_read_back_every_feature_stands_on_the_surface_where_it_was_drawn(tower):
    kind = read_kb(SHIPPED).type(tower.name)
    places = {f.name.split("/")[1]: f.at for f in kind.features}
    drawn = dict(zip(tower.names, tower.vertices, strict=True))
    drawn |= {window.name: window.centre for panel in tower.panels for window in panel.windows}
    assert places.keys() == drawn.keys()
    for name, place in drawn.items():
        assert places[name] == pytest.approx(place, abs=1e-6)


@pytest.mark.parametrize("tower", [t1(), t2()])
def test_windows_lie_inside_their_faces_with_room_round_them(tower):
    assert any(panel.windows for panel in tower.panels)
    for panel in tower.panels:
        corners = tower.vertices[list(panel.loop)]
        _, _, outward = frame(corners)
        inward = np.cross(outward, np.roll(corners, -1, axis=0) - corners)
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        for window in panel.windows:
            for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                corner = window.centre + signs[0] * window.across + signs[1] * window.up
                assert abs((corner - corners[0]) @ outward) < 1e-12
                assert ((corner - corners) * inward).sum(axis=1).min() > 0.04
