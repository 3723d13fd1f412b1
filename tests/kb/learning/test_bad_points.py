"""Clicked points that cannot be used: every mistake at its line and column, and none left out in silence."""

import pytest

from kb.errors import KBErrors
from kb.learning.photo import MOST, read_points

ROW = "points: [[1, 2, 3, 4, 5]]\n"
ONE_OF = "must be one of m, dm, cm, mm, um, km, in, ft, not "
BAD = {
    "units that are a list": (f"units: [m]\n{ROW}", f"1:8: units: {ONE_OF}['m']"),
    "units that are a mapping": (f"units: {{m: 1}}\n{ROW}", f"1:8: units: {ONE_OF}{{'m': 1}}"),
    "units of nothing": (f"units:\n{ROW}", f": units: {ONE_OF}None"),
    "a number of 400 digits": (
        f"points: [[1, 2, 3, 4, {'9' * 400}]]\n",
        "1:10: points.0: must be finite numbers below 1e9",
    ),
}


def mistake_of(path):
    with pytest.raises(KBErrors) as caught:
        read_points(path)
    (line,) = str(caught.value).splitlines()
    return line.removeprefix(f"{path}")


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_of_points(case, tmp_path):
    text, said = BAD[case]
    (tmp_path / "p.yaml").write_text(text)
    assert mistake_of(tmp_path / "p.yaml").endswith(said)


def test_more_points_than_a_csv_may_have_are_not_dropped(tmp_path):
    path = tmp_path / "p.csv"
    path.write_text("u,v,x,y,z\n" + "1,2,3,4,5\n" * MOST)
    assert len(read_points(path).uv) == MOST
    path.write_text("u,v,x,y,z\n" + "1,2,3,4,5\n" * (MOST + 3))
    assert mistake_of(path) == ":1002:1: is point 1001 of 1003: a file may have 1000 points"
