"""The shipped look-alikes are what `python -m benchmarks.author.towers lookalikes` writes.

Two that differ on one wall, one like neither.
"""

from pathlib import Path

import numpy as np

import kb
from benchmarks.author.towers import author
from kb.files.read import read_kb

SHIPPED = Path(kb.__file__).parent / "lookalikes"


def test_the_same_bytes(tmp_path):
    author("lookalikes", tmp_path)
    names = sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*") if p.is_file() and p.suffix != ".png")
    assert names == sorted(
        str(p.relative_to(SHIPPED)) for p in SHIPPED.rglob("*") if p.is_file() and p.suffix != ".png"
    )
    assert [name for name in names if (tmp_path / name).read_bytes() != (SHIPPED / name).read_bytes()] == []


def test_the_blind_tower_lacks_the_windows_of_the_north_wall_and_nothing_else():
    types = {kind.name: kind for kind in read_kb(SHIPPED).types}
    whole, blind = ({f.name for f in types[name].features} for name in ("open_tower", "blind_tower"))
    assert len(whole - blind) == 9
    assert {name.split("/")[-1][:5] for name in whole - blind} == {"north"}
    assert blind < whole
    assert np.array_equal(types["open_tower"].surface.vertices, types["blind_tower"].surface.vertices)
