"""Robot descriptions to one mesh: the visible shapes of all links, each at its place.

A URDF is read in the zero pose, an SDF at the poses that it states.

Vocabulary: ``Visual``, one shape: a mesh file with its scale, or a primitive, at ``root_from_shape``; its colour, if
the description has one.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from geometry.files.plain_files import content_of, fault_of, must_be_plain
from geometry.files.side_files import homes, inside
from geometry.files.xml_files import XMLMistakeError, root_of
from geometry.frames import from_rotation_translation
from kb.errors import IntakeError
from kb.files.quantities import LARGEST
from kb.intake.source import GREY, Piece, Source, copied, read_source
from kb.intake.templates import unfilled

Frame = NDArray[np.float64]


MAX_BYTES = 20_000_000
"""Largest description."""


def read_xml(path: Path) -> Element:
    """The root element; what the declaration says is not asked, as pybullet's own files have version 0.0 there.

    Raises:
        IntakeError: no file, too large, no XML, nested too deeply, one that defines entities, or a template.
    """
    must_be_plain(path, IntakeError, MAX_BYTES)
    text = content_of(path, MAX_BYTES, IntakeError).decode("utf-8-sig", errors="replace")
    if mistake := unfilled(path, text):
        raise IntakeError(mistake)
    try:
        return root_of(text, "robot description")
    except XMLMistakeError as error:
        raise IntakeError(f"{path}: {error}") from None


def numbers(text: str | None, count: int, default: float, what: str) -> list[float]:
    """``count`` numbers of a text, all ``default`` where there is none; raises IntakeError for anything else."""
    if text is None or not text.strip():
        return [default] * count
    try:
        found = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        found = []
    if len(found) != count or not all(abs(number) < LARGEST for number in found):
        raise IntakeError(
            f"{what}: must be {count} finite number{'s'[: count > 1]} below {LARGEST:g}, not {text.strip()!r:.60}"
        )
    return found


def frame(xyz: list[float], rpy: list[float]) -> Frame:
    """parent_from_child (4, 4): turns about the parent's x, y, z by roll, pitch, yaw (rad), then ``xyz`` (m)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    turn = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.asarray(from_rotation_translation(np.array(turn), np.array(xyz)))


ABOVE = 6
"""Folders above the description's that a mesh may lie below."""


def found_file(path: Path, name: str) -> Path | None:
    """The file that the description at ``path`` names.

    Relative to its folder, or, as ``package://NAME/REST`` and ``model://``, beneath a folder above. No absolute path,
    and nothing that leads out of ``ABOVE`` folders above.
    """
    rest = re.sub(r"^(file|package|model)://", "", name.strip())
    plain, roots = "://" not in name or name.startswith("file:"), homes(path, ABOVE)
    for place in _places(path.parent, rest, plain=plain) if not rest.startswith(("/", "~")) else ():
        if inside(place, roots) and fault_of(place) is None:
            return place
    return None


def _places(folder: Path, rest: str, *, plain: bool) -> Iterator[Path]:
    yield folder / rest
    if plain:
        return
    inner = rest.partition("/")[2]
    for above in [folder, *folder.resolve().parents][:ABOVE]:
        yield above / rest
        yield above / inner


MOST = 2000
"""Most shapes of a description."""


@dataclass(frozen=True, eq=False)
class Visual:
    """``file`` of a mesh, or a primitive: ``kind`` box, cylinder or sphere with its ``sizes``.

    Sizes are sides; radius and length; radius.

    ``scale`` (3,) of the mesh's coordinates; ``root_from_shape`` (4, 4), m; ``colour`` red, green, blue in [0, 255].
    ``where``: the file and the link, for errors; ``link``: its name.
    """

    root_from_shape: NDArray[np.float64]
    file: str | None = None
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    kind: str = ""
    sizes: tuple[float, ...] = ()
    colour: tuple[int, int, int] | None = None
    where: str = ""
    link: str = ""


