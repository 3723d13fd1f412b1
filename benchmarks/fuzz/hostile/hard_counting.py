"""Programs that ground quickly and are hard to compile or to count, or whose answers are many or long."""

from __future__ import annotations

from functools import partial
from itertools import combinations
from random import Random

from benchmarks.fuzz.hostile.program import Hostile, Rows, programs


def _choices(count: int, name: str = "x") -> str:
    return "".join(f"0.5::{name}({i}). " for i in range(count))


def grid(side: int) -> str:
    """Whether two corners of a grid of uncertain edges are connected."""
    edges = [(x, y, x + dx, y + dy) for x in range(side) for y in range(side) for dx, dy in ((0, 1), (1, 0))]
    facts = "".join(f"0.5::e(p({x},{y}),p({z},{w})). " for x, y, z, w in edges if z < side and w < side)
    ways = "c(X,Y) :- e(X,Y). c(X,Y) :- e(Y,X). r(X,Y) :- c(X,Y). r(X,Y) :- c(X,Z), r(Z,Y). "
    return f"{facts}{ways}a :- r(p(0,0),p({side - 1},{side - 1})). query(a)."


def complete(nodes: int) -> str:
    """Whether two nodes of a complete graph are connected."""
    facts = "".join(f"0.3::e({i},{j}). " for i in range(nodes) for j in range(nodes) if i != j)
    return f"{facts}r(X,Y) :- e(X,Y). r(X,Y) :- e(X,Z), r(Z,Y). a :- r(0,{nodes - 1}). query(a)."


def clauses(variables: int, count: int) -> str:
    """A random formula of three literals a clause."""
    random = Random(0)  # noqa: S311 - no secret
    bodies = [
        ", ".join(random.choice(("", "\\+ ")) + f"x({i})" for i in random.sample(range(variables), 3))
        for _ in range(count)
    ]
    return f"{_choices(variables)}{''.join(f'bad :- {body}. ' for body in bodies)}a :- \\+ bad. query(a)."


def pigeons(holes: int) -> str:
    """One pigeon more than holes: evidence that is impossible, which only all ways show."""
    facts = "".join("; ".join(f"1/{holes}::in({p},{h})" for h in range(holes)) + ". " for p in range(holes + 1))
    return f"{facts}clash :- in(P,H), in(Q,H), P < Q. evidence(\\+ clash). 0.5::a. query(a)."


def permanent(size: int) -> str:
    """The permanent of a matrix."""
    rows = "".join("; ".join(f"{1 / size:.3f}::m({i},{j})" for j in range(size)) + ". " for i in range(size))
    return f"{rows}clash :- m(I,J), m(K,J), I < K. a :- \\+ clash. query(a)."


def colouring(nodes: int, edges: int) -> str:
    """Whether a random graph is coloured well by chance."""
    random = Random(1)  # noqa: S311 - no secret
    chosen = random.sample(list(combinations(range(nodes), 2)), edges)
    facts = "".join(f"0.3::c({i},r); 0.3::c({i},g); 0.4::c({i},b). " for i in range(nodes))
    return (
        f"{facts}{''.join(f'bad :- c({i},X), c({j},X). ' for i, j in chosen)}evidence(\\+ bad). a :- c(0,r). query(a)."
    )


def product(bits: int) -> str:
    """A multiplier: the factors of a number by chance."""
    sums = "".join(
        f"s({i},{j},V) :- b(x{i},A), b(y{j},B), P is A * B, s({i},{j - 1},W), V is W + P * {1 << (i + j)}. "
        for i in range(bits)
        for j in range(1, bits)
    )
    firsts = "".join(
        f"s({i},0,V) :- b(x{i},A), b(y0,B), t({i - 1},W), V is W + A * B * {1 << i}. t({i},V) :- s({i},{bits - 1},V). "
        for i in range(bits)
    )
    facts = "".join(f"0.5::b({v}{i},0); 0.5::b({v}{i},1). " for v in "xy" for i in range(bits))
    return f"{facts}t(-1,0). {firsts}{sums}a :- t({bits - 1},{(1 << bits) - 1}). query(a)."


def at_least(count: int, most: int) -> str:
    """Whether so many of many hold, by every choice of them."""
    return (
        f"{_choices(count)}n({count},0). n(I,K) :- I < {count}, x(I), J is I + 1, n(J,L), K is L + 1. "
        f"n(I,K) :- I < {count}, \\+ x(I), J is I + 1, n(J,K). a :- n(0,K), K > {most}, h(K). 0.5::h(K) :- K > 0. query(a)."
    )


def friends(people: int) -> str:
    """Who smokes because friends smoke, in circles."""
    facts = "".join(f"0.3::s({i}). " for i in range(people))
    pairs = "".join(f"0.1::i({i},{j}). " for i in range(people) for j in range(people) if i != j)
    return (
        f"{facts}{pairs}k(X) :- s(X). k(X) :- i(Y,X), k(Y). a :- k(0), \\+ k({people - 1}). evidence(k(3)). query(a)."
    )


