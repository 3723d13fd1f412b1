"""SDF: the visible shapes of all links of all models in the file, at the poses that it states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kb.errors import IntakeError
from kb.intake.visuals import Visual, primitive_sizes
from kb.intake.xml_text import frame, numbers, read_xml

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from xml.etree.ElementTree import Element

    from numpy.typing import NDArray

    Frame = NDArray[np.float64]

HOLDERS = ("world", "model", "link")
"""Elements that hold others at a pose of their own."""
SIZES = {"box": [("size", 3)], "cylinder": [("radius", 1), ("length", 1)], "sphere": [("radius", 1)]}
"""The elements of a primitive, with how many numbers each."""


def sdf_visuals(path: Path) -> list[Visual]:
    """The shapes at their places in the file's frame, m. Poses that are relative to other frames than the parent's are refused.

    Raises:
        IntakeError: no SDF, a pose relative to something else, numbers that are none.
    """
    root = read_xml(path)
    if root.tag not in ("sdf", "gazebo"):
        raise IntakeError(f"{path}: is no SDF: its first element is <{root.tag}>, not <sdf>")
    return list(_inside(root, np.eye(4), path))


def _inside(element: Element, root_from_element: Frame, path: Path) -> Iterator[Visual]:
    for child in element:
        if child.tag in HOLDERS:
            yield from _inside(child, root_from_element @ _pose(child, path), path)
        elif child.tag == "visual":
            yield from _shapes(child, root_from_element @ _pose(child, path), path)


def _pose(element: Element, path: Path) -> Frame:
    entry = element.find("pose")
    if entry is None:
        return np.eye(4)
    relative = entry.get("relative_to") or entry.get("frame")
    if relative:
        raise IntakeError(
            f"{path}: the pose of {element.tag} {element.get('name', '')!r:.60} is relative to {relative!r:.60}, which is not read"
        )
    values = numbers(entry.text, 6, 0.0, f"{path}: pose of {element.tag} {element.get('name', '')!r:.60}")
    return frame(values[:3], values[3:])


def _shapes(visual: Element, place: Frame, path: Path) -> Iterator[Visual]:
    for shape in visual.findall("geometry/*"):
        what = f"{path}: visual {visual.get('name', '')!r:.60}: {shape.tag}"
        if shape.tag == "mesh":
            scale = numbers(shape.findtext("scale"), 3, 1.0, f"{what}: scale")
            yield Visual(place, (shape.findtext("uri") or "").strip(), tuple(scale))
        elif shape.tag in SIZES:
            sizes = [
                size
                for key, count in SIZES[shape.tag]
                for size in numbers(shape.findtext(key), count, 0.0, f"{what}: {key}")
            ]
            yield Visual(place, kind=shape.tag, sizes=primitive_sizes(shape.tag, sizes, path))
