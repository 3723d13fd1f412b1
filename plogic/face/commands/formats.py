"""The formats of JSON files, each with the shape that its reader holds it to: what ``plogic schema`` prints.

* ``Format(GammaRow, "Γ: what was detected in one image")``: docs/formats.md is made of the same
"""

import json
from typing import Any, NamedTuple

from geometry.files.json_schema import schema_of


class Format(NamedTuple):
    """``shape``: what a document is held to. ``title``: what it is. ``used``: who writes and who reads it."""

    shape: Any
    title: str
    used: str


def formats() -> dict[str, Format]:
    """Every format by its name."""
    from geometry.camera_row import CameraRow
    from geometry.files.pose_files import MovesRow, PosesRow
    from plogic.facts.document import Interpretation, TruthRow
    from plogic.run.batch.frame_lines import FrameLine
    from plogic.run.health.findings import Health
    from plogic.scene.document import Answers
    from plogic.sequence.document import Panorama
    from sensing.files.gamma_files import GammaRow
    from sensing.files.stereo import StereoRow

    return {
        "gamma": Format(
            GammaRow,
            "Γ: what was detected in one image",
            "You write it, or your detectors do; `perceive`, `batch` and `kb measures --gamma` read it.",
        ),
        "camera": Format(
            CameraRow,
            "A camera",
            "`simulate` writes it; every `--camera` reads it, alone or as the key `camera` of another document; "
            "[other ways to tell a camera](cameras.md).",
        ),
        "poses": Format(
            PosesRow,
            "Where a moving camera stood",
            "`simulate --robot` writes it; `perceive --poses` and `next-view --moves` read it.",
        ),
        "moves": Format(
            MovesRow, "Where a camera may go", "You write it; `next-view --moves` and `simulate --robot` read it."
        ),
        "stereo": Format(StereoRow, "How a stereo pair is calibrated", "You write it; `perceive --stereo` reads it."),
        "truth": Format(
            TruthRow, "Where objects truly stand", "`simulate` writes it, or you do; `kb learn-rates` reads it."
        ),
        "interpretation": Format(
            Interpretation,
            "What one image shows",
            "`perceive` writes it, `watch` one a frame; `worlds`, `query`, `explain`, `shell`, `program`, `report`, `measures`, "
            "`next-view` and `settle` read it.",
        ),
        "panorama": Format(
            Panorama,
            "What several views of one place show",
            "`perceive` of several inputs writes it; `next-view` and `kb assimilate` read it.",
        ),
        "answers": Format(Answers, "The answers to a query", "`query --json` prints it."),
        "frame": Format(
            FrameLine,
            "One line of many frames",
            "`batch` writes such lines, and `batch --resume` goes on after them; `watch` does of bad frames, and with `--short`.",
        ),
        "doctor": Format(Health, "What is wrong with an installation", "`doctor --json` prints it."),
    }


def schema_command(name: str) -> str:
    """The JSON Schema of a format, draft 2020-12."""
    one = formats()[name]
    return json.dumps(schema_of(one.shape, one.title), indent=1, ensure_ascii=False)
