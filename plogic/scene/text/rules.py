"""Layer 4 of the program: Σc and D1-D8 as rules; no object type's name occurs in them (§1).

``FALLBACKS`` keeps ProbLog from calling a predicate unknown that merely has no facts in this image.
"""

from plogic.facts.situation import Situation
from plogic.facts.vocabulary import VOCABULARY, entries

FALLBACKS = (
    "part_of/2", "feature_of/3", "hypothesis/2", "instance/2", "opaque_surface/1", "in_image/2", "in_lobe/2", "self_hidden/2",
    "behind_surface/3", "match/3", "preferred/3", "datum/2", "overlap/2", "rival_pair/2", "exclusive/2", "outline_relation/3",
    "outline_roc/3", "part_relation/3", "part_roc/3", "at/4", "distance/2", "body_middle/4", "body_nearest/2", "up_direction/3", "inside_image/1",
    "cut_by_image/1", "body_gap/3", "body_over/2", "stands_on/2", "stands_on_both/3", "weighs/1", "open_foot/3", "body_rests/2", "dv/2",
    "rank/2", "ev_given/3", "context/2", "unposed/2", "said_roc/4", "said_relation/4", "stands/1",
)  # fmt: skip

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
present(H) :- alone(H), supported(H), context(H, C), ok(H, C).
"""

JOINT = r"""
% Mutual occlusion: the hypotheses of a cyclic component are decided together.
present(H) :- member_of(H, B), context(B, C), joint(B, C, S), includes(S, H).
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

VIOLATED = r"""
% A4: distinct maximal objects are discrete.
violated(shares_volume(X, Y)) :- overlap(X, Y), present(X), present(Y).
"""

EXCLUSIVE = r"""
% D8: an appearance serves one feature, so those that live on the same appearances exclude each other.
violated(shares_data(X, Y)) :- exclusive(X, Y), present(X), present(Y).
"""

FLOATS = r"""
% Support: nothing floats, but for what something holds that the KB does not know.
violated(floats(H)) :- floats(H), \+ excused(H).
"""


def rules(situation: Situation, *, smoothed: bool) -> list[str]:
    """The rules of a situation's reading and mode, in blocks of text."""
    reading, reconsider = situation.reading, situation.reconsider
    blocks = [COMMON, FOUND_REASSIGN if reading == "score" and reconsider == "reassign" else FOUND]
    if reading == "score":
        decide = DROP if reconsider == "drop" else LINEAR + (AGREES_SMOOTHED if smoothed else AGREES)
        blocks += [SUPPORTED, decide, JOINT, VIOLATED, EXCLUSIVE]
    else:
        blocks += [POSTERIOR, VIOLATED]
    if situation.gravity is not None:
        blocks.append(FLOATS)
    return [block.strip("\n") for block in blocks]


def vocabulary_rules(reading: str) -> list[str]:
    """The clauses of the query vocabulary, each under its meaning."""
    return [f"% {e.usage}: {e.meaning}.\n{e.clause}" for e in entries(reading) if e.clause]


def fallbacks() -> str:
    """``name(_, _) :- fail.`` for every predicate of facts, three to a line."""
    clauses = [f"{name}({', '.join('_' * int(arity))}) :- fail." for name, arity in (s.split("/") for s in FALLBACKS)]
    return "\n".join(" ".join(clauses[i : i + 3]) for i in range(0, len(clauses), 3))


def defined() -> frozenset[str]:
    """Every signature that programs define, in either reading: nobody else may add clauses to it."""
    inner = {
        "proper_part/2", "belongs/2", "rival/2", "own_host_hides/2", "candidate/2", "hidden/2", "in_view/2", "claims/3", "not_behind/2",
        "all_behind/2", "found/2", "taken_away/3", "supported/1", "concordant/2", "agrees/1", "hitting/3", "other_hit/3", "any_hit/1",
        "explained/1", "missed/2", "violated/1", "caused/1", "outbid/3", "higher_up/1",
    }  # fmt: skip
    choices = {
        "alone/1",
        "ok/2",
        "pick/2",
        "luck/2",
        "member_of/2",
        "joint/3",
        "includes/2",
        "hit/2",
        "chosen/2",
        "excused/1",
    }
    return frozenset(inner | choices | set(FALLBACKS) | {entry.signature for entry in VOCABULARY})
