"""Documents against their shapes.

Each mistake with its place, all of them at once, and the verdict that pydantic comes to.
"""

import copy
from functools import reduce
from operator import or_
from types import UnionType
from typing import Annotated, Any, Literal, NotRequired, TypedDict, get_args, get_origin, get_type_hints, is_typeddict

import numpy as np
import pytest
from pydantic import ConfigDict, Field, ValidationError, create_model
from situations import towers

from plogic.base.shapes import Range, Row, Size, mistakes
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
        (lambda d: d.pop("count"), "count: is missing"),
        (lambda d: d.update(more=1), "more: unknown key"),
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
        (lambda d: d["nodes"][0].pop("kind"), "nodes.0.kind: is missing"),
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
        "nodes.1.parts.0.name: is missing",
        "nodes.1.parts.1.name: 7 is no text",
        "nodes.1.parts.1.age: unknown key",
        "share: -1 is not a number from 0.0 to 1.0",
        "count: 'x' is not a whole number",
    ]


def model_of(shape: Any) -> Any:
    """The pydantic type of a shape, which forbids what the shape does not name."""
    origin, args = get_origin(shape), get_args(shape)
    if origin is NotRequired:
        return model_of(args[0])
    if is_typeddict(shape):
        hints, required = get_type_hints(shape, include_extras=True), shape.__required_keys__
        fields = {key: (model_of(of), ... if key in required else None) for key, of in hints.items()}
        return create_model(shape.__name__, __config__=ConfigDict(extra="forbid", strict=True), **fields)
    if origin is Annotated:
        return bounded(*args)
    if origin is UnionType:
        return reduce(or_, map(model_of, args))
    if origin in (list, dict):
        shape = origin[tuple(map(model_of, args))]
    return number() if shape is float else shape


def bounded(of: Any, bound: Any) -> Any:
    """The pydantic type of a shape with its bound."""
    if isinstance(bound, Row):
        return Annotated[tuple[tuple(map(model_of, bound))], Field(strict=False)]
    if isinstance(bound, Size):
        least, most, _ = bound.ends()
        return Annotated[model_of(of), Field(min_length=least, max_length=most)]
    high = {} if bound.high == Range().high else {"le": bound.high}
    return Annotated[int, Field(ge=bound.low, **high)] if of is int else number(ge=bound.low, **high)


def number(**bounds: float) -> Any:
    return Annotated[float, Field(allow_inf_nan=False, **bounds)]


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


def spoilt(document: Any, rng: np.random.Generator) -> Any:
    """A copy in which one value, anywhere, is another, or is gone, or has a neighbour."""

    def one_of(some: Any) -> Any:
        return some[int(rng.integers(len(some)))]

    document = copy.deepcopy(document)
    at, key = document, one_of(sorted(document))
    while isinstance(at[key], (list, dict)) and at[key] and rng.random() < 0.85:
        at = at[key]
        key = one_of(sorted(at)) if isinstance(at, dict) else int(rng.integers(len(at)))
    what = one_of(["gone", "other", "neighbour"])
    if what == "neighbour" and isinstance(at, dict):
        at["strange"] = 1
    elif what == "gone" and isinstance(at, dict):
        del at[key]
    else:
        at[key] = one_of([None, True, 1, -1, 2.5, "text", "", [], {}, [1.0, 2.0], float("inf")])
    return document


def test_pydantic_comes_to_the_same_verdict():
    """500 documents, each with one change: refused by both or by neither."""
    model, rng, whole = model_of(Interpretation), np.random.default_rng(5), interpretation()
    verdicts = []
    for _ in range(500):
        document = spoilt(whole, rng)
        try:
            model.model_validate(document)
            other = True
        except ValidationError:
            other = False
        mine = mistakes(document, Interpretation)
        assert (not mine) == other, mine
        verdicts.append(other)
    assert mistakes(whole, Interpretation) == []
    assert 20 < sum(verdicts) < 300
