"""The possible worlds of a program, most probable first, grouped by the truth of its queries (in the child process).

A possible world is a total choice. Worlds in which the same query atoms hold are told as one, with their probability
together and the most probable total choice among them: of the choices that the queries are made of, and of those that
evidence ties to them; every other has nothing to do with what is asked. The states of independent factors are merged
lazily, the best combinations first, however many there are (Lawler, Murty).

A *state* says which of a factor's query atoms hold. The search decides one atom after the other; what it goes by is the
circuit itself, with the greatest instead of the sum wherever the branches of an OR differ in a query atom. That is
never less than the weight of any completion, and equal to it once all atoms are decided; so the first complete state
that comes up is the best (A*).
"""

import heapq
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from operator import and_, or_
from typing import Any

import numpy as np
from problog.logic import AnnotatedDisjunction, Clause

from plogic.base.walk import reached
from plogic.logic.answers.answer import grouped, prepared
from plogic.logic.dnnf.compiled import Circuit, Compiled, Floats, circuit_of
from plogic.logic.dnnf.nnf import AND, LITERAL, Nnf, nodes_under
from plogic.logic.grounding.ground_program import Ground, Literal
from plogic.logic.grounding.load import Request, line_of
from plogic.logic.safety.check import heads
from plogic.logic.safety.mapping import shown

State = tuple[bool, ...]
"""Whether each of a factor's query atoms holds."""
STATES_AT_ONCE = 8
"""Partial states that are taken further together."""


def bucket(log_weight: float) -> float:
    """Log weights in the same bucket, of width 1e-11, count as equal: rounding must not decide the order."""
    return round(log_weight, 11)


@dataclass(frozen=True)
class Factor:
    """A part of the circuit that shares no variable with any other.

    ``variables``: the query atoms in it, in the order in which they were asked; ``alone``: log weights of its leaves,
    ``(leaves,)``; ``total``: log weight of all its states together.
    """

    variables: tuple[int, ...]
    circuit: Circuit
    alone: Floats
    total: float

    def states(self) -> Iterator[tuple[float, State]]:
        """All possible states with ln P(state | evidence), non-increasing.

        Ties with true before false, the first atom first.
        """
        queue: list[tuple[float, tuple[int, ...], float]] = [(0.0, (), self.total)]  # marks: 0 holds, 1 does not
        while queue:
            taken = [heapq.heappop(queue)]
            if len(taken[0][1]) == len(self.variables):
                _, marks, value = taken[0]
                yield value - self.total, tuple(mark == 0 for mark in marks)
                continue
            while len(taken) < STATES_AT_ONCE and queue and len(queue[0][1]) < len(self.variables):
                taken.append(heapq.heappop(queue))
            further = [(*marks, mark) for _, marks, _ in taken for mark in (0, 1)]
            for marks, value in zip(further, self._values(further)[-1].tolist(), strict=True):
                if value > -math.inf:
                    heapq.heappush(queue, (-bucket(value - self.total), marks, value))

    def best(self, state: State) -> list[int]:
        """The literals of the most probable completion of a state; what ties goes to the circuit's first branch."""
        values = self._values([tuple(int(not holds) for holds in state)], most=True)
        return self.circuit.best(values[:, 0])

    def _values(self, decided: list[tuple[int, ...]], *, most: bool = False) -> Floats:
        leaves = np.repeat(self.alone[:, np.newaxis], len(decided), axis=1)
        for column, marks in enumerate(decided):
            excluded = [-v if mark == 0 else v for v, mark in zip(self.variables, marks, strict=False)]
            leaves[
                [self.circuit.place[literal] for literal in excluded if literal in self.circuit.place], column
            ] = -np.inf
        return self.circuit.up(leaves, most=most)


def factors_of(program: Compiled, atoms: list[int]) -> list[Factor]:
    """The factors of a program, those without query atoms, too.

    ``atoms``: variables that are open, in the order in which they were asked.
    """
    if program.circuit is None:
        return []
    nnf, values = program.nnf, program.values([()])[:, 0]
    weight = dict(zip(program.circuit.literals.tolist(), program.weights.tolist(), strict=True))
    asked = sum(1 << v for v in atoms)
    found = []
    for root in _parts(nnf):
        variables = tuple(v for v in atoms if nnf.mentions[root] >> v & 1) if nnf.mentions[root] & asked else ()
        circuit = circuit_of(nnf, root, _decided_apart(nnf, root, variables))
        alone = np.array([weight[literal] for literal in circuit.literals.tolist()])
        found.append(Factor(variables, circuit, alone, float(values[program.circuit.number[root]])))
    return found


def _parts(nnf: Nnf) -> list[int]:
    """The nodes that the root is the conjunction of, none of them a conjunction."""

    def parts(node: int) -> Iterator[int]:
        return reversed(nnf.children[node] if nnf.kinds[node] == AND else ())

    return [node for node in reached([nnf.root], parts) if nnf.kinds[node] != AND]


