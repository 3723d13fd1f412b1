"""Layer 4 of the program: Σc and D1-D8 as rules; no object type's name occurs in them (§1).

``FALLBACKS`` keeps ProbLog from calling a predicate unknown that merely has no facts in this image.
"""

import re
from collections.abc import Iterable, Iterator
from functools import cache

from plogic.base.bounds import LEAST
from plogic.facts.situation import Situation
from plogic.facts.vocabulary import VOCABULARY, entries

FACTS = (
    "object_type/1", "type_opaque/1", "type_part/2", "type_feature/3", "type_look/4", "facet/2", "face/2", "object_part/1",
    "hypothesis/2", "instance/2", "hypotheses/1", "hypotheses_of/2", "in_image/2", "in_lobe/2", "self_hidden/2",
    "behind_surface/3", "match/3", "preferred/3", "datum/2", "overlap/2", "rival_pair/2", "exclusive/2", "outline_relation/3",
    "outline_roc/3", "part_relation/3", "part_roc/3", "at/4", "distance/2", "body_middle/4", "body_nearest/2", "up_direction/3", "inside_image/1",
    "cut_by_image/1", "body_gap/3", "body_over/2", "body_on/2", "body_on_both/3", "weighs/1", "open_foot/3", "body_rests/2", "dv/2",
    "rank/2", "occluders/2", "cells/3", "drawn/1", "said_roc/4", "said_relation/4", "stands/1", "support/1", "footing/3",
)  # fmt: skip
"""Predicates of facts, and of choices, of which an image may have none; those of one reading alone are in ``ONLY``."""
ONLY = {
    "score": ("smoothing/1", "alone/1", "pick/2", "luck/2", "joint/3"),
    "posterior": ("present/1", "prior/2", "hit_rate/2", "own_rate/3", "hit/2", "chosen/2"),
}

SOME = (
    "pixel_occluders/2", "pixels/3", "told_fits/3", "rests_chance/1", "plane/5", "plane_prior/2", "way_to_stand/5",
    "level/3", "by_chance/1",
)  # fmt: skip
"""Predicates of facts, and of a choice, of programs in which a photo's pixels, or supports, are told."""
LONGEST = 15.0
"""Log-odds that one choice tells: e to less than -18 is below ``LEAST``."""

OBJECT_TYPES = r"""
% What is said of a hypothesis follows from its type (§2).
feature_of(H, F, K) :- hypothesis(H, T), type_feature(T, F, K).
part_of(X, Y) :- hypothesis(H, T), type_part(V, W), node_of(V, T, H, X), node_of(W, T, H, Y).
node_of(T, T, H, H).
node_of(T/P, T, H, H/P).
opaque_surface(H) :- hypothesis(H, T), type_opaque(T).

% §4.2: what bounds an object: its surface, the facets and faces of that, and the surfaces of its parts.
bounds(S, H) :- hypothesis(H, _), S = surface(H).
bounds(S, H) :- hypothesis(H, T), facet(T, Fs), S = facet(H, Fs).
bounds(S, H) :- hypothesis(H, T), face(T, Fs), S = face(H, Fs).
bounds(S, H) :- hypothesis(H, T), object_part(T/P), S = surface(H/P).
"""

EV = r"""
% §5.4: ev from dv and the four cells.
ev_in(H, C, V) :- cells(H, C, Rows), cells_weighed(Rows, Good, Bad), Good + Bad > 0, V is (Good - Bad) / (Good + Bad).
cells_weighed([], 0.0, 0.0).
cells_weighed([row(F, A, C, B, D) | Rest], Good, Bad) :-
  cell_weight(F, V), cells_weighed(Rest, G, N), Good is G + V * (A + B), Bad is N + V * (C + D).
cell_weight(F, V) :- dv(F, V).
cell_weight(own(V), V).

% A context of H: those of its occluders that are present.
context(H, C) :- occluders(H, Gs), those_present(Gs, C).
those_present([], []).
those_present([G | Gs], [G | C]) :- present(G), those_present(Gs, C).
those_present([G | Gs], C) :- \+ present(G), those_present(Gs, C).
"""

