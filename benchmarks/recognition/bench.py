"""``plogic bench recognition``.

Ten types learned from their meshes, found in rendered table-top scenes, beside a SIFT and RANSAC peer.

Vocabulary: a ``Case`` is one picture with its truth; an ``Answer`` is what both sides made of it.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from benchmarks.recognition.kb import ours as learned_ours
from benchmarks.recognition.peer import SEEN, Peer
from benchmarks.recognition.scenes import cases, ycb_meshes
from benchmarks.recognition.table import CAPTION, claims, judged, peer_said, rows
from benchmarks.shared.claims import report

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from benchmarks.recognition.kb import Ours
    from benchmarks.recognition.peer import Candidates
    from benchmarks.recognition.scenes import Case
    from benchmarks.recognition.score import Found
    from sensing.simulated.body import TexturedMesh


@dataclass(frozen=True, eq=False)
class Answer:
    """One case: our answer and its seconds, the peer's at every setting, and its seconds of one setting by input."""

    case: Case
    found: tuple[Found, ...]
    seconds: float
    peer: Candidates
    peer_seconds: dict[str, float]


def run(
    *,
    seed: int,
    limit: float,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    learn: Callable[[Mapping[str, Path], Path, Callable[[str], None]], Ours] = learned_ours,
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a picture on ``say``.

    ``limit``: seconds that the peer may take a picture, all settings together.

    Raises:
        InputError: The meshes are not there, or cannot be learned.
    """
    from sensing.simulated.body import read_mesh

    meshes = ycb_meshes()
    with tempfile.TemporaryDirectory(prefix="plogic-recognition-") as folder:
        mine = learn(meshes, Path(folder) / "kb", say)
        shapes = [(name, read_mesh(mesh)) for name, mesh in meshes.items()]
        answers = answered(mine, shapes, Path(folder) / "scenes", seed=seed, limit=limit, quick=quick, say=say)
    return judgement(answers, as_json=as_json)


def answered(
    mine: Ours,
    shapes: Sequence[tuple[str, TexturedMesh]],
    folder: Path,
    *,
    seed: int,
    limit: float,
    quick: bool,
    say: Callable[[str], None],
) -> list[Answer]:
    """Both sides on every picture, each read back from its file."""
    peer = Peer(mine.learned, SEEN if quick else SEEN[:1])  # with points along edges too a picture takes half a minute
    answers = []
    for case in cases(shapes, folder, seed, quick=quick):
        answers.append(answer(mine, peer, case, limit))
        say(_said(answers[-1]))
    return answers


def answer(mine: Ours, peer: Peer, case: Case, limit: float) -> Answer:
    """Ours first, then the peer, on the same pixels."""
    from sensing.files.images import read_image

    image = read_image(case.image)
    start = perf_counter()
    found = tuple(mine.recognise(image, case.camera))
    seconds = perf_counter() - start
    return Answer(case, found, seconds, *peer.candidates(image, case.camera, limit))


def judgement(answers: Sequence[Answer], *, as_json: bool) -> tuple[str, bool]:
    """The tables or the document, and whether every claim was met."""
    verdict = judged(answers)
    text, met = report("recognition", rows(verdict), claims(verdict), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n{peer_said(verdict)}\n\n{text}"), met


def _said(a: Answer) -> str:
    there = ", ".join(f"{t.type} {t.fraction:.0%}" for t in a.case.truths) or "none of the types"
    found = ", ".join(f.type for f in a.found) or "nothing"
    return f"scene {a.case.seed} (hard {a.case.hard:g}): {there}; found {found} in {a.seconds:.1f} s"
