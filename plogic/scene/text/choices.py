"""Layer 3 of the program: the choices of each reading, and the evidence that belongs to them (§8).

Labels are expressions over the facts of layers 1 and 2 (dv, hit rates, priors), so that who edits such a number changes
what follows from it (§9.8). Score: the choices that make P(present(H) | its occluders) = P(ev). Posterior: which
instance is which hypothesis, what hits, what causes what.
"""

from collections import Counter
from collections.abc import Iterable, Iterator

from plogic.base.bounds import LEAST, bounded
from plogic.base.walk import by_key
from plogic.facts.hypothesis import Hypothesis
from plogic.scene.readings.standing import Standing
from plogic.scene.readings.world_weights import DEFAULT_PRIOR, lifted_smoothing, unmatched
from plogic.scene.text.layout import Writer, disjunction, number, possible_causes
from plogic.scene.text.measures import contexts, key_of


def variables(w: Writer, keys: Iterable[str]) -> dict[str, str]:
    """Atom of a feature type → the variable that stands for its dv: ``corner`` → ``Corner``."""
    names: dict[str, str] = {}
    for key in keys:
        name = key.capitalize() if key.isidentifier() and key == w.names.labels.get(key) else f"V{len(names) + 1}"
        while name in names.values():
            name += "_"
        names[key] = name
    return names


def drawn(w: Writer) -> Iterator[str]:
    """``(1-Apex)/S::drawn(apex); ...``: of which type a feature is that is drawn from Σo, P(dv) (§5.1)."""
    of = variables(w, [w.names.atom(name) for name in w.scene.situation.dv])
    if of:
        yield "% A feature drawn from Σo is of type F with P(dv(F)) = 1 - dv(F), over their sum, which is 1 (§5.1)."
        known = [f"dv({key}, {name})" for key, name in of.items()]
        total = " + ".join(f"(1-{name})" for name in of.values())
        heads = [(f"(1-{name})/S", f"drawn({key})") for key, name in of.items()]
        yield disjunction(heads, ", ".join([*known, f"S is {total}", "S > 0"]))


def choices(w: Writer) -> Iterator[str]:
    """The choices of the situation's reading."""
    yield from drawn(w)
    yield ""
    yield from _score(w) if w.scene.situation.reading == "score" else _posterior(w)


def _score(w: Writer) -> Iterator[str]:
    """One alternative per hypothesis, or per cyclic component."""
    cyclic = [block for block in w.graph.blocks if len(block) > 1]
    for i, block in enumerate(cyclic, start=1):
        yield from block_facts(w, i, block)
        yield from _joint(w, i, block)
    members = {name for block in cyclic for name in block}
    yield "% P(ev) of a hypothesis in a context is a probabilistic fact (§5.4)."
    yield "P::ev_holds(H, C) :- ev_chance(H, C, P)."
    for h in w.scene.situation.hypotheses:
        if h.id not in members:
            yield w.fact("alone", h.id)
            if w.scene.situation.reconsider != "drop":
                yield from _picking(w, h)
    if w.scene.situation.reconsider != "drop" and lifted_smoothing(w.scene) > 0:
        yield "% Smoothing: with chance E a hypothesis is present, and with chance E absent, whatever is picked, where its ev is defined."
        yield "E::luck(H, yes); E::luck(H, no); (1-2*E)::luck(H, as_is) :- alone(H), ev_in(H, [], _), smoothing(E)."


def _picking(w: Writer, h: Hypothesis) -> Iterator[str]:
    """``Corner/S::pick(h2, 'body/base_sw'); ...``: dv_F/Σdv over the features in the image."""
    features = [f for f in h.features if f.in_image]
    least = LEAST * sum(f.dv for f in features)
    if least == 0:
        yield f"% {w.names.atom(h.id)}: no feature in the image, or every dv is 0: ev is undefined, never present."
        return
    typed = {key for f in features if (key := key_of(w, f)) == w.names.atom(f.type)}
    of = variables(w, sorted(typed))
    seen = [(f, of.get(key_of(w, f)) or number(max(f.dv, least))) for f in features if f.dv > 0 or key_of(w, f) in of]
    count = Counter(name for _, name in seen)
    total = " + ".join((f"{n}*" if n > 1 else "") + name for name, n in count.items())
    known = [f"dv({key}, {name})" for key, name in of.items()]
    heads = [(f"{name}/S", f"pick({w.feature(h, f)})") for f, name in seen]
    yield disjunction(heads, ", ".join([*known, f"S is {total}", "S > 0"]))


def block_facts(w: Writer, i: int, block: tuple[str, ...]) -> Iterator[str]:
    """What a cyclic component is made of: its members, its joint states, and what hides some of it from outside."""
    yield f"% {w.atoms(*block)} occlude each other in a cycle: decided jointly."
    states = ", ".join(w.list(state) for state in contexts(block))
    yield f"block({i}, {w.list(block)}, [{states}]). occluders(block({i}), {w.list(w.graph.outside(block))})."


