"""The tests themselves: each asserts something whatever its loops run over, and no file is longer than a thought.

A loop is sure to run where what it runs over is written out, or is a constant of the module that is. An assertion in
any other loop, and one that ``all`` of such things hold, may never be made: beside it something must be asserted that
is, for one that there is anything to loop over.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
FILES = sorted(TESTS.rglob("*.py"))
MOST_LINES = 400
SAME_ITEMS = {"sorted", "list", "tuple", "set", "frozenset", "dict", "enumerate", "reversed", "items", "keys", "values"}
"""Functions and methods of as many items as they are given."""
ENDLESS = {"count", "linspace", "arange", "permutations"}


def constants(body):
    """The expressions that a module's, or a function's, names are set to."""
    assigned = (node for node in body if isinstance(node, ast.Assign))
    return {t.id: node.value for node in assigned for t in node.targets if isinstance(t, ast.Name)}


def is_sure(node, names):
    """Whether there is something in what the expression gives, as far as its text shows."""
    sure = False
    match node:
        case ast.Tuple(elts=items) | ast.List(elts=items) | ast.Set(elts=items):
            sure = any(not isinstance(item, ast.Starred) or is_sure(item.value, names) for item in items)
        case ast.Dict(keys=keys):
            sure = bool(keys)
        case ast.Constant(value=str() | bytes() as text):
            sure = bool(text)
        case ast.Name(id=name):
            rest = {other: value for other, value in names.items() if other != name}
            sure = name in names and is_sure(names[name], rest)
        case ast.BinOp(left=left, right=right, op=ast.Add() | ast.Mult()):
            sure = is_sure(left, names) or is_sure(right, names)
        case ast.ListComp() | ast.SetComp() | ast.GeneratorExp() | ast.DictComp():
            sure = all(not part.ifs and is_sure(part.iter, names) for part in node.generators)
        case ast.Call():
            sure = call_is_sure(node, names)
    return sure


def call_is_sure(node, names):
    function, given = ast.unparse(node.func).split(".")[-1], list(node.args)
    if isinstance(node.func, ast.Attribute) and not given:
        given = [node.func.value]  # as KINDS of KINDS.items()
    if function in SAME_ITEMS:
        return bool(given) and is_sure(given[0], names)
    if function == "range":
        ends = [item.value if isinstance(item, ast.Constant) else 0 for item in given]
        return any(ends) and len(range(*ends[:2])) > 0
    if function in {"zip", "product"}:
        strict = any(keyword.arg == "strict" for keyword in node.keywords)
        return (any if strict else all)(is_sure(item, names) for item in given)
    return function in ENDLESS or function == "split"


def asserts(node, names):
    """Whether a statement asserts, by itself, something that can be false."""
    match node:
        case ast.Assert(test=ast.Call(func=ast.Name(id="all"), args=[ast.GeneratorExp() | ast.ListComp() as each])):
            return is_sure(each, names)
        case ast.Assert():
            return True
        case ast.With(items=items):
            return any(ast.unparse(item.context_expr).startswith(("pytest.raises(", "pytest.warns(")) for item in items)
        case ast.Expr(value=ast.Call(func=function)):
            return ast.unparse(function).split(".")[-1].startswith("assert_")
    return False


def assertions(body, names, *, sure=True):
    """Of every statement that asserts: its line, and whether it is sure to be reached, or else hangs on a loop."""
    for node in body:
        names = names | constants([node])
        certain = asserts(node, names)
        if certain or isinstance(node, ast.Assert):
            yield node.lineno, sure and certain
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            continue
        runs = sure
        if isinstance(node, ast.For):
            runs = sure and is_sure(node.iter, names)
        elif isinstance(node, ast.While):
            runs = False
        for part in ("body", "orelse", "finalbody"):
            yield from assertions(getattr(node, part, []), names, sure=runs if part == "body" else sure)
        for handler in getattr(node, "handlers", []):
            yield from assertions(handler.body, names, sure=sure)


def that_may_assert_nothing(text):
    """(name, line) of the tests and the shared assertions all of whose assertions hang on loops that may not run."""
    tree = ast.parse(text)
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
        if function.name.startswith(("test_", "assert_")):
            made = list(assertions(function.body, constants(tree.body)))
            if made and not any(sure for _, sure in made):
                yield function.name, function.lineno


def test_each_asserts_whatever_its_loops_run_over():
    assert len(FILES) > 300, "the files have been found"
    assert [
        f"{path.relative_to(TESTS)}:{line}: {name} asserts only in loops that may not run"
        for path in FILES
        for name, line in that_may_assert_nothing(path.read_text(encoding="utf-8"))
    ] == []


@pytest.mark.parametrize(
    ("body", "sure"),
    [
        ("for x in found(): assert x", False),
        ("while found(): assert x", False),
        ("assert all(x for x in found())", False),
        ("for x in found(): np.testing.assert_equal(x, 1)", False),
        ("for x in ROWS:\n  for y in x: assert y", False),
        ("for x in [y for y in ROWS if y]: assert x", False),
        ("for x in range(0): assert x", False),
        ("for x in ROWS[1:]: assert x", False),
        ("for x in zip(ROWS, found()): assert x", False),
        ("for x in found(): assert x\nassert found()", True),
        ("for x in ROWS: assert x", True),
        ("rows = ROWS\nfor i, x in enumerate(rows): assert x", True),
        ("for x in zip(ROWS, found(), strict=True): assert x", True),
        ("for x in (1, 2): assert x", True),
        ("for x in range(3):\n  with pytest.raises(ValueError): f(x)", True),
        ("if known: assert x", True),
        ("assert_lines(found())", True),
    ],
)
def test_which_loops_are_taken_to_run(body, sure):
    lines = "\n".join(f"    {line}" for line in body.splitlines())
    found = list(that_may_assert_nothing(f"ROWS = (1, 2)\n\ndef test_it(found):\n{lines}\n"))
    assert found == ([] if sure else [("test_it", 3)])


def test_no_file_of_tests_is_too_long():
    lines = {str(path.relative_to(TESTS)): len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    assert {name: count for name, count in lines.items() if count > MOST_LINES} == {}