BOUNDED = r"""
% What is possible but very improbable stays possible for ProbLog.
bounded_chance(X, X) :- X =< 0.0.
bounded_chance(X, X) :- X >= 1.0.
bounded_chance(X, P) :- X > 0.0, X < 1.0, P is min(max(X, LEAST), 1 - LEAST).
""".replace("LEAST", repr(LEAST))

CHANCE = r"""
% P(ev), smoothed where the knowledge base's user asks for it.
ev_chance(H, C, P) :- ev_in(H, C, V), smoothing(E), Q is E + (1 - 2 * E) * (V + 1) / 2, bounded_chance(Q, P).
"""

EXPECTED = r"""% D4, D7: what a hypothesis alone leads to expect, and what a present opaque object, no rival, hides.
own_host_hides(H, F) :- self_hidden(H, F), opaque(H).
candidate(H, F) :- in_image(H, F), in_lobe(H, F), \+ own_host_hides(H, F).
hidden(H, F) :- behind_surface(H, F, G), G \= H, opaque(G), \+ rival(H, G), present(G).
in_view(H, F) :- candidate(H, F), \+ hidden(H, F).
"""
"""D7: Expected is ``in_view`` of a hypothesis that is present; stated as a function by ``plogic.facts.hypothesis``."""
COMMON = (
    r"""
% A3: proper parts; belongs(X, H): node X is of the tree of hypothesis H.
proper_part(X, Y) :- part_of(X, Y).
proper_part(X, Y) :- part_of(X, Z), proper_part(Z, Y).
belongs(H, H) :- hypothesis(H, _).
belongs(H/X, H) :- part_of(H/X, _).

% §4.1: rivals never hide each other.
rival(X, Y) :- rival_pair(X, Y).
rival(X, Y) :- rival_pair(Y, X).

"""
    + EXPECTED
    + r"""claims(H, F, A) :- match(H, F, A), present(H), in_view(H, F).

% D5, feature form: Y has a self-visible feature, and every one of them is behind X.
not_behind(Y, X) :- candidate(Y, F), \+ behind_surface(Y, F, X).
all_behind(Y, X) :- behind_surface(Y, F, X), candidate(Y, F), X \= Y, \+ not_behind(Y, X).
"""
)

FOUND = r"""
% D8: a feature is detected if the hypothesis' one matching gives it an appearance.
found(H, F) :- match(H, F, _), in_image(H, F).
"""

FOUND_REASSIGN = r"""
% D8; mode reassign: an unexpected feature loses an appearance that an expected feature of another present object, no rival, claims.
found(H, F) :- match(H, F, A), in_image(H, F), \+ taken_away(H, F, A).
taken_away(H, F, A) :- \+ in_view(H, F), match(G, E, A), G \= H, \+ rival(H, G), candidate(G, E), present(G), in_view(G, E).
"""

SUPPORTED = r"""
% A hypothesis counts only if at least one of its features is detected: a fully hidden phantom would have ev = +1.
supported(H) :- match(H, F, _), found(H, F).
"""

CONCORDANT = r"""
% §8, score: concordant means Expected <=> Detected, so that P(present(H) | its occluders) is exactly P(ev).
concordant(H, F) :- in_view(H, F), found(H, F).
concordant(H, F) :- \+ in_view(H, F), \+ found(H, F).
"""

LINEAR = (
    CONCORDANT
    + r"""present(H) :- alone(H), supported(H), agrees(H).
"""
)

AGREES = r"""agrees(H) :- pick(H, F), concordant(H, F).
"""

AGREES_SMOOTHED = r"""agrees(H) :- luck(H, yes).
agrees(H) :- luck(H, as_is), pick(H, F), concordant(H, F).
"""

DROP = r"""
% §8, score, mode drop: P(ev) for each set of accepted occluders that change a cell.
present(H) :- alone(H), supported(H), context(H, C), ev_holds(H, C).
"""

