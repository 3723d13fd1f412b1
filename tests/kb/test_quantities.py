import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from kb.files.quantities import ANGLES, LENGTHS, angle, length, number
from kb.files.values import Units


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("0.2 m", 0.2),
        ("5 cm", 0.05),
        ("5cm", 0.05),
        (" -3 mm ", -0.003),
        ("1e2 mm", 0.1),
        (2, 2.0),
        (2.5, 2.5),
        ("1 in", 0.0254),
    ],
)
def test_lengths_are_metres(text, metres):
    assert length(text) == pytest.approx(metres, abs=1e-15)


@pytest.mark.parametrize(
    ("text", "radians"), [("180 deg", math.pi), ("1.5 rad", 1.5), (1.5, 1.5), ("0.25 turn", math.pi / 2)]
)
def test_angles_are_radians(text, radians):
    assert angle(text) == pytest.approx(radians, abs=1e-15)


@pytest.mark.parametrize(
    "wrong", ["5", "5 deg", "m", "five m", "nan m", "inf m", "1e999 m", float("nan"), True, None, [1], "", 10**400]
)
def test_what_is_no_length_is_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        length(wrong)


@pytest.mark.parametrize("wrong", ["60", "60 m", "60 degrees", math.inf, False, "nan deg"])
def test_what_is_no_angle_is_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        angle(wrong)


@pytest.mark.parametrize("wrong", ["1", True, None, math.nan, 10**400])
def test_what_is_no_number_is_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        number(wrong)


def test_units_of_a_mesh_are_named():
    assert TypeAdapter(Units).validate_python("mm") == "mm"
    with pytest.raises(ValueError, match="must be one of m, dm, cm, mm"):
        TypeAdapter(Units).validate_python("furlong")


@given(st.floats(-1e6, 1e6, exclude_min=True, exclude_max=True), st.sampled_from(sorted(LENGTHS)))
def test_a_unit_scales(value, unit):
    assert length(f"{value!r} {unit}") == pytest.approx(value * LENGTHS[unit])


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(ANGLES)))
def test_a_unit_turns(value, unit):
    assert angle(f"{value!r} {unit}") == pytest.approx(value * ANGLES[unit])
