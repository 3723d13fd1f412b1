"""The programs that people try first, as families: graphs, grids, chains, networks of causes. Deterministic by seed.

``Sample("smokers", 8, text)``: one program of a family, with its ``query/1`` and ``evidence/2``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

ALARM = Path(__file__).resolve().parents[2] / "examples" / "alarm.pl"
"""The shipped program."""


@dataclass(frozen=True)
class Sample:
    """One program; ``size`` in the units of its family."""

    family: str
    size: int
    text: str


def samples(seed: int, *, quick: bool) -> Iterator[Sample]:
    """All programs, smaller ones of a family first."""
    sizes = QUICK if quick else SIZES
    yield Sample("alarm", 1, ALARM.read_text(encoding="utf-8"))
    for family, make in MADE.items():
        for size in sizes[family]:
            yield Sample(family, size, make(size, Random(f"{family} {size} {seed}")))  # noqa: S311 - a sample, no secret


def smokers(people: int, random: Random) -> str:
    """Friends and smokers: a ring of friends with chords, friendship goes both ways, so that influence is cyclic."""
    pairs = [(i, (i + 1) % people) for i in range(people)]
    others = [(i, j) for i in range(people) for j in range(i + 2, people) if (i, j) != (0, people - 1)]
    pairs += random.sample(others, min(len(others), people // 2))
    friends = "".join(f"friend(p{i},p{j}). friend(p{j},p{i}).\n" for i, j in pairs)
    persons = "".join(f"person(p{i}).\n" for i in range(people))
    return (
        "0.3::stress(X) :- person(X).\n0.2::influences(X,Y) :- friend(X,Y).\n"
        "smokes(X) :- stress(X).\nsmokes(X) :- friend(X,Y), influences(Y,X), smokes(Y).\n"
        f"0.4::asthma(X) :- smokes(X).\n{persons}{friends}"
        f"evidence(smokes(p{people // 2})).\nquery(smokes(_)).\nquery(asthma(_)).\n"
    )


PATH = "path(X,X).\npath(X,Y) :- edge(X,Z), path(Z,Y).\n"
BOTH_WAYS = "edge(X,Y) :- link(X,Y).\nedge(X,Y) :- link(Y,X).\n"


def undirected_grid(side: int, random: Random) -> str:
    """Is there a path from corner to corner of a grid whose links go both ways?"""
    links = "".join(f"{_share(random)}::link({a},{b}).\n" for a, b in _links(side))
    return f"{links}{BOTH_WAYS}{PATH}query(path(c0_0,c{side - 1}_{side - 1})).\n"


def directed_grid(side: int, random: Random) -> str:
    """Is there a path from corner to corner, right and down alone? No cycle."""
    links = "".join(f"{_share(random)}::edge({a},{b}).\n" for a, b in _links(side))
    return f"{links}{PATH}query(path(c0_0,c{side - 1}_{side - 1})).\n"


def _links(side: int) -> Iterator[tuple[str, str]]:
    for i in range(side):
        for j in range(side):
            if j + 1 < side:
                yield f"c{i}_{j}", f"c{i}_{j + 1}"
            if i + 1 < side:
                yield f"c{i}_{j}", f"c{i + 1}_{j}"


def random_graph(nodes: int, random: Random) -> str:
    """What can be reached from the first node of a random graph with two arrows a node?"""
    arrows = [(i, j) for i in range(nodes) for j in range(nodes) if i != j]
    chosen = sorted(random.sample(arrows, 2 * nodes))
    edges = "".join(f"{_share(random)}::edge(n{i},n{j}).\n" for i, j in chosen)
    return f"{edges}{PATH}query(path(n0,n{nodes - 1})).\nquery(path(n0,n{nodes // 2})).\n"


def hmm(steps: int, random: Random) -> str:
    """The weather of so many days, of which umbrellas are seen."""
    seen = "".join(f"evidence(umbrella({t}),{str(random.random() < 0.5).lower()}).\n" for t in range(1, steps + 1))
    return (
        "0.5::state(0,sun); 0.3::state(0,cloud); 0.2::state(0,rain).\n"
        "0.6::state(T,sun); 0.3::state(T,cloud); 0.1::state(T,rain) :- T > 0, S is T-1, state(S,sun).\n"
        "0.3::state(T,sun); 0.4::state(T,cloud); 0.3::state(T,rain) :- T > 0, S is T-1, state(S,cloud).\n"
        "0.2::state(T,sun); 0.3::state(T,cloud); 0.5::state(T,rain) :- T > 0, S is T-1, state(S,rain).\n"
        "0.05::umbrella(T) :- state(T,sun).\n0.3::umbrella(T) :- state(T,cloud).\n0.9::umbrella(T) :- state(T,rain).\n"
        f"{seen}query(state({steps},sun)).\nquery(state({steps // 2},rain)).\n"
    )


def bayesian_grid(side: int, random: Random) -> str:
    """A network in which every node has the nodes to its left and above as parents; one is seen, the last asked."""
    lines = []
    for i in range(side):
        for j in range(side):
            parents = [f"x({i},{j - 1})"] * (j > 0) + [f"x({i - 1},{j})"] * (i > 0)
            for row in range(2 ** len(parents)):
                body = ", ".join(p if row >> k & 1 else f"\\+ {p}" for k, p in enumerate(parents))
                lines.append(f"{_share(random)}::x({i},{j}){' :- ' if body else ''}{body}.\n")
    last = side - 1
    return f"{''.join(lines)}evidence(x({last // 2},{last}),true).\nquery(x({last},{last})).\nquery(x(0,0)).\n"


def qmr(diseases: int, random: Random) -> str:
    """Causes and findings in two layers, noisy-or, half of the findings seen."""
    lines = [f"{0.2 * _share(random):.4f}::d({i}).\n" for i in range(diseases)]
    for f in range(diseases):
        lines.append(f"0.02::f({f}).\n")
        lines += [f"{_share(random)}::f({f}) :- d({i}).\n" for i in sorted(random.sample(range(diseases), 4))]
    seen = "".join(f"evidence(f({f}),{str(random.random() < 0.5).lower()}).\n" for f in range(0, diseases, 2))
    return f"{''.join(lines)}{seen}query(d(_)).\n"


def blood_type(generations: int, random: Random) -> str:
    """Blood groups of a family tree: a gene from either parent; the groups of two of the oldest are known."""
    count, leaf = 2**generations - 1, 2 ** (generations - 1)
    parents = "".join(f"mother(b{2 * i},b{i}). father(b{2 * i + 1},b{i}).\n" for i in range(1, leaf))
    founders = "".join(f"founder(b{i}).\n" for i in range(leaf, count + 1))
    seen = f"evidence(bloodtype(b{count},{random.choice('ab')})).\nevidence(bloodtype(b{leaf},null)).\n"
    return (
        "0.3::mchrom(X,a); 0.3::mchrom(X,b); 0.4::mchrom(X,null) :- founder(X).\n"
        "0.3::pchrom(X,a); 0.3::pchrom(X,b); 0.4::pchrom(X,null) :- founder(X).\n"
        "0.5::mine(X,m,1); 0.5::mine(X,m,2) :- mother(_,X).\n0.5::mine(X,p,1); 0.5::mine(X,p,2) :- father(_,X).\n"
        "mchrom(X,Y) :- mother(Z,X), mine(X,m,1), mchrom(Z,Y).\nmchrom(X,Y) :- mother(Z,X), mine(X,m,2), pchrom(Z,Y).\n"
        "pchrom(X,Y) :- father(Z,X), mine(X,p,1), mchrom(Z,Y).\npchrom(X,Y) :- father(Z,X), mine(X,p,2), pchrom(Z,Y).\n"
        "bloodtype(X,a) :- mchrom(X,a), pchrom(X,a).\nbloodtype(X,a) :- mchrom(X,a), pchrom(X,null).\n"
        "bloodtype(X,a) :- mchrom(X,null), pchrom(X,a).\nbloodtype(X,b) :- mchrom(X,b), pchrom(X,b).\n"
        "bloodtype(X,b) :- mchrom(X,b), pchrom(X,null).\nbloodtype(X,b) :- mchrom(X,null), pchrom(X,b).\n"
        "bloodtype(X,ab) :- mchrom(X,a), pchrom(X,b).\nbloodtype(X,ab) :- mchrom(X,b), pchrom(X,a).\n"
        "bloodtype(X,null) :- mchrom(X,null), pchrom(X,null).\n"
        f"{parents}{founders}{seen}query(bloodtype(b1,_)).\n"
    )


def _share(random: Random) -> float:
    return round(random.uniform(0.1, 0.9), 3)


MADE = {
    "smokers": smokers,
    "undirected grid": undirected_grid,
    "directed grid": directed_grid,
    "random graph": random_graph,
    "HMM": hmm,
    "Bayesian grid": bayesian_grid,
    "QMR": qmr,
    "blood type": blood_type,
}
SIZES = {
    "smokers": (4, 6, 8, 10),
    "undirected grid": (3, 4),
    "directed grid": (4, 5, 6, 7, 8),
    "random graph": (12, 14, 16, 18, 20),
    "HMM": (20, 80),
    "Bayesian grid": (3, 4, 5, 6),
    "QMR": (8, 10, 12, 14, 16),
    "blood type": (2, 3),
}
QUICK = {family: sizes[:1] for family, sizes in SIZES.items()}
