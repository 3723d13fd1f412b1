"""What an interpretation leaves open, as a prospect: its worlds, and how the types in them are seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.errors import GeometryError
from geometry.visibility.rays import RayMesh
from kb.clouds.lobes import LobeTable
from plogic.base.errors import InterpretationError
from plogic.sequence.next_view.prospect import Body, Cloud, Prospect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.facts.document import Interpretation, TypeRow
    from plogic.sequence.next_view.of_sequence import LastView

    Looked = Interpretation | LastView

SLACK = 0.004
"""Share of a body's diameter that the surface must be met before a feature to hide it, as where it was perceived."""
AGAIN = "says nothing of how its types are seen, as older ones do: perceive again (`plogic perceive`)"


def prospect_of(document: Looked, worlds: Sequence[tuple[float, Sequence[str]]] | None = None) -> Prospect:
    """The prospect of an ``interpretation/1``, in the present camera's frame; ``worlds``, (probability, present), in place of those that it lists.

    The probabilities of what is listed are scaled to sum to 1. Raises InterpretationError where it is an old one, or
    broken.
    """
    if "types" not in document or "sensing" not in document:
        raise InterpretationError(AGAIN)
    try:
        listed = [(float(w["probability"]), w["present"]) for w in document["worlds"]] if worlds is None else worlds
        return _prospect(document, listed)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, GeometryError) as error:
        what = f"the key {error} is missing" if isinstance(error, KeyError) else str(error)
        raise InterpretationError(f"types, sensing or assets: not complete: {what}") from error


def _prospect(document: Looked, worlds: Sequence[tuple[float, Sequence[str]]]) -> Prospect:
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


def _cloud(name: str, document: Looked) -> Cloud:
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


def _lobes(table: TypeRow, at: NDArray[np.float64]) -> tuple[LobeTable, NDArray[np.float64]]:
    rows = np.array(table["lobes"], dtype=float).reshape(-1, 9)
    feature, look = rows[:, 0].astype(np.intp), rows[:, 1].astype(np.intp)
    axis = rows[:, 2:5] / np.linalg.norm(rows[:, 2:5], axis=1, keepdims=True)
    types = tuple(str(table["looks"][i]) for i in look.tolist())
    sizes = np.full(len(rows), np.nan)
    return LobeTable(
        feature, types, at[feature], axis, np.cos(rows[:, 5]), rows[:, 6], rows[:, 7], len(at), sizes
    ), rows[:, 8]
