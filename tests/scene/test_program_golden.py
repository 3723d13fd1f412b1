"""The program text itself: golden files, determinism, and the stock command line.

After a wanted change: ``PLOGIC_GOLDEN=write python -m pytest tests/scene/test_program_golden.py``.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from situations import feature, hypothesis, plane, situation

from plogic.base.errors import SituationError
from plogic.facts.hypothesis import PartFact
from plogic.facts.situation import AppearanceFact, LookFact, PairFact, TypeFact
from plogic.facts.spatial import BodyFact, SharedFact, Space
from plogic.facts.stances import Stance, Support
from plogic.scene.text.program_text import left_out, program_text, query_lines
from plogic.scene.worlds.ranked_worlds import ranked_worlds

GOLDEN = Path(__file__).parent / "golden"


def small(reading="score", mode="to_B"):
    """Every kind of line once: names in quotes and an atom, a look, a facet, a weight of its own, occlusion, rivals."""
    front = hypothesis(
        "h1",
        [
            feature("roof/apex", type="apex", dv=0.99, match="a1"),
            feature("corner", match="a2"),
            feature("patch", "C", type="patch", dv=0.15),
        ],
        parts=(PartFact("roof", "", "object", "roof"),),
    )
    back = hypothesis(
        "h2",
        [
            feature("corner", match="a2", residual=0.9),
            feature("patch", "C", type="patch", dv=0.15, hidden_by=("h1",)),
            feature("rim", "D", match="a3", dv=0.75),
        ],
    )
    rival = hypothesis("h3", [feature("corner", match="a4", self_hidden=True)], group="g_h2", opaque=False)
    nowhere = hypothesis("h4", [feature("corner", "B", in_image=False)], type="Grand Hall")
    pair = frozenset({("h2", "h3")})
    lobe = ((0.0, 0.6, 0.8), 1.2, 0.5, 30.0)
    cup = TypeFact((("rim", "corner"),), looks=(LookFact("rim", "l_junction", *lobe),), opaque=False)
    made = situation(
        [front, back, rival, nowhere],
        reading,
        mode,
        dv={"apex": 0.99, "corner": 0.5, "patch": 0.15},
        types={
            "box": TypeFact(looks=(LookFact("corner", "l_junction", *lobe),), facets=(("corner",) * 3,)),
            "cup": cup,
        },
        overlaps=pair,
        rivals=pair,
        relations=(
            PairFact("partially_occludes", "h1", "h2", "partially_occludes_po"),
            PairFact("non_occludes", "h1", "h4"),
        ),
        part_relations=(PairFact("totally_occludes", "h2", "h1", "totally_occludes_tppi", ("", "roof")),),
    )
    return replace(
        made,
        appearances=(*made.appearances, AppearanceFact("a9", "patch", (9.0, 9.0), 1e-5)),
        space=Space(
            (0.0, -1.0, 0.0),
            "T_world_camera",
            bodies=(
                BodyFact("h1", (0.1, -0.2, 4.5), 4.1, "inside"),
                BodyFact("h2", (0.0, 0.3, 5.0), 4.6, "cut"),
                BodyFact("h3", (0.0, 0.3, 5.0), 4.7, "outside"),
            ),
            gaps=(("h1", "h2", 0.0012), ("h1", "h3", 0.4)),
            above=(("h1", "h2"), ("h1", "h3")),
            on=(("h1", "h2"),),
            on_both=(("h1", "h3", "h4"),),
            shared=(SharedFact("h2", "h3", 2.1e-5, (0.012, 0.0125)),),
        ),
        rules="tall(H) :- feature(H, 'roof/apex', apex).",
    )


def cyclic():
    ring = [
        hypothesis(f"h{i}", [feature("x", match=f"a{i}"), feature("y", "C", hidden_by=(f"h{3 - i}",))]) for i in (1, 2)
    ]
    return situation(ring, smoothing=0.01)


def standing():
    """Two on a table, the one on the other or not, and another plane."""
    bodies = [hypothesis(name, [feature("x", match=f"a_{name}"), feature("y", "C")]) for name in ("h1", "h2")]
    tilted = replace(plane("s1", 0.6), normal=(0.0, -0.8, -0.6), offset=-1.25)
    stances = Stance("h1", "s1", 2, 0.9, 3.5), Stance("h2", "s1", 0, 0.45, -8.0), Stance("h2", "h1", 0, 0.45, 4.0)
    return situation(
        bodies,
        "posterior",
        support=Support(0.9, 0.05, (tilted, plane("s2", 0.3)), stances, (("h2", 0.12),), (("h2", "s1", 1.5),)),
    )


SUBJECTS = {
    "score_to_b.pl": small(),
    "score_drop.pl": small(mode="drop"),
    "score_reassign.pl": small(mode="reassign"),
    "posterior.pl": small("posterior"),
    "cyclic_smoothed.pl": cyclic(),
    "standing.pl": standing(),
    "standing_score.pl": replace(standing(), reading="score"),
}


@pytest.mark.parametrize("name", SUBJECTS)
def test_text_is_the_golden_text(name):
    text = program_text(SUBJECTS[name])
    if os.environ.get("PLOGIC_GOLDEN") == "write":
        (GOLDEN / name).write_text(text, encoding="utf-8")
    assert text == (GOLDEN / name).read_text(encoding="utf-8")
    assert text == program_text(SUBJECTS[name])


@pytest.mark.parametrize("name", SUBJECTS)
def test_stock_command_line_prints_the_same_numbers(name, tmp_path):
    subject = SUBJECTS[name]
    (tmp_path / "p.pl").write_text(program_text(subject) + query_lines(subject), encoding="utf-8")
    command = [sys.executable, "-W", "ignore", "-c", "from problog.tasks import main; main(['p.pl'])"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True, timeout=60)
    printed = dict(line.strip().split(":\t") for line in done.stdout.splitlines() if line.strip())
    marginals = ranked_worlds(subject).marginals
    assert len(printed) == len(marginals) > 0
    for name_of, p in marginals.items():
        assert float(printed[f"present({name_of})"]) == pytest.approx(p, rel=1e-6, abs=1e-9)


def test_at_most_six_occluders_are_looked_at_and_the_rest_is_said():
    others = [hypothesis(f"g{i}", [feature("x", match=f"b{i}"), feature("y", "C")]) for i in range(8)]
    hidden = [feature(f"c{i}", "C", hidden_by=tuple(f"g{j}" for j in range(i + 1))) for i in range(8)]
    subject = situation([hypothesis("h1", [feature("x"), *hidden]), *others], mode="drop")
    assert left_out(subject) == {"h1": ("g6", "g7")}
    assert "% h1: not in these contexts: g6, g7" in program_text(subject)
    assert program_text(subject).count("\ncells(h1, ") == 2**6


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"overlaps": frozenset({("h1", "h9")})}, "overlaps: 'h9' is unknown"),
        ({"smoothing": float("nan")}, "smoothing: nan"),
        ({"appearances": ()}, "match: 'a1' is unknown"),
        ({"hypotheses": (hypothesis("h1", []), hypothesis("h1", []))}, "hypothesis 'h1' occurs twice"),
    ],
)
def test_a_situation_that_contradicts_itself_is_refused(change, message):
    with pytest.raises(SituationError, match=message):
        program_text(replace(small(), **change))