JOINT = r"""
% Mutual occlusion: the hypotheses of a cyclic component are decided together. A joint state S has the weight Π_{h∈S} p_h(S) · Π_{h∉S} (1 - p_h(S)),
% over those that Σc allows; where these weigh nothing over all; where these weigh nothing nobody is present.
present(H) :- block(B, Hs, _), in_state(H, Hs), joint(B, _, S), in_state(H, S).
joint_shares(B, C, Ps) :- lawful_weights(B, C, Ws), weights_total(Ws, W), W > 0, weights_shared(Ws, W, Ps).
joint_shares(B, C, Ps) :-
  lawful_weights(B, C, Ls), weights_total(Ls, L), L =< 0,
  block(B, Hs, Ss), state_weights(Ss, Hs, C, Ws), joint_shares_of(Ws, Ps).
joint_shares_of(Ws, Ps) :- weights_total(Ws, W), W > 0, weights_shared(Ws, W, Ps).
joint_shares_of([V | Vs], [1.0 | Vs]) :- weights_total([V | Vs], W), W =< 0.
lawful_weights(B, C, Ls) :- block(B, Hs, Ss), state_weights(Ss, Hs, C, Ws), lawful_only(Ss, Ws, Ls).
lawful_only([], [], []).
lawful_only([S | Ss], [_ | Ws], [0.0 | Ls]) :- unlawful_state(S), lawful_only(Ss, Ws, Ls).
lawful_only([S | Ss], [W | Ws], [W | Ls]) :- \+ unlawful_state(S), lawful_only(Ss, Ws, Ls).
unlawful_state(S) :- in_state(X, S), in_state(Y, S), state_apart(X, Y).
state_apart(X, Y) :- overlap(X, Y).
state_apart(X, Y) :- exclusive(X, Y).
state_weights([], _, _, []).
state_weights([S | Ss], Hs, C, [W | Ws]) :- state_weight(Hs, S, C, W), state_weights(Ss, Hs, C, Ws).
state_weight([], _, _, 1.0).
state_weight([H | Hs], S, C, W) :- in_state(H, S), state_accepted(H, S, C, P), state_weight(Hs, S, C, V), W is V * P.
state_weight([H | Hs], S, C, W) :- \+ in_state(H, S), state_accepted(H, S, C, P), state_weight(Hs, S, C, V), W is V * (1 - P).
state_accepted(H, S, C, P) :- occluders(H, Gs), state_occluders(Gs, S, C, D), state_chance(H, D, P).
state_chance(H, D, P) :- state_seen(H, D), ev_chance(H, D, P).
state_chance(H, D, 0.0) :- \+ state_acceptable(H, D).
state_acceptable(H, D) :- state_seen(H, D), ev_in(H, D, _).
state_seen(H, D) :- cells(H, D, Rows), in_state(row(_, A, _, _, N), Rows), A + N > 0.
state_occluders([], _, _, []).
state_occluders([G | Gs], S, C, [G | D]) :- state_or_context(G, S, C), state_occluders(Gs, S, C, D).
state_occluders([G | Gs], S, C, D) :- \+ state_or_context(G, S, C), state_occluders(Gs, S, C, D).
state_or_context(G, S, _) :- in_state(G, S).
state_or_context(G, _, C) :- in_state(G, C).
in_state(X, [X | _]).
in_state(X, [_ | Xs]) :- in_state(X, Xs).
weights_total([], 0.0).
weights_total([W | Ws], S) :- weights_total(Ws, V), S is V + W.
weights_shared(Ws, S, Ps) :- weights_over(Ws, S, Xs), weights_total(Xs, X), weights_over(Xs, X, Ps).
weights_over([], _, []).
weights_over([W | Ws], S, [P | Ps]) :- X is W / S, weight_lifted(X, P), weights_over(Ws, S, Ps).
weight_lifted(X, X) :- X =< 0.
weight_lifted(X, P) :- X > 0, P is max(X, LEAST).
""".replace("LEAST", repr(LEAST))

RATES = r"""
% The prior of a type is shared by the N rivals for one instance; a feature has the hit rate of its type, or its own.
prior_share(T, N, P) :- prior(T, Q), X is Q / N, bounded_chance(X, P).
feature_rate(H, F, P) :- own_rate(H, F, P).
feature_rate(H, F, P) :- feature_of(H, F, K), hit_rate(K, P).
"""

