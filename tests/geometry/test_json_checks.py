"""Documents against their shapes.

Each mistake with its place, all of them at once, and the verdict that JSON Schema comes to.
"""

import copy
from typing import Annotated, Literal, NotRequired, TypedDict

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from situations import towers
from spoilt_documents import spoilt

from geometry.files.json_schema import schema_of
from geometry.json_checks import mistakes
from geometry.json_shapes import Lengths, Range, Row, Rule, Size
from plogic.facts.document import Interpretation
from plogic.facts.interpretation import FORMAT, facts_of, hypothesis_document


class Part(TypedDict):
    """A leaf."""

    kind: Literal["part"]
    name: Annotated[str, Size(1, 3)]


class Whole(TypedDict):
    """A node."""

    kind: Literal["whole"]
    parts: list[Part]


class Sheet(TypedDict):
    """One of each."""

    nodes: list[Part | Whole]
    share: Annotated[float, Range(0.0, 1.0)]
    count: int
    flag: bool
    row: Annotated[list[str | float], Row(str, float)]
    table: NotRequired[dict[str, float | None]]
    above: NotRequired[Annotated[float | None, Range(0.0, open_low=True), "More than nothing."]]
    some: NotRequired[Annotated[list[float], Lengths(0, 4)]]
    pose: NotRequired[Annotated[list[list[float]], Size(2), Rule("should be two lists")]]
    more: NotRequired[Annotated[Part, "A leaf."]]


GOOD = {
    "nodes": [{"kind": "part", "name": "a"}, {"kind": "whole", "parts": [{"kind": "part", "name": "b"}]}],
    "share": 1,
    "count": 3,
    "flag": False,
    "row": ["x", 1.5],
    "table": {"a": None, "b": 2.0},
}


def test_a_right_one_has_no_mistake():
    assert mistakes(GOOD, Sheet) == []


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda d: d.pop("count"), "count: is missing: should be a whole number"),
        (
            lambda d: d.update(less=1),
            "less: unknown key; known are nodes, share, count, flag, row, table, above, some, pose, more",
        ),
        (lambda d: d.update(above=0), "above: 0 is not a number above 0.0"),
        (lambda d: d.update(some=[1]), "some: a list of 1, and not of 0 or 4"),
        (lambda d: d.update(pose=[[1], ["x"]]), "pose: should be two lists, not [[1], ['x']]"),
        (lambda d: d.update(more=3), "more: 3 is no object with the keys kind, name"),
        (lambda d: d.update(share=1.5), "share: 1.5 is not a number from 0.0 to 1.0"),
        (lambda d: d.update(share=True), "share: True is not a number from 0.0 to 1.0"),
        (lambda d: d.update(share=float("nan")), "share: nan is not a number from 0.0 to 1.0"),
        (lambda d: d.update(count=3.0), "count: 3.0 is not a whole number"),
        (lambda d: d.update(count=10**400), None),
        (lambda d: d.update(flag=0), "flag: 0 is neither true nor false"),
        (lambda d: d.update(row=["x"]), "row: ['x'] is no list of 2"),
        (lambda d: d.update(row=[1.0, 2.0]), "row.0: 1.0 is no text"),
        (lambda d: d["table"].update(c=float("inf")), "table.c: inf is not a number"),
        (lambda d: d["nodes"][0].update(name=""), "nodes.0.name: a text of 0 characters, and not of 1 to 3"),
        (lambda d: d["nodes"][1]["parts"][0].update(kind="whole"), "nodes.1.parts.0.kind: 'whole' should be 'part'"),
        (lambda d: d["nodes"][0].update(kind="hole"), "nodes.0.kind: 'hole' should be one of part, whole"),
        (lambda d: d["nodes"][0].pop("kind"), "nodes.0.kind: is missing: should be one of part, whole"),
        (lambda d: d.update(nodes={}), "nodes: {} is no list"),
    ],
)
def test_a_mistake_is_told_with_its_place(spoil, said):
    document = copy.deepcopy(GOOD)
    spoil(document)
    (line,) = mistakes(document, Sheet)
    assert len(line) < 200
    assert said is None or line == said


def test_all_mistakes_are_told_at_once():
    document = copy.deepcopy(GOOD) | {"share": -1, "count": "x"}
    document["nodes"][1]["parts"] = [{"kind": "part"}, {"kind": "part", "name": 7, "age": 1}]
    assert mistakes(document, Sheet) == [
        "nodes.1.parts.0.name: is missing: should be a text",
        "nodes.1.parts.1.name: 7 is no text",
        "nodes.1.parts.1.age: unknown key; known are kind, name",
        "share: -1 is not a number from 0.0 to 1.0",
        "count: 'x' is not a whole number",
    ]


def interpretation():
    """The two towers of §8 as a document."""
    some = towers()
    rows = [hypothesis_document(h, {f.id: (True, True, None) for f in h.features}) for h in some.hypotheses]
    return {
        "format": FORMAT,
        "reading": some.reading,
        "reconsider": some.reconsider,
        "smoothing": some.smoothing,
        "hypotheses": [{**row, "status": "accepted"} for row in rows],
        "appearances": [{"id": a.id, "type": a.type, "uv": list(a.uv), "clutter": a.clutter} for a in some.appearances],
        "facts": facts_of(some),
        "priors": some.priors,
        "measures": {"dv": some.dv, "rank": some.rank},
        "rules": some.rules,
    }


def test_the_schema_comes_to_the_same_verdict():
    """500 documents, each with one change: refused by jsonschema and by our check, or by neither."""
    validator, rng, whole = (
        Draft202012Validator(schema_of(Interpretation, "")),
        np.random.default_rng(5),
        interpretation(),
    )
    verdicts = []
    for _ in range(500):
        document = spoilt(whole, rng)
        other = validator.is_valid(document)
        mine = mistakes(document, Interpretation)
        assert (not mine) == other, mine
        verdicts.append(other)
    assert mistakes(whole, Interpretation) == []
    assert 20 < sum(verdicts) < 300


@pytest.mark.parametrize(
    ("count", "right"), [(2**53, True), (2**53 + 1, False), (-(2**53), True), (-(2**53) - 1, False)]
)
def test_whole_numbers_end_at_the_same_for_the_schema(count, right):
    document = copy.deepcopy(GOOD) | {"count": count}
    assert Draft202012Validator(schema_of(Sheet, "")).is_valid(document) == right
    said = "" if right else f"count: {count} is a whole number beyond {2**53}"
    assert "".join(mistakes(document, Sheet)) == said
