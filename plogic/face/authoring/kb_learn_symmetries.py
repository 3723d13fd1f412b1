"""What ``plogic kb learn`` says of a type's symmetries: which turns of its shape its texture keeps, told, and written where nobody has yet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType
    from kb.clouds.learned import LearnedCloud
    from kb.learning.observations import Observations
    from kb.learning.symmetry_trials import Trial
    from sensing.detectors.keypoints import Keypoints

KEPT = "symmetries: as object.yaml states them"


def symmetries_of(
    kind: ObjectType, cloud: LearnedCloud, options: Mapping[str, Any], say: Callable[[str], None]
) -> list[Trial]:
    """A trial for each turn of the type's shape; new pictures of it are taken where the cloud alone does not rule all of them out."""
    from geometry.cones import even_directions
    from kb.learning.symmetry_trials import DIRECTIONS, judged, trials

    if kind.surface is None:
        return []
    cloud = cloud.keypoints
    groups, directions = trials(cloud, kind.surface), even_directions(DIRECTIONS)
    if not any(trial.likely for group in groups for trial in group):
        return judged(groups, cloud, None, directions)
    say(f"{kind.name}: {DIRECTIONS} new pictures, for its symmetries")
    return judged(groups, cloud, _new_pictures(kind, options, directions), directions)


def _new_pictures(kind: ObjectType, options: Mapping[str, Any], directions: NDArray[np.float64]) -> Observations:
    """What the detector sees from directions that the cloud was not learned from, with other noise."""
    import cv2

    from kb.learning.observations import joined, observed
    from kb.learning.views import AWAY, MARGIN, PIXELS
    from sensing.detectors.keypoint_detector import described
    from sensing.simulated.meshes import read_mesh
    from sensing.simulated.turntable import turned

    assert kind.mesh_file is not None  # noqa: S101 - it was learned from it
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)

    def detect(image: NDArray[np.uint8], calm: NDArray[np.uint8], cell: int) -> Keypoints:
        return described(image, options["detector"], cell=cell, calm=calm)

    views = turned(read_mesh(kind.mesh_file, kind.mesh_scale), list(directions), PIXELS[0], MARGIN, AWAY)
    try:
        return joined([observed(view, number, detect, options["seed"] + 1) for number, view in enumerate(views)])
    finally:
        cv2.setNumThreads(threads)


def stated(file: Path) -> bool:
    """Whether an object.yaml says what the symmetries are, be it that there are none."""
    from kb.files.yaml_text import load

    data = load(str(file), file.read_bytes()).data
    return isinstance(data, dict) and "symmetries" in data


def written(files: dict[Path, bytes], found: Mapping[Path, Sequence[Trial]]) -> dict[Path, bytes]:
    """The files of a KB with the symmetries that hold in each ``object.yaml`` of ``found``.

    Raises:
        InputError: a YAML file is written so that no line can be added; with what to write into it.
    """
    from kb.learning.symmetry_trials import entries
    from plogic.face.authoring.kb_learn_lines import with_entry

    more = {}
    for file, tried in found.items():
        listed = entries(tried)
        if listed:
            content = files[file] if file in files else file.read_bytes()
            more[file] = with_entry(file, content, "symmetries", listed)
    return files | more


def symmetry_rows(tried: Sequence[Trial]) -> list[dict[str, Any]]:
    """For programs: ``share`` and ``control`` of the cloud alone, ``ratio`` of what new pictures show of it turned and unturned."""
    return [
        {
            "turn": str(trial.turn),
            "verdict": trial.verdict,
            "share": round(trial.share, 3),
            "control": round(trial.control, 3),
            "ratio": None if trial.ratio is None else round(trial.ratio, 3),
        }
        for trial in tried
    ]


def symmetry_lines(name: str, rows: Sequence[Mapping[str, Any]] | None) -> list[str]:
    """For people, a line a turn; None where object.yaml states the symmetries."""
    if rows is None:
        return [f"{name}: {KEPT}"]
    if all(row["verdict"] == "broken" for row in rows):
        return [f"{name}: symmetries: none; its texture breaks {_turns(len(rows))} of its shape"] if rows else []
    return [f"{name}: {_line(row)}" for row in rows if row["verdict"] != "broken"]


def _turns(number: int) -> str:
    return "the one turn" if number == 1 else f"all {number} turns"


def _line(row: Mapping[str, Any]) -> str:
    shown = f"turned by it, new pictures show {row['ratio']:.0%} of what they show unturned"
    if row["verdict"] == "holds":
        return f"symmetry {row['turn']}: {shown}; written into object.yaml"
    return f"perhaps a symmetry, not written: {row['turn']}: {shown}"
