"""Texts that are long to read before anything runs, and bombs through the other doors."""

from __future__ import annotations

from functools import partial

from benchmarks.fuzz.hostile.hard_counting import grid
from benchmarks.fuzz.hostile.program import Hostile, Rows, programs

WHOLE = 8 * 2**20 - 100
"""Bytes of a program that is just not too long."""


def filled(piece: str, size: int = WHOLE, *, before: str = "a. query(a).\n", after: str = "") -> str:
    """A piece again and again, up to a size."""
    return before + piece * ((size - len(before) - len(after)) // len(piece)) + after


def quotes_and_digits(count: int) -> str:
    """A number that is too long, and then quotes of which none is closed."""
    return "a(" + "9" * 5000 + ").\nb('" + "\\'" * count


TEXTS: Rows = {
    "brackets that are never closed": partial(filled, "("),
    "lists that are never closed": partial(filled, "["),
    "terms that are never closed": partial(filled, "a("),
    "brackets closed at once": partial(filled, "()"),
    "a rule's sign again and again": partial(filled, ":-"),
    "a rule's sign and brackets with spaces": partial(filled, "( ", 100_000, before=":-" * 20_000),
    "a rule's sign in a comment": partial(filled, ":- ", before="a. query(a). % "),
    "empty directives": partial(filled, ":- true.\n"),
    "directives of long rows": lambda: "a. query(a).\n" + (":- " + "true, " * 190 + "true.\n") * 700,
    "eight megabytes of facts": partial(
        filled, "0.5::b(x,1).\n", before=":- true. query(a). a. constraint(x) :- b(x,1).\n"
    ),
    "eight megabytes of one name": lambda: filled("x", before="a('", after="'). query(a(_))."),
    "eight megabytes of one variable": lambda: filled("X", before="a(", after="). query(a(_))."),
    "a comment that is never closed": partial(filled, "/* * ", before="a. query(a). "),
    "comments in a row": partial(filled, "/**/"),
    "blank lines": partial(filled, "\n"),
    "full stops": partial(filled, " ."),
    "quotes that are never closed": partial(filled, "'\\'", before="a(' "),
    "a number too long before quotes that are never closed": partial(quotes_and_digits, 24_000),
    "a row that is just not too long": lambda: "a :- " + "b, " * 6900 + "b. b. query(a).",
    "many rows that are just not too long": lambda: "b. query(a). " + ("a :- " + "b, " * 199 + "b.\n") * 500,
    "a row of minus signs": lambda: "a(X) :- X is " + "- " * 6900 + "1. query(a(_)).",
    "alternatives in alternatives": lambda: "a :- " + "(b ; " * 900 + "b" + ")" * 900 + ". b. query(a).",
    "negations of negations": lambda: "0.5::b. a :- " + "\\+ (" * 900 + "b" + ")" * 900 + ". query(a).",
    "a term of a hundred thousand layers": lambda: "b(" + "f(" * 100_000 + "x" + ")" * 100_000 + "). a. query(a).",
    "a list of half a million": lambda: "a([" + "1," * 500_000 + "1]). query(a(_)).",
    "names that nearly match": lambda: (
        "".join(f"{'ab' * 100}{i}(x). " for i in range(3000)) + f"a :- {'ba' * 100}(x). query(a)."
    ),
    "unknown calls, thousands": lambda: "".join(f"a({i}) :- unknown{i}(x). " for i in range(3000)) + "query(a(_)).",
    "mistakes, thousands": lambda: ":- consult(x). " * 4000,
    "a negation in a large circle": lambda: (
        "".join(f"p{i} :- p{(7 * i + 3) % 3000}, p{(5 * i + 1) % 3000}. " for i in range(3000))
        + "p0 :- \\+ p1. a :- p0. query(a)."
    ),
    "signs of operators": partial(filled, "=.. @>= =:= ", 40_000),
}
"""They are hard to read."""
LONG_GOAL = "b" + ", b" * 30_000
GOALS: Rows = {
    "a goal of a hundred thousand letters": LONG_GOAL,
    "a goal whose row is just not too long": "b" + ", b" * 6900,
    "a goal that counts without end": "between(1, inf, X), X < 0",
    "a goal of a large number": "X is 9 ** (9 ** (9 ** 9))",
    "a goal that collects in a collection": "findall(X, (between(1, 100000000, X), findall(Y, between(1, 1000, Y), _)), L)",
    "a goal of many layers": "\\+ (" * 3000 + "b" + ")" * 3000,
}
SCENE_GOALS: Rows = {
    "a scene's goal that does not end": "present(H), between(1, inf, X), X < 0",
    "a scene's goal of every pair of pairs": "object(A, _), near(A, B, X), between(1, 30000000, Y), Y < 0",
    "a scene's goal that is long": "present(h1)" + ", present(h1)" * 6900,
    "a scene's list of lists": "findall(H, present(H), L), findall(M, (between(1, 10000000, M), M < 0), [])",
}
GIVEN: Rows = {
    "evidence of a large number": "0 < 9 ** (9 ** (9 ** 9))",
    "evidence that does not end": "\\+ (between(1, inf, X), X < 0)",
    "evidence in a long row": "b" + ", b" * 6900,
}
RULES: Rows = {
    "rules with a large label": "9 ** (9 ** (9 ** 9))::c. evidence(c).",
    "rules that do not end": "p(X) :- p(f(X)). evidence(p(z)).",
    "rules in a long row": "c :- " + "b, " * 6900 + "b. evidence(c).",
    "rules of eight megabytes": lambda: filled("0.5::c(x,1).\n", before="c :- b.\n"),
}
SCENE_RULES: Rows = {
    "a scene's rules with a large label": "9 ** (9 ** (9 ** 9))::c. constraint(x) :- present(_), \\+ c.",
    "a scene's constraint that does not end": "constraint(X) :- present(_), between(1, inf, X), X < 0.",
    "a scene's constraint of a million names": "constraint(X) :- present(_), between(1, 1000000, X).",
    "a scene's rules in a long row": "constraint(x) :- " + "present(_), " * 6900 + "present(_).",
    "a scene's choices, thousands": "0.5::c(X) :- between(1, 100000, X). constraint(X) :- c(X), c(Y), Y > X, present(_).",
}
KB_RULES: Rows = {
    "a knowledge base's rules with a large label": "9 ** (9 ** (9 ** 9))::c. constraint(x) :- c.",
    "a knowledge base's rules in a long row": "constraint(x) :- " + "present(_), " * 6900 + "present(_).",
    "a knowledge base's rules that say nothing, long": lambda: filled("0.5::c(x,1).\n", 999_000, before=""),
    "a knowledge base's rules with signs of rules": lambda: filled(":- ", 999_000, before="% "),
}
PERCEIVED: Rows = {
    "a constraint that does not end, perceived": "constraint(X) :- present(_), between(1, inf, X), X < 0.",
    "a hard constraint, perceived": lambda: grid(10).replace("query(a).", "constraint(x) :- present(_), \\+ a."),
}
DEFAULT: Rows = {
    "an endless term, explained": "a :- p(z). p(X) :- p(s(X)).",
    "a grid, explained": lambda: grid(8),
    "a million proofs": "d(0). d(1). 0.5::x(I,V) :- d(V). n(I) :- between(1,20,I). f(0). f(I) :- I > 0, J is I - 1, x(I,_), f(J). a :- f(20).",
    "eight megabytes of rules, explained": lambda: filled("b(X) :- c(f(X)).\n", before="a :- b(1).\n"),
}
"""Asked where no deadline can be given."""
LINES: Rows = {
    "an endless goal in the shell": "ask between(1, inf, X), X < 0\nask b",
    "a large number in the shell": "observe 0 < 9 ** (9 ** (9 ** 9))\nworlds",
    "a line of a megabyte in the shell": "ask " + LONG_GOAL * 8,
}


def texts() -> list[Hostile]:
    """Those that are long to read, and those that come beside something harmless."""
    return [
        *programs("program", TEXTS, bomb=True),
        *programs("goal", GOALS, bomb=True),
        *programs("scene goal", SCENE_GOALS, bomb=True),
        *programs("given", GIVEN, bomb=True),
        *programs("rules", RULES, bomb=True),
        *programs("scene rules", SCENE_RULES, asked="present(H)", bomb=True),
        *programs("kb", KB_RULES, bomb=True),
        *programs("perceive", PERCEIVED, bomb=True),
        *programs("explain", DEFAULT, bomb=True),
        *programs("shell", LINES, bomb=True),
    ]
