"""Read what an ``interpretation/1`` or a ``panorama/1`` leaves open, as a prospect.

Its worlds, and how the types in them are seen.

The worlds of a panorama are those of all views, told from where the last one stood. How a type is seen is told by the
interpretation of any view that had it in Δh.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict, cast

import numpy as np

from geometry.arrays import Floats
from geometry.camera_row import CameraRow, Pose
from geometry.errors import GeometryError
from geometry.frames import inverse, is_rigid
from geometry.visibility.rays import RayMesh
from kb.clouds.lobes import LobeTable
from plogic.base.errors import InterpretationError
from plogic.facts.carried_rows import AssetsRow, TypeRow
from plogic.facts.document import Interpretation, Marks, SensingRow, WorldRow
from plogic.facts.fact_rows import Interval, PairRow
from plogic.facts.interpretation import interpretation_in, parsed
from plogic.facts.situation import Reading, stopped_in
from plogic.scene.readings.unfinished import marks
from plogic.sequence.document import Panorama
from plogic.sequence.next_view.expected import Body, Cloud, Prospect

SLACK = 0.004
"""Share of a body's diameter that the surface must be met before a feature to hide it, as where it was perceived."""


def prospect_of(
    document: "Interpretation | LastView", worlds: Sequence[tuple[float, Sequence[str]]] | None = None
) -> Prospect:
    """The prospect of an ``interpretation/1``, in the present camera's frame.

    ``worlds``, (probability, present), in place of those that it lists.

    The probabilities of what is listed are scaled to sum to 1. Raises InterpretationError where it is an old one, or
    broken.
    """
    lacking = [key for key in USED if key not in document]
    if lacking:
        raise InterpretationError(f"{', '.join(lacking)}: is missing; if it is an older one, perceive again")
    try:
        listed = [(float(w["probability"]), w["present"]) for w in document["worlds"]] if worlds is None else worlds
        return _prospect(document, listed)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, GeometryError) as error:
        what = f"the key {error} is missing" if isinstance(error, KeyError) else str(error)
        raise InterpretationError(f"types, sensing or assets: not complete: {what}") from error


def _prospect(document: "Interpretation | LastView", worlds: Sequence[tuple[float, Sequence[str]]]) -> Prospect:
    used = {name for _, members in worlds for name in members}
    rows = [h for h in document["hypotheses"] if h["id"] in used]
    clouds = {name: _cloud(name, document) for name in sorted({h["type"] for h in rows})}
    bodies = tuple(
        Body(h["id"], clouds[h["type"]], np.array(h["T_camera_object"], dtype=float), bool(h["opaque"])) for h in rows
    )
    place = {body.id: i for i, body in enumerate(bodies)}
    present = np.zeros((len(worlds), len(bodies)), bool)
    for w, (_, members) in enumerate(worlds):
        present[w, [place[name] for name in members]] = True
    mass = np.array([p for p, _ in worlds], dtype=float)
    sensing = document["sensing"]
    return Prospect(
        bodies,
        present,
        mass / mass.sum(),
        frozenset(frozenset(fact["args"]) for fact in document["facts"] if fact["fact"] == "rival"),
        {name: float(count) for name, count in sensing["clutter"].items()},
        float(sensing["match_tolerance"]),
        float(sensing["f_ref"]),
    )


def _cloud(name: str, document: "Interpretation | LastView") -> Cloud:
    table, mesh = document["types"][name], document["assets"].get("meshes", {}).get(name)
    at = np.array([row[2:5] for row in table["features"]], dtype=float).reshape(-1, 3)
    rays = None if mesh is None else RayMesh(np.array(mesh["vertices"], dtype=float), np.array(mesh["triangles"]))
    points = at if rays is None else rays.vertices
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0 if len(points) else np.zeros(3)
    radius = float(np.linalg.norm(points - middle, axis=1).max()) if len(points) else 0.0
    slack = 0.0 if rays is None or mesh is None else max(SLACK * rays.size, float(mesh.get("slack", 0.0)))
    lobes, hit = _lobes(table, at)
    names, kinds = (tuple(str(row[i]) for row in table["features"]) for i in (0, 1))
    return Cloud(name, names, kinds, lobes, hit, rays, middle, radius, slack, bool(table["measured"]))


