"""What a program may call. Everything that is not here is refused, so a new built-in of ProbLog's is refused until it is read.

``GOALS`` are signatures ``name/arity``; ``META`` says which arguments of a predicate are goals, and how many arguments are added to each.
"""

from __future__ import annotations

CONTROL = frozenset({"true/0", "fail/0", "false/0"})

COMPARISON = frozenset({
    "=/2", "\\=/2", "==/2", "\\==/2", "is/2", ">/2", "</2", "=</2", ">=/2", "=\\=/2", "=:=/2", "@>/2", "@</2", "@>=/2", "@=</2",
    "compare/3",
})  # fmt: skip

TESTS = frozenset({
    "var/1", "nonvar/1", "atom/1", "atomic/1", "compound/1", "float/1", "integer/1", "number/1", "callable/1", "ground/1", "is_list/1",
    "simple/1", "rational/1",
})  # fmt: skip

TERMS = frozenset({
    "arg/3", "functor/3", "=../2", "length/2", "sort/2", "between/3", "succ/2", "plus/3", "atom_number/2",
    "subsumes_term/2", "subsumes_chk/2",
})  # fmt: skip

LISTS = frozenset({
    "memberchk/2", "member/2", "append/3", "append/2", "prefix/2", "select/3", "selectchk/3", "select/4", "selectchk/4",
    "nextto/3", "delete/3",
    "nth0/3", "nth1/3", "nth0/4", "nth1/4", "last/2", "proper_length/2", "same_length/2", "reverse/2", "permutation/2", "flatten/2",
    "max_member/2", "min_member/2", "sum_list/2", "max_list/2", "min_list/2", "numlist/3", "is_set/1", "list_to_set/2", "intersection/3",
    "union/3", "subset/2", "subtract/3", "enum_groups/3", "enum_groups/4", "select_uniform/4", "select_weighted/5", "select_weighted/4",
})  # fmt: skip

META: dict[str, tuple[tuple[int, int], ...]] = {
    "\\+/1": ((0, 0),), "not/1": ((0, 0),), ",/2": ((0, 0), (1, 0)), ";/2": ((0, 0), (1, 0)), "once/1": ((0, 0),),
    "forall/2": ((0, 0), (1, 0)),
    "findall/3": ((1, 0),), "all/3": ((1, 0),), "all_or_none/3": ((1, 0),), "aggregate/5": ((3, 0),),
    **{f"call/{n + 1}": ((0, n),) for n in range(9)},
    **{f"maplist/{n + 1}": ((0, n),) for n in range(1, 5)},
    **{f"foldl/{n + 3}": ((0, n + 2),) for n in range(1, 5)}, **{f"scanl/{n + 3}": ((0, n + 2),) for n in range(1, 5)},
    "include/3": ((0, 1),), "exclude/3": ((0, 1),), "partition/4": ((0, 1),), "convlist/3": ((0, 2),),
}  # fmt: skip
"""Predicate → (argument that is a goal, arguments added to it)."""

AGGREGATES = frozenset({"avg", "sum", "min", "max", "count", "length"})

GOALS = CONTROL | COMPARISON | TESTS | TERMS | LISTS | frozenset(META)

ARITHMETIC = frozenset({
    "+", "-", "*", "/", "//", "mod", "rem", "div", "min", "max", "abs", "exp", "log", "log10", "sqrt", "sin", "cos", "tan", "asin",
    "acos", "atan",
    "atan2", "sign", "round", "floor", "ceiling", "truncate", "integer", "float", "pi", "e", "^", "**",
})  # fmt: skip
"""Functions that a probability may be written with."""

LIBRARIES = frozenset({"lists", "apply", "aggregate"})
"""Pure libraries that a program may load, by name only."""

SPECIAL_HEADS = frozenset({"query/1", "evidence/1", "evidence/2"})
"""Heads whose first argument ProbLog calls as a goal."""
