"""What a program may call.

Everything that is not here is refused, so a new built-in of ProbLog's is refused until it is read.

Every built-in of ProbLog 2.3 falls under one heading: pure (runs as it is), loud (runs, and its output goes nowhere), a
loader (runs, and the
database decides which file it opens: ``engine.SafeDB``), or none, and then it is refused. ``META`` says which arguments
    are goals.
"""

TRUSTED = (
    "--trust: the program may run Python, read and write files and load other programs and modules, with your rights;"
    " only the limits of time and memory still hold"
)
"""What the command line says on stderr when the safety rule is lifted."""

CONTROL = frozenset(
    {"true/0", "fail/0", "false/0", "module/2", "unknown/1", "nocache/2", "seq/1", "trace/0", "notrace/0"}
)
"""``module/2`` only names a program's own predicates; ``trace/0`` does nothing without a debugger."""

COMPARISON = frozenset({
    "=/2", "\\=/2", "==/2", "\\==/2", "is/2", ">/2", "</2", "=</2", ">=/2", "=\\=/2", "=:=/2", "@>/2", "@</2", "@>=/2", "@=</2",
    "compare/3",
})  # fmt: skip

TESTS = frozenset({
    "var/1", "nonvar/1", "atom/1", "atomic/1", "compound/1", "float/1", "integer/1", "number/1", "callable/1", "ground/1", "is_list/1",
    "simple/1", "rational/1", "dbreference/1", "primitive/1",
})  # fmt: skip

TERMS = frozenset({
    "arg/3", "functor/3", "=../2", "length/2", "sort/2", "between/3", "succ/2", "plus/3", "atom_number/2", "subsumes_term/2",
    "subsumes_chk/2", "numbervars/2", "numbervars/3", "varnumbers/2",
})  # fmt: skip

PROGRAM = frozenset({"clause/2", "clause/3", "create_scope/2", "find_scope/2", "sample_uniform1/3", "cmd_args/1"})
"""They look at the program itself; ``cmd_args/1`` is empty, for nothing is passed on."""

STOPS = frozenset(f"error/{n}" for n in range(1, 10))
"""They end the run with the program's own message."""

META: dict[str, tuple[tuple[int, int], ...]] = {
    "\\+/1": ((0, 0),), "not/1": ((0, 0),), ",/2": ((0, 0), (1, 0)), ";/2": ((0, 0), (1, 0)), "once/1": ((0, 0),),
    "forall/2": ((0, 0), (1, 0)), "findall/3": ((1, 0),), "all/3": ((1, 0),), "all_or_none/3": ((1, 0),), "possible/1": ((0, 0),),
    "subquery/2": ((0, 0),), "subquery/3": ((0, 0),), "subquery/5": ((0, 0),),
    "subquery_in_scope/3": ((1, 0),), "subquery_in_scope/4": ((1, 0),), "subquery_in_scope/6": ((1, 0),),
    **{f"{name}/{n + 1}": ((0, n),) for name in ("call", "call_nc", "try_call") for n in range(9)},
    **{f"call_in_scope/{n + 2}": ((1, n),) for n in range(9)},
}  # fmt: skip
"""ProbLog's own predicates that call: predicate → (argument that is a goal, arguments added to it)."""

LIBRARY_META: dict[str, tuple[tuple[int, int], ...]] = {
    "aggregate/5": ((0, 2), (3, 0)), "on_fail/2": ((0, 0), (1, 0)), "cut/1": ((0, 1),), "cut/2": ((0, 1),), ":/2": ((1, 0),),
    "include/3": ((0, 1),), "exclude/3": ((0, 1),), "partition/4": ((0, 1),), "partition/5": ((0, 2),), "convlist/3": ((0, 2),),
    **{f"maplist/{n + 1}": ((0, n),) for n in range(1, 5)},
    **{f"{name}/{n + 3}": ((0, n + 2),) for name in ("foldl", "scanl") for n in range(1, 5)},
    "assertz/1": ((0, 0),), ":-/2": ((1, 0),),
}  # fmt: skip
"""The same for the libraries. A program may define these names itself; what it then passes to them is looked at all the
same."""

EVALUATORS = frozenset({'"ddnnf"', '"nnf"', '"sdd"', '"sddx"', '"bdd"', '"fsdd"', '"fbdd"'})
"""Ways of counting that subquery/5 may name: those that compute in this process, or by the compiler that every run
uses."""

LOUD = frozenset({"nl/0", "dbg_printdb/0", "print_state/0"}) | {
    f"{name}/{n}" for name in ("write", "writeln", "writenl", "debugprint") for n in range(1, 10)
}
"""Output is no part of an answer: they succeed and say nothing."""

LOADERS = frozenset({"use_module/1", "use_module/2", "_use_module/2", "_use_module/3", "_consult/2"})
"""Built-ins that open a file; ProbLog turns ``:- use_module(F)`` and ``:- consult(F)`` into those with an
underscore."""

GOALS = CONTROL | COMPARISON | TESTS | TERMS | PROGRAM | STOPS | LOUD | frozenset(META)
"""Signatures of built-ins that may be called, the loaders apart."""

LISTS = frozenset({
    "memberchk/2", "member/2", "append/3", "append/2", "prefix/2", "select/3", "selectchk/3", "select/4", "selectchk/4", "nextto/3",
    "delete/3", "nth0/3", "nth1/3", "nth0/4", "nth1/4", "last/2", "proper_length/2", "same_length/2", "reverse/2", "permutation/2",
    "flatten/2", "max_member/2", "min_member/2", "sum_list/2", "max_list/2", "min_list/2", "numlist/3", "is_set/1", "list_to_set/2",
    "intersection/3", "union/3", "subset/2", "subtract/3", "enum_groups/3", "enum_groups/4", "select_uniform/4", "select_weighted/5",
    "select_weighted/4",
})  # fmt: skip
"""What library(lists) offers."""

LIBRARIES = frozenset(
    {
        "lists",
        "apply",
        "aggregate",
        "control",
        "cut",
        "scope",
        "collect",
        "string",
        "assert",
        "record",
        "nlp4plp",
        "builtin",
    }
)
"""Libraries of ProbLog's own that a program may load, by name only: pure, or changing nothing but the program itself.

Not here: ``db`` (files, SQL), ``aproblog`` (its answers are no probabilities).
"""

LIBRARY_FILES = frozenset({
    "lists.pl", "lists.py", "apply.pl", "aggregate.pl", "control.pl", "cut.pl", "scope.pl", "collect.pl", "string.pl", "string.py",
    "assert.py", "record.py", "builtin.pl", "nlp4plp.pl",
    *(f"nlp4plp.d/{name}.pl" for name in (
        "constraints", "ge_solver_sparse", "histograms", "input_interface", "meta_prob", "multiset_constraints", "probabilistic_drawing",
        "property_based_merging", "setup_aux", "static_setup", "terms_to_predicates",
    )),
})  # fmt: skip
"""The files behind ``LIBRARIES``, in ProbLog's own folder: nothing else is ever opened."""

SPECIAL_HEADS = frozenset({"query/1", "evidence/1", "evidence/2"})
"""Heads whose first argument ProbLog calls as a goal."""
