"""Numbers for proofs: the relevant evidence, compiled with the goals, and P(choices | evidence) from the circuit."""

import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from problog.cycles import _break_cycles
from problog.formula import LogicDAG
from problog.logic import Constant, Term

from plogic.base.errors import InconsistentError, NegativeCycleError
from plogic.logic.dnnf.cnf import IMPOSSIBLE
from plogic.logic.dnnf.compiled import Compiled, compiled
from plogic.logic.grounding.ground_program import Choice as Share
from plogic.logic.grounding.ground_program import Gate, Ground, Literal, gate_of, ground_from, share_of
from plogic.logic.proof.cone import Choice, Cone, Selection, Steps
from plogic.logic.proof.ground_proofs import Grounding, Key

COLUMNS = 256
"""Evaluations that the circuit does at once."""
MOST_PARTS = 4096
"""Disjoint parts into which a union of explanations is cut; where that does not suffice, its probability is an
interval."""


@dataclass
class Mass:
    """``heads[choice][i]``: the circuit's variable of the choice's i-th head, for heads that a question depends on."""

    compiled: Compiled
    heads: Mapping[Choice, Mapping[int, int]]
    log_evidence: float = field(init=False)

    def __post_init__(self) -> None:
        self.log_evidence = float(self.compiled.log_mass([()])[0])

    def log_given(self, selections: Sequence[Selection]) -> list[float]:
        """Ln P(all these choices | evidence) of each selection; −inf where they contradict the evidence."""
        return self._log_given([self._condition(list(selection.items()), ()) for selection in selections])

    def _log_given(self, conditions: Sequence[tuple[list[Literal], float]]) -> list[float]:
        found: list[float] = []
        for start in range(0, len(conditions), COLUMNS):
            part = conditions[start : start + COLUMNS]
            masses = self.compiled.log_mass([literals for literals, _ in part]).tolist()
            found += [min(0.0, m + factor - self.log_evidence) for m, (_, factor) in zip(masses, part, strict=True)]
        return found

    def _condition(self, taken: list[tuple[Choice, int]], excluded: Sequence[int]) -> tuple[list[Literal], float]:
        """Literals, and the logarithm of the share that a head has of what the circuit does not tell apart."""
        literals: list[Literal] = [-v for v in excluded]
        factor = 0.0
        for choice, head in taken:
            known = self.heads[choice]
            if head in known:
                literals.append(known[head])
            else:
                literals += [-v for v in known.values()]
                factor += math.log(choice.probability(head)) - math.log(self._unknown(choice))
        return literals, factor

    def _unknown(self, choice: Choice) -> float:
        """P(none of the heads that the circuit knows)."""
        return math.fsum(choice.probability(i) for i in choice.domain if i not in self.heads[choice])

    def union(self, selections: Sequence[Selection]) -> tuple[float, float]:
        """P(at least one of these sets of choices | evidence), an interval of one point unless it is large."""
        conditions: list[tuple[list[Literal], float]] = []
        done = self._parts([dict(s) for s in selections], [], [], conditions)
        if done:
            total = math.fsum(map(math.exp, self._log_given(conditions)))
            return min(1.0, total), min(1.0, total)
        each = [math.exp(p) for p in self.log_given(selections)]
        return max(each, default=0.0), min(1.0, math.fsum(each))

    def _parts(
        self,
        left: list[Selection],
        taken: list[tuple[Choice, int]],
        out: list[int],
        conditions: list[tuple[list[Literal], float]],
    ) -> bool:
        """Cut the union into disjoint conjunctions.

        Along one choice, each head that some selection takes, and what is left.
        """
        if not left or len(conditions) > MOST_PARTS:
            return len(conditions) <= MOST_PARTS
        if any(not selection for selection in left):
            conditions.append(self._condition(taken, out))
            return True
        counts = Counter(choice for selection in left for choice in selection)
        choice = max(counts.items(), key=lambda item: (item[1], item[0].order))[0]
        others = [s for s in left if choice not in s]
        known = self.heads[choice]
        named = sorted({s[choice] for s in left if choice in s})
        if others and any(head not in known for head in named):
            named = sorted(choice.domain)
        for head in named:
            rest = [{c: i for c, i in s.items() if c != choice} for s in left if s.get(choice, head) == head]
            if not self._parts(rest, [*taken, (choice, head)], out, conditions):
                return False
        remaining = others if set(named) < choice.domain else []
        return self._parts(remaining, taken, [*out, *(known[h] for h in named if h in known)], conditions)


def prior(selection: Selection) -> float:
    """The product of its choices' probabilities (ICL)."""
    return math.prod(choice.probability(taken) for choice, taken in selection.items())


Evidence = list[tuple[Any, int, int]]