POSTERIOR = r"""
% §8, posterior: an appearance has exactly one cause, and every expected feature that hits needs its appearance.
hitting(A, H, F) :- match(H, F, A), present(H), in_view(H, F), hit(H, F).
other_hit(A, H, F) :- match(G, E, A), G/E \= H/F, hitting(A, G, E).
any_hit(A) :- hitting(A, _, _).
explained(A) :- match(H, F, A), chosen(A, H/F), hitting(A, H, F), \+ other_hit(A, H, F).
explained(A) :- chosen(A, noise), \+ any_hit(A).
missed(H, F) :- present(H), in_view(H, F), hit(H, F).
"""

TOLD = r"""
% What evidence tells of a case, in log-odds L, makes it e^L as likely, over the most that is told of any, in N steps.
fits_told(E, C) :- told_steps(E, N), fits_in_steps(E, C, N).
fits_in_steps(_, _, 0).
fits_in_steps(E, C, N) :- N > 0, told_fits(E, C, N), M is N - 1, fits_in_steps(E, C, M).
told_most(E, L) :- told(E, _, L), \+ told_beyond(E, L).
told_beyond(E, L) :- told(E, _, M), M > L.
told_least(E, L) :- told(E, _, L), \+ told_below(E, L).
told_below(E, L) :- told(E, _, M), M < L.
told_steps(E, N) :- told_most(E, M), told_least(E, L), N is max(1, ceiling((M - L) / LONGEST)).
""".replace("LONGEST", repr(LONGEST))

PIXELS = r"""
% §9.10: a hypothesis, present in a context or absent, is as likely as its pixels are: e^L, where it is absent 1.
drawn_right(H) :- pixels_case(H, C), fits_told(pixels(H), C).
pixels_case(H, absent) :- pixel_occluders(H, _), \+ present(H).
pixels_case(H, C) :- pixel_occluders(H, Gs), present(H), those_present(Gs, C).
told(pixels(H), absent, 0.0) :- pixel_occluders(H, _).
told(pixels(H), C, L) :- pixels(H, C, L).
"""

STANCES = r"""
% §9.9: who has a footing is chosen a way to stand: what is present, and what is not, but whose pose stands by chance,
% for nothing is there that excludes it.
has_footing(H) :- present(H).
has_footing(H) :- by_chance(H), \+ present(H), \+ explained_away(H).
explained_away(H) :- overlap(H, X), present(X).
explained_away(H) :- overlap(X, H), present(X).
explained_away(H) :- exclusive(H, X), present(X).
explained_away(H) :- exclusive(X, H), present(X).

% §9.9: a hypothesis whose plane is none of those that it has ways to stand on.
other_plane(H) :- hypothesis(H, _), \+ support(none), \+ own_plane(H).
own_plane(H) :- way_to_stand(H, S, _, _, _), support(S).
"""

STANDING = r"""
% §9.9: a pose is as likely as its footing makes it: ρ = e^L where it stands on what is there, or is free and level above the plane; else 1.
stands_right(H) :- footing_case(H, C), fits_told(footing(H), C).
footing_case(H, free) :- hypothesis(H, _), \+ has_footing(H).
footing_case(H, free) :- has_footing(H), support(none).
footing_case(H, free) :- footing(H, free, _), \+ level_above_plane(H).
footing_case(H, level(S)) :- footing(H, free, _), support(S), level(H, S, _).
footing_case(H, way(S, R)) :- footing(H, S, R), S \= free, to_stand_on(S).
level_above_plane(H) :- support(S), level(H, S, _).
to_stand_on(S) :- support(S).
to_stand_on(X) :- present(X).
told(footing(H), free, 0.0) :- hypothesis(H, _).
told(footing(H), way(S, R), L) :- way_to_stand(H, S, R, _, L).
told(footing(H), level(S), L) :- level(H, S, L).
"""

VIOLATED = r"""
% A4: distinct maximal objects are discrete.
violated(shares_volume(X, Y)) :- overlap(X, Y), present(X), present(Y).
"""