def _decided_apart(nnf: Nnf, root: int, variables: tuple[int, ...]) -> set[int]:
    """The ORs any two of whose branches need different values of a query atom.

    Of a state, only one branch has weight.
    """
    if not variables:
        return set()
    sides = {literal: 1 << (2 * i + side) for i, v in enumerate(variables) for side, literal in enumerate((v, -v))}
    yes = sum(1 << (2 * i) for i in range(len(variables)))
    needs: dict[int, int] = {}  # node → the literals of query atoms that hold wherever it does, as bits
    apart = set()
    for node in sorted(nodes_under(nnf, root)):
        below = [needs[child] for child in nnf.children[node]]
        if nnf.kinds[node] == LITERAL:
            needs[node] = sides.get(nnf.literals[node], 0)
        elif nnf.kinds[node] == AND:
            needs[node] = reduce(or_, below)
        else:
            needs[node] = reduce(and_, below)
            if all((a & yes) & (b >> 1) or (b & yes) & (a >> 1) for a, b in combinations(below, 2)):
                apart.add(node)
    return apart


Item = tuple[float, tuple["State", ...]]
"""Log weight, and one state of each stream."""


class Listed:
    """A stream as a list that grows when it is read."""

    def __init__(self, stream: Iterator[Item]) -> None:
        self.stream = stream
        self.items: list[Item] = []

    def get(self, i: int) -> Item | None:
        """The i-th best, from 0; None past the last."""
        while len(self.items) <= i:
            found = next(self.stream, None)
            if found is None:
                return None
            self.items.append(found)
        return self.items[i]


def _pairs(left: Listed, right: Listed) -> Iterator[Item]:
    """The combinations of two streams, non-increasing; ties by the first stream's place, then the second's."""
    queue: list[tuple[float, int, int]] = []
    following = [(0, 0)]
    while True:
        for a, b in following:
            if (first := left.get(a)) is not None and (second := right.get(b)) is not None:
                heapq.heappush(queue, (-bucket(first[0] + second[0]), a, b))
        if not queue:
            return
        _, a, b = heapq.heappop(queue)
        first, second = left.items[a], right.items[b]
        yield first[0] + second[0], (*first[1], *second[1])
        following = [(a, b + 1), (a + 1, 0)] if b == 0 else [(a, b + 1)]


def merged(streams: list[Iterator[tuple[float, State]]]) -> Iterator[Item]:
    """All combinations of one state of each stream, non-increasing in the sum of log weights.

    Of no streams, the empty one.
    """
    level: list[Iterator[Item]] = [((log_p, (state,)) for log_p, state in states) for states in streams]
    while len(level) > 1:
        pairs = [_pairs(Listed(a), Listed(b)) for a, b in zip(level[::2], level[1::2], strict=False)]
        level = pairs + level[len(level) - len(level) % 2 :]
    return level[0] if level else iter([(0.0, ())])


Reply = dict[str, Any]
MOST_TIED = 1000
"""Worlds of one probability that are put into order together; of more, the first so many are."""
FIRST_WAIT = 0.05
"""Seconds until the worlds found so far are told for the first time."""


def ranked(document: dict[str, Any], tell: Callable[[Reply], None] | None = None) -> Reply:
    """The document of the ``number`` best worlds.

    ``{"worlds": [{"p", "holds": [atom, ...], "choices": [literal, ...]}, ...], "log_evidence", "all"}``

    ``tell`` gets what was found on the way, marked ``partial``. Raises InconsistentError, ProgramError.
    """
    request, program = prepared(document, ask_something=True)
    found = program.ground
    texts = [
        (text, found.asked[number - 1][1])
        for goals in grouped(request, found, range(1, len(found.asked) + 1))
        for text, number in goals
    ]
    worlds = _Worlds(program, texts, _choice_names(request, program))
    rows: list[Reply] = []
    log_evidence = float(program.log_mass([()])[0])
    wait, last = FIRST_WAIT, time.monotonic()
    for row in worlds.ranked(document["number"]):
        rows.append(row)
        if tell is not None and document.get("anytime") and time.monotonic() - last > wait:
            tell({"worlds": rows, "log_evidence": log_evidence, "partial": True})
            wait, last = wait * 1.3, time.monotonic()
    return {"worlds": rows, "log_evidence": log_evidence, "all": len(rows) < document["number"]}