def _lobes(table: TypeRow, at: Floats) -> tuple[LobeTable, Floats]:
    rows = np.array(table["lobes"], dtype=float).reshape(-1, 9)
    feature, look = rows[:, 0].astype(np.intp), rows[:, 1].astype(np.intp)
    axis = rows[:, 2:5] / np.linalg.norm(rows[:, 2:5], axis=1, keepdims=True)
    types = tuple(str(table["looks"][i]) for i in look.tolist())
    sizes = np.full(len(rows), np.nan)
    return LobeTable(
        feature, types, at[feature], axis, np.cos(rows[:, 5]), rows[:, 6], rows[:, 7], len(at), sizes
    ), rows[:, 8]


FORMAT = "panorama/1"
OLDER = "; if it is an older one, perceive the sequence again"
USED = ("camera", "sensing", "types", "assets")
"""Keys of a view's interpretation that looking ahead reads."""


class PosedRow(TypedDict):
    """One hypothesis from where the last view stood."""

    id: str
    type: str
    opaque: bool
    T_camera_object: Pose


class LastView(Marks):
    """The keys of an interpretation that looking ahead reads, of a sequence.

    ``plogic query`` cannot ask it, so it has no ``format``.
    """

    reading: Reading
    camera: CameraRow
    sensing: SensingRow
    types: dict[str, TypeRow]
    assets: AssetsRow
    hypotheses: list[PosedRow]
    worlds: list[WorldRow]
    unlisted_mass: Interval
    facts: list[PairRow]


def read_looked(path: Path | str) -> Interpretation | LastView:
    """An ``interpretation/1``, or of a ``panorama/1`` what stands for one; '-' is stdin.

    Raises InterpretationError, a line a mistake.
    """
    document = parsed(path)
    if not isinstance(document.data, dict) or document.data.get("format") != FORMAT:
        return interpretation_in(document, f"{{}} or {FORMAT!r}")
    wrong = document.told(document.against(Panorama))
    if wrong:
        raise InterpretationError(*(f"{line}{OLDER if 'is missing: ' in line else ''}" for line in wrong))
    try:
        return of_last_view(cast("Panorama", document.data))
    except ValueError as error:
        raise InterpretationError(f"{document.name}: {error}") from error


def of_last_view(panorama: Panorama) -> LastView:
    """The sequence's hypotheses and worlds from where its last view stood.

    How types are seen, from the views' interpretations.

    Raises ValueError where there is no view, a view's interpretation is too old, or a pose is not rigid.
    """
    if not panorama["views"]:
        raise ValueError("views: there is none")
    views = [view["interpretation"] for view in panorama["views"]]
    _complete(views, panorama)
    camera_from_world = inverse(_pose(panorama["views"][-1]["T_world_camera"], "views: T_world_camera"))
    meshes = {name: mesh for view in views for name, mesh in view["assets"].get("meshes", {}).items()}
    return {
        "reading": views[-1]["reading"],
        "camera": views[-1]["camera"],
        "sensing": views[-1]["sensing"],
        "types": {name: table for view in views for name, table in view["types"].items()},
        "assets": {**views[-1]["assets"], "meshes": meshes},
        "hypotheses": [
            {
                "id": row["id"],
                "type": row["type"],
                "opaque": row["opaque"],
                "T_camera_object": (camera_from_world @ _pose(row["T_world_object"], row["id"])).tolist(),
            }
            for row in panorama["hypotheses"]
        ],
        "worlds": panorama["worlds"],
        "unlisted_mass": panorama["unlisted_mass"],
        "facts": [{"fact": "rival", "args": pair} for pair in panorama["rivals"]],
        **marks(stopped_in(panorama)),
    }


def _complete(views: list[Interpretation], panorama: Panorama) -> None:
    """Raise ValueError where a name is no hypothesis', or a view lacks a key that looking ahead reads."""
    named = {name for world in panorama["worlds"] for name in world["present"]}
    named |= {name for pair in panorama["rivals"] for name in pair}
    strange = sorted(named - {row["id"] for row in panorama["hypotheses"]})
    if strange:
        raise ValueError(f"worlds, rivals: {', '.join(strange[:5])} should be among the hypotheses")
    lacking = [f"views.{i}.interpretation.{key}" for i, view in enumerate(views) for key in USED if key not in view]
    if lacking:
        raise ValueError(f"{', '.join(lacking[:5])}: is missing{OLDER}")


def _pose(rows: object, where: str) -> Floats:
    pose = np.array(rows, dtype=float)
    if pose.shape != (4, 4) or not is_rigid(pose):
        raise ValueError(f"{where}: should be a rigid 4 x 4 transform")
    return pose
