"""The reliability diagram: well-formed, the same every time, and true to its bins."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.calibration.diagram import SIDE, TENTHS, TOP, Panel, diagram
from benchmarks.calibration.reliability import reliability

SVG = "{http://www.w3.org/2000/svg}"
ROWS = st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1, max_size=40)


def panel(rows, title="posterior"):
    return Panel(title, "ECE & more", np.array([p for p, _ in rows]), np.array([float(y) for _, y in rows]))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.lists(ROWS, min_size=1, max_size=3),
    st.text(st.characters(min_codepoint=32, blacklist_categories=["Cs"]), max_size=10),
)
def test_it_is_xml_whatever_it_is_called_and_the_same_twice(forecasters, title):
    panels = [panel(rows, title) for rows in forecasters]
    text = diagram(f"<{title}>", panels)
    assert text == diagram(f"<{title}>", panels)
    root = ET.fromstring(text)  # noqa: S314 - our own text
    assert len(root.findall(f"{SVG}g")) == len(panels)


def test_dots_stand_where_their_bins_are_and_counts_add_up():
    rng = np.random.default_rng(0)
    p = rng.random(300)
    shown = Panel("posterior", "", p, (rng.random(300) < p).astype(float))
    root = ET.fromstring(diagram("one", [shown]))  # noqa: S314 - our own text
    dots = [(float(c.get("cx")), float(c.get("cy"))) for c in root.iter(f"{SVG}circle")]
    bins = reliability(p, shown.outcomes)
    assert dots == [pytest.approx((SIDE * b.forecast, TOP + SIDE * (1 - b.true)), abs=0.06) for b in bins]
    numbers = [int(t.text) for t in root.iter(f"{SVG}text") if t.get("font-size") == "11"]
    assert len(numbers) == TENTHS
    assert sum(numbers) == 300
    assert [c.find(f"{SVG}title").text.split()[0] for c in root.iter(f"{SVG}circle")] == [str(b.count) for b in bins]


def test_it_has_colours_for_light_and_dark_pages_and_needs_nothing_from_elsewhere():
    text = diagram("one", [panel([(0.5, True)])])
    assert "prefers-color-scheme: dark" in text
    assert "http" not in text.replace("http://www.w3.org/2000/svg", "")