class _Worlds:
    """A program's query atoms, its factors, and what is said of them more than once."""

    def __init__(self, program: Compiled, texts: list[tuple[str, Literal]], names: list[list[str]]) -> None:
        self.texts = [text for text, _ in texts]
        known = [program.known(literal) for _, literal in texts]
        atoms = dict.fromkeys(abs(lit) for (_, lit), value in zip(texts, known, strict=True) if lit and value is None)
        factors = factors_of(program, list(atoms))
        self.deciding = [factor for factor in factors if factor.variables]
        self.certain = [value is not True for value in known]
        self.places = [_places(factor, [lit for _, lit in texts]) for factor in self.deciding]
        fixed = [v if value else -v for v, value in program.residue.fixed.items()]
        self.settled = {*fixed, *(literal for factor in factors if not factor.variables for literal in factor.best(()))}
        used = _used(program.ground, [literal for _, literal in texts])
        self.alternatives = [
            (a.variables, names_of)
            for a, names_of in zip(program.ground.alternatives, names, strict=True)
            if not used.isdisjoint(a.variables)
        ]
        self.completions: dict[tuple[int, State], list[int]] = {}

    def ranked(self, number: int) -> Iterator[Reply]:
        """The best worlds; of equally probable ones that come first in which earlier atoms hold."""
        told = 0
        for tied in _ties(merged([factor.states() for factor in self.deciding]), number):
            rows = sorted((self._missing(states), log_p, states) for log_p, states in tied)
            for missing, log_p, states in rows[: number - told]:
                holds = [text for text, absent in zip(self.texts, missing, strict=True) if not absent]
                yield {"p": math.exp(log_p), "holds": holds, "choices": self._choices(states)}
            told += len(rows)
            if told >= number:
                return

    def _missing(self, states: tuple[State, ...]) -> list[bool]:
        """Of each query atom, whether it fails."""
        missing = self.certain.copy()
        for places, state in zip(self.places, states, strict=True):
            for i, atom, holds in places:
                missing[i] = state[atom] != holds
        return missing

    def _choices(self, states: tuple[State, ...]) -> list[str]:
        """The most probable total choice; of an alternative none of whose choices was made, each one's negation."""
        true = self.settled.union(*(self._completion(i, state) for i, state in enumerate(states)))
        found = []
        for variables, names in self.alternatives:
            made = [name for name, v in zip(names, variables, strict=True) if v in true]
            found += made or [f"\\+{name}" for name in names]
        return found

    def _completion(self, i: int, state: State) -> list[int]:
        if (i, state) not in self.completions:
            self.completions[i, state] = self.deciding[i].best(state)
        return self.completions[i, state]


def _choice_names(request: Request, program: Compiled) -> list[list[str]]:
    """The choices of each alternative as users write them.

    Where the head alone does not tell which choice it is, with its line.

    It does not where two choices have the same head, or where another clause can give it too: then it may hold though
    the choice fell otherwise.
    """
    terms = [[name() for name in alternative.names] for alternative in program.ground.alternatives]
    texts = [[shown(term, request.names) for term in of_one] for of_one in terms]
    count = Counter(text for of_one in texts for text in of_one)
    clauses = [(s, {head.signature for head in heads(s)}) for s in request.statements]
    ways = Counter(signature for _, signatures in clauses for signature in signatures)
    by_rules = {
        n
        for s, signatures in clauses
        if isinstance(s, (Clause, AnnotatedDisjunction))
        for n in signatures
        if ways[n] > 1
    }

    def told(text: str, term: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
        line = line_of(request, term) if count[text] > 1 or term.signature in by_rules else None
        return text if line is None else f"{text} (line {line})"

    return [[told(*pair) for pair in zip(*both, strict=True)] for both in zip(texts, terms, strict=True)]


def _used(found: Ground, asked: list[Literal]) -> set[int]:
    """The variables that what is asked is made of, and whatever evidence says that has some of them in it."""
    siblings = {v: alternative.variables for alternative in found.alternatives for v in alternative.variables}

    def under(variable: int) -> Iterator[int]:
        children = found.gates[variable].children if variable in found.gates else ()
        return (abs(child) for child in (*children, *siblings.get(variable, ())) if child)

    used = set(reached([abs(literal) for literal in asked if literal], under))
    waiting = [set(reached([abs(literal)], under)) for literal in found.observed]
    while tied := [each for each in waiting if not used.isdisjoint(each)]:
        used = used.union(*tied)
        waiting = [each for each in waiting if used.isdisjoint(each)]
    return used


def _places(factor: Factor, literals: list[Literal]) -> list[tuple[int, int, bool]]:
    """Of each query atom that the factor decides.

    Its place, the atom in the factor's states, and the value that makes it hold.
    """
    order = {v: i for i, v in enumerate(factor.variables)}
    return [(place, order[abs(lit)], lit > 0) for place, lit in enumerate(literals) if lit and abs(lit) in order]


def _ties(
    worlds: Iterator[tuple[float, tuple[State, ...]]], number: int
) -> Iterator[list[tuple[float, tuple[State, ...]]]]:
    """The worlds in runs of equal probability, cut where they are too long to be put into order."""
    run: list[tuple[float, tuple[State, ...]]] = []
    for world in worlds:
        if run and (bucket(world[0]) != bucket(run[0][0]) or len(run) >= number + MOST_TIED):
            yield run
            run = []
        run.append(world)
    if run:
        yield run
