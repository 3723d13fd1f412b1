"""``panorama/1`` as what looking ahead reads: the worlds of all views, told from where the last one stood.

What may be there is told by the sequence; how a type is seen, by the interpretation of any view that had it in Δh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict, cast

import numpy as np

from geometry.frames import inverse, is_rigid
from plogic.base.errors import InterpretationError
from plogic.base.shapes import mistakes
from plogic.facts.document import Marks
from plogic.facts.interpretation import interpretation_in, parsed
from plogic.facts.stopped import stopped_in
from plogic.scene.readings.unfinished import marks
from plogic.sequence.document import Panorama

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from plogic.facts.document import AssetsRow, CameraRow, Interpretation, SensingRow, TypeRow, WorldRow
    from plogic.facts.fact_rows import Interval, PairRow, Pose
    from plogic.facts.situation import Reading

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
    """The keys of an interpretation that looking ahead reads, of a sequence; ``plogic query`` cannot ask it, so it has no ``format``."""

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
    """An ``interpretation/1``, or of a ``panorama/1`` what stands for one; '-' is stdin. Raises InterpretationError, a line a mistake."""
    name = "<stdin>" if str(path) == "-" else str(path)
    document = parsed(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        return interpretation_in(document, name, f"{{}} or {FORMAT!r}")
    wrong = mistakes(document, Panorama)
    if wrong:
        raise InterpretationError(*(f"{name}: {line}{OLDER if line.endswith('is missing') else ''}" for line in wrong))
    try:
        return of_last_view(cast("Panorama", document))
    except ValueError as error:
        raise InterpretationError(f"{name}: {error}") from error


def of_last_view(panorama: Panorama) -> LastView:
    """The sequence's hypotheses and worlds from where its last view stood; how types are seen, from the views' interpretations.

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


def _pose(rows: object, where: str) -> NDArray[np.float64]:
    pose = np.array(rows, dtype=float)
    if pose.shape != (4, 4) or not is_rigid(pose):
        raise ValueError(f"{where}: should be a rigid 4 x 4 transform")
    return pose
