"""Robot descriptions: the visible shapes of all links of a URDF in the zero pose, and of an SDF at the poses that it states."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from kb.errors import IntakeError
from kb.intake.visuals import Visual, frame, numbers, primitive_sizes, read_xml

Frame = NDArray[np.float64]
Colour = tuple[int, int, int]
Read = Callable[[Element, str], str | None]
"""The text that a shape has under a key."""


HOLDERS = ("world", "model", "link")
"""Elements of SDF that hold others at a pose of their own."""
SIZES = {"box": [("size", 3)], "cylinder": [("radius", 1), ("length", 1)], "sphere": [("radius", 1)]}
"""The attributes (URDF) or elements (SDF) of a primitive, with how many numbers each."""


def urdf_visuals(path: Path) -> list[Visual]:
    """The shapes at their places in the root link's frame, m.

    Raises:
        IntakeError: no URDF, a joint that names no link, joints in a circle, numbers that are none.
    """
    root = read_xml(path)
    if root.tag != "robot":
        raise IntakeError(f"{path}: is no URDF: its first element is <{root.tag}>, not <robot>")
    frames = _link_frames(root, path)
    colours = {
        row.get("name", ""): colour for row in root.findall("material") if (colour := _rgb(row, path)) is not None
    }
    return [
        shape
        for link in root.findall("link")
        for shape in _urdf_shapes(link, frames[link.get("name", "")], colours, path)
    ]


def _link_frames(root: Element, path: Path) -> dict[str, Frame]:
    """root_from_link of every link."""
    names = [link.get("name", "") for link in root.findall("link")]
    above: dict[str, tuple[str, Frame]] = {}
    for joint in root.findall("joint"):
        parent, child = (_link_of(joint, end, names, path) for end in ("parent", "child"))
        above[child] = parent, _origin(joint, path)
    frames = {}
    for name in names:
        total, link, steps = np.eye(4), name, 0
        while link in above:
            link, step = above[link][0], above[link][1]
            total, steps = step @ total, steps + 1
            if steps > len(names):
                raise IntakeError(f"{path}: the joints above link {name!r:.60} run in a circle")
        frames[name] = total
    return frames


def _link_of(joint: Element, end: str, names: list[str], path: Path) -> str:
    entry = joint.find(end)
    name = entry.get("link", "") if entry is not None else ""
    if name not in names:
        raise IntakeError(f"{path}: joint {joint.get('name', '')!r:.60}: its {end} {name!r:.60} is no link")
    return name


def _origin(element: Element, path: Path) -> Frame:
    entry = element.find("origin")
    if entry is None:
        return np.eye(4)
    what = f"{path}: origin of {element.tag} {element.get('name', '')!r:.60}"
    return frame(numbers(entry.get("xyz"), 3, 0.0, f"{what}: xyz"), numbers(entry.get("rpy"), 3, 0.0, f"{what}: rpy"))


def _urdf_shapes(link: Element, root_from_link: Frame, colours: dict[str, Colour], path: Path) -> Iterator[Visual]:
    for visual in link.findall("visual"):
        place = root_from_link @ _origin(visual, path)
        material = visual.find("material")
        colour = None if material is None else _rgb(material, path) or colours.get(material.get("name", ""))
        where = f"{path}: link {link.get('name', '')!r:.60}"
        for shape in _shapes(visual, place, lambda shape, key: shape.get(key), "filename", where, path):
            yield replace(shape, colour=colour)


def _rgb(material: Element, path: Path) -> Colour | None:
    entry = material.find("color")
    if entry is None or entry.get("rgba") is None:
        return None
    red, green, blue, _ = (
        round(255 * min(max(x, 0.0), 1.0)) for x in numbers(entry.get("rgba"), 4, 1.0, f"{path}: rgba")
    )
    return red, green, blue


def sdf_visuals(path: Path) -> list[Visual]:
    """The shapes at their places in the file's frame, m.

    Poses that are relative to other frames than the parent's are refused.

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
            where = f"{path}: visual {child.get('name', '')!r:.60}"
            yield from _shapes(child, root_from_element @ _pose(child, path), _element_text, "uri", where, path)


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


def _element_text(shape: Element, key: str) -> str:
    return (shape.findtext(key) or "").strip()


def _shapes(visual: Element, place: Frame, read: Read, file_key: str, where: str, path: Path) -> Iterator[Visual]:
    """The meshes and primitives of a ``visual`` at ``place``; ``where`` names it in errors."""
    for shape in visual.findall("geometry/*"):
        what = f"{where}: {shape.tag}"
        if shape.tag == "mesh":
            scale = numbers(read(shape, "scale"), 3, 1.0, f"{what}: scale")
            yield Visual(place, read(shape, file_key) or "", tuple(scale))
        elif shape.tag in SIZES:
            rows = [numbers(read(shape, key), count, 0.0, f"{what}: {key}") for key, count in SIZES[shape.tag]]
            sizes = [size for row in rows for size in row]
            yield Visual(place, kind=shape.tag, sizes=primitive_sizes(shape.tag, sizes, path))