def hidden_states(steps: int) -> str:
    """A chain of two hidden chains that both emit."""
    return (
        "0.5::u(0); 0.5::u(1). 0.4::q(S,T,0); 0.6::q(S,T,1) :- n(T). 0.7::r(S,T,0); 0.3::r(S,T,1) :- n(T). "
        f"n(T) :- between(0,{steps},T). u(0,X) :- u(X). v(0,X) :- u(X). "
        "u(T,X) :- T > 0, U is T - 1, u(U,S), v(U,R), q(f(S,R),U,X). v(T,X) :- T > 0, U is T - 1, v(U,S), u(U,R), r(f(S,R),U,X). "
        f"a :- u({steps},0), v({steps},1). evidence(u(7,1)). query(a)."
    )


def parities(count: int, sums: int) -> str:
    """Sums modulo two over random choices: each is easy, all together are not."""
    random = Random(2)  # noqa: S311 - no secret
    text = "p([],0). p([X|T],V) :- x(X), p(T,W), V is 1 - W. p([X|T],V) :- \\+ x(X), p(T,V). "
    sets = [sorted(random.sample(range(count), count // 2)) for _ in range(sums)]
    return f"{_choices(count)}{text}a :- {', '.join(f'p({s},1)' for s in sets)}. query(a)."


def many_answers(count: int) -> str:
    """An answer a number."""
    return f"0.5::h. a(X) :- between(1,{count},X), h. query(a(_))."


HARD: Rows = {
    "a grid's reachability": partial(grid, 12),
    "a complete graph's reachability": partial(complete, 14),
    "a random formula of three literals": partial(clauses, 120, 480),
    "pigeons and holes": partial(pigeons, 11),
    "a permanent": partial(permanent, 12),
    "a colouring of a random graph": partial(colouring, 40, 110),
    "factors of a number": partial(product, 9),
    "a threshold over sixty": partial(at_least, 400, 200),
    "circles of friends": partial(friends, 16),
    "two chains that feed each other": partial(hidden_states, 200),
    "parities of random parts": partial(parities, 60, 30),
    "a subquery of a hard one in a subquery": lambda: grid(9).replace(
        "query(a).", "b :- subquery(a, P), P > 0.1. c :- subquery(b, P), P > 0. query(c)."
    ),
    "a subquery by another compiler": lambda: grid(9).replace(
        "query(a).", 'b :- subquery(a, P, [], prob, "bdd"). query(b).'
    ),
    "a hard one as evidence": lambda: grid(10).replace("query(a).", "0.5::z. evidence(a). query(z)."),
    "evidence against itself behind a hard one": lambda: grid(9).replace(
        "query(a).", "evidence(a). evidence(\\+ b). b :- a. 0.5::z. query(z)."
    ),
    "a thousand queries of one hard thing": lambda: grid(9).replace("query(a).", "query(r(_,_))."),
    "a negation that comes back after a thousand steps": lambda: (
        "".join(f"p({i}) :- p({i + 1}). " for i in range(1000)) + "p(1000) :- \\+ p(0). a :- p(0). query(a)."
    ),
    "five hundred layers of negation": lambda: (
        "".join(f"0.5::x({i}). p({i}) :- \\+ p({i + 1}), x({i}). p({i}) :- x({i}), p({i + 1}). " for i in range(500))
        + "p(500). a :- p(0). query(a)."
    ),
}
"""Programs whose counting explodes."""
MANY: Rows = {
    "a million answers": partial(many_answers, 1_000_000),
    "thirty thousand answers": partial(many_answers, 30_000),
    "an answer of a million letters": lambda: "0.5::a('" + "x" * 1_000_000 + "'). query(a(_)).",
    "an answer of a million elements": "0.5::h. a(L) :- h, findall(X, between(1, 1000000, X), L). query(a(_)).",
    "an answer that is a thousand layers deep": (
        "0.5::h. d(0, x). d(N, f(T)) :- N > 0, M is N - 1, d(M, T). a(T) :- h, d(3000, T). query(a(_))."
    ),
    "answers that are each a long list": (
        "0.5::h. a(L) :- h, between(1, 3000, N), findall(X, between(1, N, X), L). query(a(_))."
    ),
    "a choice of three thousand heads": lambda: "; ".join(f"0.00005::a({i})" for i in range(3000)) + ". query(a(_)).",
    "two hundred choices of two hundred heads": lambda: (
        "0.005::c(X,0)"
        + "".join(f"; 0.005::c(X,{i})" for i in range(1, 199))
        + " :- between(1,200,X). a(Y) :- c(1,Y), c(2,Y). query(c(_,_)). query(a(_))."
    ),
    "a predicate of five thousand places": lambda: (
        "0.5::h. p("
        + ", ".join(f"X{i}" for i in range(5000))
        + ") :- h. a :- p("
        + ", ".join("x" for _ in range(5000))
        + "). query(a)."
    ),
    "a clause of three thousand variables": lambda: (
        "d(1). d(2). a :- " + ", ".join(f"d(X{i})" for i in range(900)) + ", X0 > X1, X1 > X2. query(a)."
    ),
}
"""Programs whose answers, or whose clauses, are many or long."""


def hard() -> list[Hostile]:
    """Those that come as a program's file."""
    return [one for rows in (HARD, MANY) for one in programs("program", rows, bomb=True)]