def _joint(w: Writer, i: int, block: tuple[str, ...]) -> Iterator[str]:
    """One alternative a context over the joint states."""
    states = contexts(block)
    shares = [f"P{n}" for n in range(len(states))]
    heads = [(p, f"joint({i}, C, {w.list(state)})") for p, state in zip(shares, states, strict=True)]
    yield disjunction(heads, f"context(block({i}), C), joint_shares({i}, C, [{', '.join(shares)}])")


def _posterior(w: Writer) -> Iterator[str]:
    """One alternative per instance and per claimed appearance, one hit per candidate feature."""
    yield "% Rivals for one instance are one alternative: they share the prior of their type; else there is none."
    for members in by_key((h.group, h) for h in w.scene.situation.hypotheses).values():
        types = list(dict.fromkeys(h.type for h in members))
        share = {name: f"P{i}" if len(types) > 1 else "P" for i, name in enumerate(types, 1)}
        body = [f"prior_share({w.names.atom(name)}, {len(members)}, {p})" for name, p in share.items()]
        yield disjunction([(share[h.type], w.fact("present", h.id)[:-1]) for h in members], ", ".join(body))
    yield "% Each expected feature is detected with its hit rate."
    yield "P::hit(H, F) :- candidate(H, F), feature_rate(H, F, P)."
    yield "% Each claimed appearance has one cause: densities over their sum (bounded, so that ProbLog can read them)."
    for appearance in w.scene.claimants:
        heads = possible_causes(w, appearance)
        nothing = f"% {w.names.atom(appearance)}: every density is 0: nothing can cause it."
        yield disjunction(heads) if heads else nothing
    if w.scene.situation.support is not None or any(h.pixel_table is not None for h in w.scene.situation.hypotheses):
        yield "% A case is as likely as evidence tells, over the most that is told of any, in N steps that ProbLog can read."
        yield "P::told_fits(E, C, K) :- told(E, C, L), told_most(E, M), told_steps(E, N), between(1, N, K), P is exp((L - M) / N)."


def pixel_facts(w: Writer) -> Iterator[str]:
    """``pixel_occluders(h1, [h2]). pixels(h1, [], 8.3). pixels(h1, [h2], 1.2).``; nothing where no photo was asked."""
    told = [(h, h.pixel_table) for h in w.scene.situation.hypotheses if h.pixel_table is not None]
    if told:
        yield "% What the photo's pixels say of a hypothesis, log-odds, by who is present of those before it (§9.10)."
    for h, table in told:
        me = w.names.atom(h.id)
        if table.left_out:
            yield f"% {me}: not looked at before it: {w.atoms(*table.left_out)}"
        yield f"pixel_occluders({me}, {w.list(table.occluders)})."
        yield from (f"pixels({me}, {w.list(context)}, {number(odds)})." for context, odds in table.rows())


def rates(w: Writer) -> Iterator[str]:
    """``prior(t2, 0.5). hit_rate(corner, 0.8).``; a feature with another rate than its type has its own."""
    situation = w.scene.situation
    types = dict.fromkeys(h.type for h in situation.hypotheses) | dict.fromkeys(situation.types)
    yield from (
        f"prior({w.atoms(name)}, {number(bounded(situation.priors.get(name, DEFAULT_PRIOR)))})." for name in types
    )
    seen = [(h, f) for h in situation.hypotheses for f in h.features if h.expects(f)]
    of_type: dict[str, set[float]] = {name: {rate} for name, rate in situation.hit_rates.items()}
    for _, f in seen:
        of_type.setdefault(f.type, set()).add(f.hit_rate)
    for name, some in of_type.items():
        if len(some) == 1:
            yield f"hit_rate({w.names.atom(name)}, {number(bounded(*some))})."
    for h, f in seen:
        if len(of_type[f.type]) > 1:
            yield f"own_rate({w.feature(h, f)}, {number(bounded(f.hit_rate))})."


def evidence_of_data(w: Writer) -> Iterator[str]:
    """Γ, and what is not in Γ."""
    yield from (f"evidence(explained({w.names.atom(appearance)}))." for appearance in w.scene.claimants)
    for h in w.scene.situation.hypotheses:
        yield from (f"evidence(\\+ missed({w.feature(h, f)}))." for f in unmatched(h))
    told = (h.id for h in w.scene.situation.hypotheses if h.pixel_table is not None)
    yield from (f"evidence(drawn_right({w.names.atom(name)}))." for name in told)
    if w.scene.situation.support is not None:
        posed = Standing(w.scene.situation, w.scene.situation.support).posed
        yield from (f"evidence(stands_right({w.names.atom(name)}))." for name in posed)