@dataclass(frozen=True)
class Numbers:
    """``literals[i]`` is the i-th key that was asked for; ``atoms``: variable → its choice and head."""

    ground: Ground
    compiled: Compiled
    literals: tuple[Literal, ...]
    atoms: dict[int, tuple[Choice, int]]
    mass: Mass

    def cone(self, literal: Literal, steps: Steps) -> Cone:
        """What a literal depends on."""
        return Cone(self.ground, literal, self.atoms, steps)

    def joint(self, conditions: Sequence[Sequence[Literal]]) -> list[float]:
        """P(all these literals | evidence) of each conjunction."""
        masses = self.compiled.log_mass(conditions).tolist() if conditions else []
        return [min(1.0, math.exp(m - self.mass.log_evidence)) for m in masses]


def numbers_of(grounding: Grounding, keys: Sequence[Key], steps: Steps) -> Numbers:
    """Compile what the keys depend on with the evidence that shares a choice with them, through other evidence too.

    The rest of the evidence is independent of them and only has to be possible. Raises InconsistentError where it is
    not, LimitError.
    """
    evidence = grounding.evidence()
    near, far = _split(grounding, keys, evidence)
    for _, key, sign in evidence:
        _require(key is not None if sign > 0 else key != 0)
    if far:
        _possible(grounding, [(n, k, s) for n, k, s in far if k], steps)
    ground = _part(grounding, keys, near)
    made = compiled(ground)
    atoms = _atoms(grounding, ground)
    heads: dict[Choice, dict[int, int]] = {}
    for variable, (choice, head) in atoms.items():
        heads.setdefault(choice, {})[head] = variable
    return Numbers(ground, made, tuple(literal for _, literal in ground.asked), atoms, Mass(made, heads))


def _require(possible: bool) -> None:  # noqa: FBT001 - the condition itself
    if not possible:
        raise InconsistentError(IMPOSSIBLE)


def _part(grounding: Grounding, keys: Sequence[Key], evidence: Evidence) -> Ground:
    """The ground program of the keys, in their order, with this evidence.

    Its cycles broken by ProbLog where it has any.
    """
    formula = grounding.formula
    asked = [(Term("asked", Constant(i)), key) for i, key in enumerate(keys)]
    observed = [(name, key if sign > 0 else formula.negate(key)) for name, key, sign in evidence]
    return ground_from(lambda i: _node(formula, i), asked, observed) or _broken(formula, asked, observed)


def _broken(formula: Any, asked: list[tuple[Any, Key]], observed: list[tuple[Any, Key]]) -> Ground:  # noqa: ANN401 - ProbLog's formula
    dag = LogicDAG()
    translation: dict[int, Any] = defaultdict(list)

    def unrolled(key: Key) -> Key:
        return _break_cycles(formula, dag, key, [], set(), set(), translation) if key else key

    asked = [(name, unrolled(key)) for name, key in asked]
    observed = [(name, unrolled(key)) for name, key in observed]
    made = ground_from(lambda i: _node(dag, i), asked, observed)
    if made is None:
        raise NegativeCycleError("a negation depends on itself (negative cycle)")
    return made


def _node(formula: Any, i: int) -> Gate | Share:  # noqa: ANN401 - ProbLog's formula
    content = formula.get_node(i)
    gate = gate_of(content)
    if gate is not None:
        return gate
    group = ("atom", i) if content.group is None else ("group", content.group)
    return Share(share_of(content.probability), group, lambda: content.identifier)


def _atoms(grounding: Grounding, ground: Ground) -> dict[int, tuple[Choice, int]]:
    return {
        variable: grounding.choice_of(name())
        for alternative in ground.alternatives
        for variable, name in zip(alternative.variables, alternative.names, strict=True)
    }


def _split(grounding: Grounding, keys: Sequence[Key], evidence: Evidence) -> tuple[Evidence, Evidence]:
    """The evidence that hangs together with the keys, and the rest."""
    far = [(observation, _choices(grounding, [observation[1]])) for observation in evidence]
    reached = _choices(grounding, keys)
    while near := [choices for _, choices in far if not choices or not choices.isdisjoint(reached)]:
        far = [(observation, choices) for observation, choices in far if choices and choices.isdisjoint(reached)]
        reached = reached.union(*near)
    left = {id(observation) for observation, _ in far}
    return [o for o in evidence if id(o) not in left], [observation for observation, _ in far]


def _choices(grounding: Grounding, keys: Sequence[Key]) -> set[Any]:
    """What tells the alternatives under the keys apart."""
    contents = ((node, grounding.formula.get_node(node)) for node in grounding.under(keys))
    return {node if c.group is None else c.group for node, c in contents if type(c).__name__ == "atom"}


def _possible(grounding: Grounding, evidence: Evidence, steps: Steps) -> None:
    """Raises InconsistentError where no world satisfies this evidence."""
    formula = grounding.formula
    both = formula.add_and([key if sign > 0 else formula.negate(key) for _, key, sign in evidence])
    ground = _part(grounding, [both], [])
    _require(Cone(ground, ground.asked[0][1], _atoms(grounding, ground), steps).possible())
