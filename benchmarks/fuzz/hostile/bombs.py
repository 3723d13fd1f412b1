"""Programs that never end, or end too late: recursion, collecting, arithmetic, terms that double."""

from __future__ import annotations

from benchmarks.fuzz.hostile.program import Hostile, programs

ENDLESS = {
    "a term that grows with every call": "a :- p(z). p(X) :- p(s(X)). query(a).",
    "a number that grows with every call": "a :- p(1). p(X) :- Y is X + 1, p(Y). query(a).",
    "two predicates that grow a list between them": "a :- p([]). p(L) :- q([x|L]). q(L) :- p([y|L]). query(a).",
    "a tree that doubles with every call": "a :- p(t). p(X) :- p(t(X, X)). query(a).",
    "counting without end": "a(X) :- between(1, inf, X). query(a(_)).",
    "counting without end for one that never comes": "a :- between(1, inf, X), X < 0. query(a).",
    "lists of every length": "a :- length(L, N), N < 0. query(a).",
    "collecting without end": "n(z). n(s(X)) :- n(X). a :- findall(X, n(X), L), L = []. query(a).",
    "asking all of something endless": "n(z). n(s(X)) :- n(X). a :- forall(n(X), X = z). query(a).",
    "negating something endless": "n(z, z). n(X, s(Y)) :- n(X, Y). a :- \\+ n(q, _). query(a).",
    "a directive that does not end": "p(X) :- Y is X + 1, p(Y). :- p(0). a. query(a).",
    "evidence that never ends": "p(X) :- p(f(X)). 0.5::a. evidence(p(z)). query(a).",
    "a query that does not end": "n(z). n(s(X)) :- n(X). query(n(X)).",
    "choices without end": "0.5::c(X) :- n(X). n(0). n(Y) :- n(X), Y is X + 1. a :- c(_). query(a).",
    "a label that does not end": "P::a :- p(P, 1). p(P, N) :- M is N + 1, p(P, M). query(a).",
    "a program that adds to itself": (
        ":- use_module(library(assert)). a :- p(0). p(N) :- assertz(q(N)), M is N + 1, p(M). query(a)."
    ),
    "records without end": ":- use_module(library(record)). a :- p(0). p(N) :- recordz(k, N), M is N + 1, p(M). query(a).",
    "a name that doubles": ":- use_module(library(string)). a :- p(x). p(X) :- concat([X, X], Y), p(Y). query(a).",
    "a goal that wraps itself": "a :- p(true). p(G) :- p(call(G)). query(a).",
    "a predicate that calls what it is given, itself": "w(X) :- call(X, s(X)). a :- call(w, w). s(X, Y) :- call(Y, X). query(a).",
    "subqueries of subqueries": "p(N) :- M is N + 1, subquery(p(M), P), P > 0. a :- p(0). query(a).",
    "findall in findall without end": "p(N, L) :- M is N + 1, findall(X, p(M, X), L). a :- p(0, L). query(a).",
    "all worlds of something endless": "0.5::h. n(0). n(Y) :- n(X), h, Y is X + 1. a :- all(X, n(X), L), L = [_]. query(a).",
    "a scope that grows": ":- use_module(library(scope)). a :- p([]). p(S) :- S:true, p([x|S]). query(a).",
    "try_call that starts again": "p(X) :- try_call(p(f(X))). p(X) :- p(g(X)). a :- p(z). query(a).",
}
LATE = {
    "Ackermann's function": (
        "k(0, N, R) :- R is N + 1. k(M, 0, R) :- M > 0, P is M - 1, k(P, 1, R). "
        "k(M, N, R) :- M > 0, N > 0, Q is N - 1, k(M, Q, S), P is M - 1, k(P, S, R). a :- k(4, 2, _). query(a)."
    ),
    "every order of twelve": ":- use_module(library(lists)). a(L) :- permutation([1,2,3,4,5,6,7,8,9,10,11,12], L). query(a(_)).",
    "every part of a set": (
        "part([], []). part([X|T], [X|S]) :- part(T, S). part([_|T], S) :- part(T, S). "
        "a :- numlist(1, 30, L), part(L, S), sum_list(S, -1). :- use_module(library(lists)). query(a)."
    ),
    "every split of a long list, split again": (
        ":- use_module(library(lists)). a(N) :- numlist(1, 300, L), append(A, B, L), append(C, D, A), append(E, F, B), "
        "length(C, N). query(a(_))."
    ),
    "queens by trying": (
        ":- use_module(library(lists)). a :- permutation([1,2,3,4,5,6,7,8,9,10], Q), safe(Q). safe([]). "
        "safe([Q|T]) :- none(Q, T, 1), safe(T). none(_, [], _). "
        "none(Q, [P|T], N) :- Q =\\= P + N, Q =\\= P - N, M is N + 1, none(Q, T, M). query(a)."
    ),
    "discs on three pegs": (
        "h(0, _, _, _). h(N, A, B, C) :- N > 0, M is N - 1, h(M, A, C, B), m(N, A, C), h(M, B, A, C). m(N, _, _) :- "
        "findall(X, between(1, 100000, X), _). a :- h(40, l, m, r). query(a)."
    ),
    "a product of ten tables": (
        "".join(f"d({i}). " for i in range(10))
        + "a :- "
        + ", ".join(f"d(X{i})" for i in range(10))
        + ", X0 + X1 + X2 + X3 + X4 + X5 + X6 + X7 + X8 + X9 < 0. query(a)."
    ),
    "ten queries with ten places each": (
        "d(0). d(1). d(2). d(3). "
        + "".join(f"0.5::a({i}, A, B, C, D, E, F, G) :- d(A), d(B), d(C), d(D), d(E), d(F), d(G). " for i in range(10))
        + "query(a(_, _, _, _, _, _, _, _))."
    ),
    "a chain of Collatz's": (
        "c(1, 0). c(N, S) :- N > 1, 0 is N mod 2, M is N // 2, c(M, T), S is T + 1. "
        "c(N, S) :- N > 1, 1 is N mod 2, M is 3 * N + 1, c(M, T), S is T + 1. "
        "a :- between(1, 1000000, N), c(N, S), S > 100000. query(a)."
    ),
    "a perfect number, which is odd": (
        "d(N, S) :- findall(D, (between(1, N, D), 0 is N mod D), L), sum_list(L, S). :- use_module(library(lists)). "
        "a :- between(3, 10000000, N), 1 is N mod 2, d(N, S), S =:= 2 * N. query(a)."
    ),
    "sorting what is long": "a :- findall(X, between(1, 20000000, X), L), sort(L, [_]). query(a).",
    "a list of a hundred million": "a :- length(L, 100000000), L = []. query(a).",
    "a term of a hundred million places": "a :- functor(T, f, 100000000), T = x. query(a).",
    "a term of a million places from a list": "a :- length(L, 3000000), T =.. [f|L], T = x, numbervars(T, 0). query(a).",
    "a term that doubles forty times": (
        "d(0, x). d(N, t(T, T)) :- N > 0, M is N - 1, d(M, T). a :- d(40, T), d(40, S), T == S. query(a)."
    ),
    "a doubled term that is printed": "d(0, x). d(N, t(T, T)) :- N > 0, M is N - 1, d(M, T). a(T) :- d(30, T). query(a(_)).",
    "a doubled term that is compared": (
        "d(0, x). d(N, t(T, T)) :- N > 0, M is N - 1, d(M, T). a :- d(35, T), d(35, S), sort([T, S], [_, _]). query(a)."
    ),
    "unifying what doubles": (
        "a :- f("
        + ", ".join(f"X{i}" for i in range(1, 41))
        + ") = f("
        + ", ".join(f"g(X{i}, X{i})" for i in range(40))
        + "), X40 = y. query(a)."
    ),
    "a cyclic term": "a :- X = f(X, Y), Y = g(Y, X), X = Y. b :- Z = [x|Z], length(Z, _). query(a). query(b).",
    "an aggregate of millions": ":- use_module(library(aggregate)). s(sum<X>) :- between(1, 30000000, X). a(X) :- s(X). query(a(_)).",
    "everything below everything": (
        ":- use_module(library(lists)). a :- numlist(1, 3000, L), subset(S, L), length(S, 1500). query(a)."
    ),
    "a union of long lists": ":- use_module(library(lists)). a :- numlist(1, 30000, L), union(L, L, U), intersection(L, U, []). query(a).",
    "a game without a best move": (
        "w(N) :- between(1, 3, K), N >= K, M is N - K, \\+ w(M). x(S) :- between(1, 6, A), between(1, 6, B), "
        "T is S + A * B, T < 400, \\+ x(T). 0.5::c. a :- w(3000), x(0), c. query(a)."
    ),
    "expression of a thousand layers over and over": (
        "e(0, 1). e(N, E + E) :- N > 0, M is N - 1, e(M, E). a(X) :- e(40, E), X is E. query(a(_))."
    ),
}
NUMBERS = {
    "nine to the nine to the nine": "a(X) :- X is 9 ** (9 ** (9 ** 9)). query(a(_)).",
    "a number of a terabit": "a :- X is 1 << (1 << 40), X > 0. query(a).",
    "a power in a label": "9 ** (9 ** (9 ** 9))::a. query(a).",
    "a shift in a label": "1 << 99999999999::a. query(a).",
    "a power in a rule's label": "2 ** (0 - 2 ** (2 ** 40))::a :- b. b. query(a).",
    "a factorial of a million": "f(0, 1). f(N, X) :- N > 0, M is N - 1, f(M, Y), X is N * Y. a(X) :- f(1000000, X). query(a(_)).",
    "squaring without end": "a :- p(3). p(X) :- Y is X * X, p(Y). query(a).",
    "a square as its digits": "a(X) :- X is 7 ** 1000000. query(a(_)).",
    "a power compared with itself": "a :- 3 ** 300000000 =:= 3 ** 300000000. query(a).",
    "a remainder of a power": "a(X) :- X is (7 ** 99999999) mod 10. query(a(_)).",
    "a root of less than nothing": "a(X) :- X is (0 - 8) ** 0.5, X > 1. (0 - 8) ** 0.5::b. query(a(_)). query(b).",
    "numbers that are none": "inf::a. nan::b. -0.0::c. 1 / 0::d. query(a). query(b). query(c). query(d).",
    "endless in an expression": "P::a :- P is inf - inf. P::b :- P is nan. query(a). query(b).",
    "more digits than are read": "a(" + "9" * 5000 + "). query(a(_)).",
    "more digits after the point": "0." + "3" * 400_000 + "::a. query(a).",
    "a number in hexadecimal": "a(X) :- X is 0x" + "f" * 1_000_000 + " * 0x" + "e" * 1_000_000 + ". query(a(_)).",
    "an exponent of many digits": "a(1e" + "9" * 4000 + "). 1e-" + "9" * 4000 + "::b. query(a(_)). query(b).",
    "a gamma of much": "a(X) :- X is gamma(171.9), Y is lgamma(1e308), X > Y, exp(710) > 0. query(a(_)).",
    "a number from a name": "a(X) :- atom_number('1_000e4000', X). b(X) :- atom_number(N, "
    + "9" * 4200
    + "), X = N. query(a(_)). query(b(_)).",
}


def bombs() -> list[Hostile]:
    """Those that come as a program's file."""
    return [one for rows in (ENDLESS, LATE, NUMBERS) for one in programs("program", rows, bomb=True)]
