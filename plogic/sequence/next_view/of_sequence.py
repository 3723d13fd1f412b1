"""``panorama/1`` as what looking ahead reads: the worlds of all views, told from where the last one stood.

What may be there is told by the sequence; how a type is seen, by the interpretation of any view that had it in Δh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import inverse, is_rigid
from plogic.base.errors import InterpretationError
from plogic.facts.interpretation import interpretation_in, parsed
from plogic.facts.stopped import stopped_in
from plogic.scene.readings.unfinished import marks

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from plogic.facts.interpretation import Document

FORMAT = "panorama/1"
USED = ("camera", "sensing", "types", "assets", "reading")


def read_looked(path: Path | str) -> Document:
    """An ``interpretation/1``, or of a ``panorama/1`` what stands for one; '-' is stdin. Raises InterpretationError, one line."""
    name = "<stdin>" if str(path) == "-" else str(path)
    document = parsed(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        return interpretation_in(document, name, f"{{}} or {FORMAT!r}")
    try:
        return of_last_view(document)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        what = (
            f"the key {error} is missing; if it is an older one, perceive the sequence again"
            if isinstance(error, KeyError)
            else str(error)
        )
        raise InterpretationError(f"{name}: not a complete {FORMAT}: {what}") from error


def of_last_view(panorama: Mapping[str, Any]) -> Document:
    """``hypotheses`` with ``T_camera_object``, ``worlds``, ``unlisted_mass`` and rivals among ``facts``; ``USED`` of the views' interpretations.

    It has no ``format``, for it is nothing that ``plogic query`` could be asked of: nothing is said of features. Raises
    ValueError where there is no view, or a pose is not rigid; KeyError, TypeError and the like where it is broken.
    """
    if not panorama["views"]:
        raise ValueError("views: there is none")
    views = [view["interpretation"] for view in panorama["views"]]
    camera_from_world = inverse(_pose(panorama["views"][-1]["T_world_camera"], "views: T_world_camera"))
    meshes = {name: mesh for view in views for name, mesh in view["assets"].get("meshes", {}).items()}
    named = {name for world in panorama["worlds"] for name in world["present"]} | {
        name for pair in panorama["rivals"] for name in pair
    }
    strange = sorted(named - {row["id"] for row in panorama["hypotheses"]})
    if strange:
        raise ValueError(f"worlds, rivals: {', '.join(strange[:5])} should be among the hypotheses")
    return {
        **{key: views[-1][key] for key in USED},
        "types": {name: table for view in views for name, table in view["types"].items()},
        "assets": {**views[-1]["assets"], "meshes": meshes},
        "hypotheses": [
            row | {"T_camera_object": camera_from_world @ _pose(row["T_world_object"], row["id"])}
            for row in panorama["hypotheses"]
        ],
        "worlds": panorama["worlds"],
        "unlisted_mass": panorama["unlisted_mass"],
        "facts": [{"fact": "rival", "args": pair} for pair in panorama["rivals"]],
        **marks(stopped_in(panorama)),
    }


def _pose(rows: object, where: str) -> NDArray[np.float64]:
    pose = np.array(rows, dtype=float)
    if pose.shape != (4, 4) or not is_rigid(pose):
        raise ValueError(f"{where}: should be a rigid 4 x 4 transform")
    return pose
