"""docs/occlusion.md and its composition table are what the code finds."""

from pathlib import Path

import pytest

from benchmarks.occlusion.neighbours import neighbours
from benchmarks.occlusion.page import LINES_FILE, WITHHELD, lines, page
from benchmarks.occlusion.tables import composition, counts_table, relations_table, sign
from geometry.visibility.composition import possible_triples
from geometry.visibility.occlusion import TOLERANCE
from geometry.visibility.roc import ROC20
from plogic.cycle.delta import MOST_PART_PAIRS

DOCS = Path(__file__).parents[3] / "docs"
HOW = "run `plogic bench occlusion --json > BENCH.json` and `python docs/generate.py --occlusion BENCH.json`"


@pytest.fixture(scope="module")
def text():
    return (DOCS / "occlusion.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def upper():
    return composition(possible_triples())


def documented(text):
    """The neighbours that the page names."""
    named = [line for line in text.splitlines() if line.startswith(("| `non_", "| `par", "| `tot", "| `mut"))]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in named]
    return {(sign_of.strip("`"), near.strip("`")) for _, sign_of, *_, beside in rows for near in beside.split()}


def test_the_composition_table_is_the_codes_and_all_of_it_is_proved(text, upper):
    assert (DOCS / LINES_FILE).read_text(encoding="utf-8") == lines(upper, upper), HOW
    assert "\n".join(counts_table(upper, upper)) in text, HOW
    assert "Of the 400 entries 400 are proved" in text


def test_quickly_found_neighbours_are_on_the_page(text):
    quick = {(sign(a), sign(b)) for a, b in neighbours(3, 0, ("nested", "touching"))}
    known = documented(text)
    assert len(quick) >= 6
    assert quick <= known, HOW
    assert {(b, a) for a, b in known} == known
    assert {a for a, _ in known} == {sign(r) for r in ROC20}


def test_the_figures_in_the_text_are_the_codes(text):
    flat = " ".join(text.split())
    assert f"t = {TOLERANCE:g} px" in flat
    assert f"At most {MOST_PART_PAIRS} pairs with parts" in flat


def test_the_page_is_made_of_what_the_benchmark_said(upper):
    rows = [
        {"table": "pairs", "kind": "convex", "pairs": 7},
        {"table": "relations", "sign": "dc", "pairs": 7, "neighbours": "ec"},
        {"table": "composition", "built": 3, "built wrong": 0},
        *({"table": name, "told": name} for name in WITHHELD),
    ]
    less = {pair: some - {"mutually_occludes_po"} for pair, some in upper.items()}
    made = page({"rows": rows, "claims": [{"claim": "c", "met": True}]}, less, upper, 2, 5)
    assert "| convex | 7 |" in made
    assert all(f"| {name} |" in made for name in WITHHELD)
    assert "bisecting 5 motions of each of 2 kinds" in made
    assert "3 of them asked for their relations, none otherwise" in " ".join(made.split())
    assert "+ |" in made
    assert relations_table([("non_occludes_dc", "non_occludes_ec")])[2] in made