EXCLUSIVE = r"""
% D8: an appearance serves one feature, so those that live on the same appearances exclude each other.
violated(shares_data(X, Y)) :- exclusive(X, Y), present(X), present(Y).
"""

FLOATS = r"""
% Support: nothing floats, touching nothing from above, but for what something holds that the KB does not know.
violated(floats(H)) :- weighs(H), present(H), \+ body_held(H), \+ excused(H).
body_held(H) :- body_rests_on(H, _).
"""


def rules(situation: Situation, *, cyclic: bool) -> list[str]:
    """The rules of a situation's reading and mode, in blocks of text; ``cyclic``: some hide each other in a cycle."""
    reading, reconsider = situation.reading, situation.reconsider
    blocks = [OBJECT_TYPES, COMMON, FOUND_REASSIGN if reading == "score" and reconsider == "reassign" else FOUND]
    blocks += [EV, BOUNDED]
    if reading == "score":
        decide = DROP if reconsider == "drop" else LINEAR + (AGREES_SMOOTHED if situation.smoothing > 0 else AGREES)
        blocks += [CHANCE, SUPPORTED, decide, *([JOINT] if cyclic else []), VIOLATED, EXCLUSIVE]
    else:
        told = [PIXELS] if any(h.pixel_table is not None for h in situation.hypotheses) else []
        told += [STANDING] if situation.support is not None else []
        blocks += [RATES, POSTERIOR, *([TOLD] if told else []), *told, VIOLATED]
    if situation.support is not None:
        blocks.append(STANCES)
    if situation.gravity is not None:
        blocks.append(FLOATS)
    return [block.strip("\n") for block in blocks]


def vocabulary_rules(reading: str) -> list[str]:
    """The clauses of the query vocabulary, each under its meaning."""
    return [f"% {e.usage}: {e.meaning}.\n{e.clause}" for e in entries(reading) if e.clause]


PREDICATE = re.compile(r"(?:^|[.;:] ?|^ +)([a-z_]+)\(", re.MULTILINE)
"""A predicate at the head of a fact, or of a choice, of a line that is no comment."""


def fallbacks(reading: str, told: Iterable[str] = ()) -> Iterator[str]:
    """``name(_, _) :- fail.`` for the predicates of facts and choices of which nothing is told."""
    lines = [line for text in told for line in text.splitlines() if not line.startswith("%")]
    known = set(PREDICATE.findall("\n".join(lines)))
    split = [s.split("/") for s in (*FACTS, *ONLY[reading])]
    clauses = [f"{name}({', '.join('_' * int(arity))}) :- fail." for name, arity in split if name not in known]
    if clauses:
        yield "% Of these there is nothing here."
        yield from (" ".join(clauses[i : i + 4]) for i in range(0, len(clauses), 4))
        yield ""


HEAD = re.compile(r"^([a-z_]+)\((.*?)\)(?: :-|\.)", re.MULTILINE)
"""The head of a clause of the rules, each of which begins a line: its name and its arguments."""
NESTED = re.compile(r"\([^()]*\)|\[[^][]*\]")


@cache
def defined() -> frozenset[str]:
    """Every signature that programs define, in either reading: nobody else may add clauses to it."""
    texts = [
        OBJECT_TYPES, COMMON, FOUND_REASSIGN, EV, BOUNDED, CHANCE, SUPPORTED, LINEAR, AGREES_SMOOTHED, DROP, JOINT, RATES, POSTERIOR, TOLD,
        PIXELS, STANCES, STANDING, VIOLATED, FLOATS,
        *(e.clause for e in VOCABULARY),
    ]  # fmt: skip
    ruled = {
        f"{name}/{NESTED.sub('', NESTED.sub('', arguments)).count(',') + 1}"
        for name, arguments in HEAD.findall("\n".join(texts))
    }
    told = {*FACTS, *ONLY["score"], *ONLY["posterior"], "block/3", "ev_holds/2", "excused/1", "unposed/2", *SOME}
    return frozenset(ruled | told | {e.signature for e in VOCABULARY})