def merged(path: Path, visuals: Sequence[Visual]) -> Source:
    """All shapes as one source, in metres and in the root's frame.

    Raises:
        IntakeError: no visible shape at all, or a line for each mesh that cannot be had.
    """
    if len(visuals) > MOST:
        raise IntakeError(f"{path}: has {len(visuals)} visible shapes, more than {MOST}")
    read: dict[Path, Source | str] = {}
    pieces: list[Piece] = []
    notes, wrong = list[str](), list[str]()
    for visual in visuals:
        source = _source(path, visual, read)
        if isinstance(source, str):
            wrong.append(f"{visual.where}: {source}")
            continue
        placed = source.moved(visual.root_from_shape @ np.diag([*visual.scale, 1.0]))
        colour = visual.colour or GREY  # of what has none of its own
        pieces += [
            replace(piece, colour=colour if piece.colour == GREY else piece.colour, name=visual.link)
            for piece in placed.pieces
        ]
        notes += source.notes
    if wrong:
        raise IntakeError("\n".join(dict.fromkeys(wrong)))
    if not pieces:
        raise IntakeError(f"{path}: holds no visible shape")
    elsewhere = [file for file in read if not inside(file, homes(path))]
    return Source(tuple(pieces), tuple(dict.fromkeys([*copied(elsewhere, path.parent), *notes])))


SOUGHT = "in the description's folder and, of package:// and model://, below the six folders above"
ABSOLUTE = "is an absolute path: name it relative to the description, or by package://"


def _source(path: Path, visual: Visual, read: dict[Path, Source | str]) -> Source | str:
    """The shape in its own frame, each file read once; instead, where it cannot be had, what is wrong."""
    if visual.file is None:
        return _primitive(visual)
    file = found_file(path, visual.file)
    if file is None:
        absolute = re.match(r"(file://)?[/~]", visual.file.strip())
        why = ABSOLUTE if absolute else f"is missing or no plain file, {SOUGHT}: put it there"
        return f"the mesh {visual.file!r:.80} {why}, or take the visual out"
    if file not in read:
        try:
            read[file] = read_source(file)
        except IntakeError as error:
            read[file] = f"{error}: repair it, or take the visual out"
    return read[file]


def _primitive(visual: Visual) -> Source:
    from trimesh import creation

    if visual.kind == "box":
        mesh: Any = creation.box(extents=visual.sizes)
    elif visual.kind == "cylinder":
        mesh = creation.cylinder(radius=visual.sizes[0], height=visual.sizes[1], sections=48)
    else:
        mesh = creation.icosphere(subdivisions=3, radius=visual.sizes[0])
    return Source((Piece(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)),))


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


STILL = ("fixed", "")
"""Types of joints that do not move."""
NAMED = 3
"""Joints that a note names."""


def frozen_joints(path: Path) -> list[str]:
    """A note where joints move: a type is rigid, and is only found as the description poses it. Of URDF and SDF."""
    joints = [joint for joint in read_xml(path).iter("joint") if joint.get("type", "").strip() not in STILL]
    if not joints:
        return []
    named = ", ".join(joint.get("name", "")[:60] for joint in joints[:NAMED])
    more = f" and {len(joints) - NAMED} more" if len(joints) > NAMED else ""
    what = "1 joint that moves is" if len(joints) == 1 else f"{len(joints)} joints that move are"
    pose = "the zero pose" if path.suffix.lower() == ".urdf" else "the pose that the file states"
    found = f"{what} frozen in {pose} ({named}{more}), and the type is found in that pose alone"
    return [f"{found}: import what moves as types of their own, a file each"]


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
            yield replace(shape, colour=colour, link=link.get("name", "").strip())


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


def _inside(element: Element, root_from_element: Frame, path: Path, link: str = "") -> Iterator[Visual]:
    for child in element:
        if child.tag in HOLDERS:
            own = child.get("name", "").strip() if child.tag == "link" else link
            yield from _inside(child, root_from_element @ _pose(child, path), path, own)
        elif child.tag == "visual":
            where = f"{path}: visual {child.get('name', '')!r:.60}"
            for shape in _shapes(child, root_from_element @ _pose(child, path), _element_text, "uri", where, path):
                yield replace(shape, link=link)


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
            yield Visual(place, read(shape, file_key) or "", tuple(scale), where=where)
        elif shape.tag in SIZES:
            rows = [numbers(read(shape, key), count, 0.0, f"{what}: {key}") for key, count in SIZES[shape.tag]]
            sizes = tuple(size for row in rows for size in row)
            if not all(size > 0 for size in sizes):
                raise IntakeError(f"{path}: the sizes of a {shape.tag} must be above 0, not {list(sizes)}")
            yield Visual(place, kind=shape.tag, sizes=sizes)
