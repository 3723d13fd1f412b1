"""Parts of a ``panorama/1`` that says no more than it must."""

from __future__ import annotations

from typing import Any

EMPTY: dict[str, Any] = {
    "format": "panorama/1",
    "kb": {"name": "none", "digest": ""},
    "reading": "score",
    "objects": [],
    "hypotheses": [],
    "rivals": [],
    "worlds": [],
    "unlisted_mass": [0.0, 0.0],
    "views": [],
}
"""A panorama of no view."""
NOTHING_ELSE: dict[str, Any] = {"predicted": [], "gone": [], "unexplained": []}
"""Of a view beside its interpretation."""


def interpretation_of(camera: dict[str, Any], appearances: list[dict[str, Any]]) -> dict[str, Any]:
    """An interpretation without a hypothesis."""
    return {
        "format": "interpretation/1",
        "reading": "score",
        "reconsider": "to_B",
        "smoothing": 0.0,
        "camera": camera,
        "appearances": [{**a, "clutter": 0.0} for a in appearances],
        "hypotheses": [],
        "facts": [],
        "measures": {"dv": {}, "rank": {}},
        "priors": {},
        "rules": "",
    }
