"""The vocabulary of queries: one table, from which the program's rules and the documentation are both made (contract).

Every predicate holds *in a world*: of hypotheses that are not present nothing is true, except ``opaque``, ``dv`` and
``rank``, which speak of types. ``H`` is a hypothesis (``h1``), ``F`` a feature (``'roof/apex'``), ``A`` an appearance
(``a1``); a *node* of the part-whole tree is a hypothesis, or ``H/P`` for a part or a feature of it.

``Entry("present", 1, "the hypothesis H is in the world", "present(H)", "")``; without a clause the choices define it.
``SPACE`` is the part about space, defined over the facts that ``plogic.scene.text.fact_layers`` writes. It speaks of
bodies, not of origins of meshes: docs/space.md has the definitions, the frames and the tolerances.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """``name/arity`` "is true if" ``meaning``; ``clause`` is its ProbLog text, one clause a line."""

    name: str
    arity: int
    meaning: str
    usage: str
    clause: str
    reading: str = ""

    @property
    def signature(self) -> str:
        """``present/1``."""
        return f"{self.name}/{self.arity}"


SPACE: tuple[Entry, ...] = (
    Entry(
        "left_of",
        2,
        "X's middle is further left than Y's, along the camera's x axis",
        "left_of(X, Y)",
        "left_of(X, Y) :- body_middle(X, A, _, _), body_middle(Y, B, _, _), A < B, present(X), present(Y).",
    ),
    Entry("right_of", 2, "Y is left of X", "right_of(X, Y)", "right_of(X, Y) :- left_of(Y, X)."),
    Entry(
        "nearer",
        2,
        "the nearest place of X's surface is nearer to the camera than that of Y's",
        "nearer(X, Y)",
        "nearer(X, Y) :- body_nearest(X, A), body_nearest(Y, B), A < B, present(X), present(Y).",
    ),
    Entry("farther", 2, "Y is nearer than X", "farther(X, Y)", "farther(X, Y) :- nearer(Y, X)."),
    Entry(
        "gap",
        3,
        "V is how many metres are between X's surface and Y's, 0 where they touch",
        "gap(X, Y, V)",
        "gap(X, Y, V) :- body_gap(X, Y, V), present(X), present(Y).\ngap(X, Y, V) :- body_gap(Y, X, V), present(X), present(Y).",
    ),
    Entry(
        "near",
        3,
        "X's and Y's surfaces are at most D metres apart",
        "near(X, Y, D)",
        "near(X, Y, D) :- gap(X, Y, V), V =< D.",
    ),
    Entry(
        "above",
        2,
        "X is over Y along some plumb line, and Y over X along none; without a known up, of nothing",
        "above(X, Y)",
        "above(X, Y) :- body_over(X, Y), present(X), present(Y).",
    ),
    Entry("below", 2, "Y is above X", "below(X, Y)", "below(X, Y) :- above(Y, X)."),
    Entry(
        "on",
        2,
        "X is above Y, touches it, and is held up by Y, or by Y and one other present object",
        "on(X, Y)",
        "on(X, Y) :- body_on(X, Y), present(X), present(Y).\n"
        "on(X, Y) :- body_on_both(X, Y, Z), present(X), present(Y), present(Z).\n"
        "on(X, Y) :- body_on_both(X, Z, Y), present(X), present(Y), present(Z).",
    ),
    Entry(
        "in_view_of_camera",
        1,
        "X's outline lies wholly in the image, hidden or not",
        "in_view_of_camera(X)",
        "in_view_of_camera(X) :- inside_image(X), present(X).",
    ),
    Entry(
        "partly_in_view_of_camera",
        1,
        "X's outline lies partly in the image, and partly outside",
        "partly_in_view_of_camera(X)",
        "partly_in_view_of_camera(X) :- cut_by_image(X), present(X).",
    ),
    Entry(
        "support_plane",
        1,
        "S is the plane that things rest on; where nobody said that they rest, of nothing",
        "support_plane(S)",
        "support_plane(S) :- support(S), S \\= none.",
    ),
    Entry(
        "stance",
        3,
        "the present H has its stable pose Face on On, which is a plane, or a hypothesis (present in the posterior reading), or `free`",
        "stance(H, On, Face)",
        "stance(H, On, Face) :- footing(H, On, Face), present(H).",
    ),
    Entry(
        "stands_on",
        2,
        "the present H stands on the plane S, in one of its stable poses",
        "stands_on(H, S)",
        "stands_on(H, S) :- stance(H, S, _), support_plane(S).",
    ),
    Entry(
        "rests_on",
        2,
        "X touches Y from above, or stands on it in one of its stable poses, Y being another hypothesis or `ground`, which is the plane "
        "too; where gravity is not said to hold, or up is unknown, and nobody said that things rest, of nothing",
        "rests_on(X, Y)",
        "rests_on(X, Y) :- body_rests_on(X, Y).\n"
        "rests_on(X, Y) :- stance(X, Y, _), present(X), present(Y).\n"
        "rests_on(X, ground) :- stands_on(X, _).\n"
        "body_rests_on(X, Y) :- body_rests(X, Y), Y \\= ground, present(X), present(Y).\n"
        "body_rests_on(X, ground) :- body_rests(X, ground), present(X).\n"
        "body_rests_on(X, ground) :- open_foot(X, _, _), present(X), \\+ higher_up(X).\n"
        "higher_up(X) :- open_foot(X, A, _), open_foot(Y, _, B), B < A, present(Y).",
    ),
    Entry("held", 1, "X rests on something present, a plane or the ground", "held(X)", "held(X) :- rests_on(X, _)."),
    Entry(
        "floats",
        1,
        "gravity is said to hold, and nothing holds X",
        "floats(X)",
        "floats(X) :- weighs(X), present(X), \\+ held(X).",
    ),
    Entry(
        "free",
        1,
        "things are said to rest, and the present H stands on nothing that is known",
        "free(H)",
        "free(H) :- stance(H, free, _).\nfree(H) :- stance(H, X, _), hypothesis(X, _), \\+ present(X).",
    ),
)


def _coarse(name: str, meaning: str) -> Entry:
    """One of the coarse occlusion relations (§3.6), of whole hypotheses or of parts that are objects."""
    clause = (
        f"{name}(X, Y) :- outline_relation({name}, X, Y), present(X), present(Y).\n"
        f"{name}(X, Y) :- part_relation({name}, X, Y), node(X), node(Y)."
    )
    return Entry(name, 2, meaning, f"{name}(X, Y)", clause)


VOCABULARY: tuple[Entry, ...] = (
    Entry("present", 1, "hypothesis H is in the world", "present(H)", ""),
    Entry(
        "object",
        2,
        "H is present and is of the type",
        "object(H, Type)",
        "object(H, T) :- hypothesis(H, T), present(H).",
    ),
    Entry(
        "number_of_objects",
        1,
        "N hypotheses are present",
        "number_of_objects(N)",
        "number_of_objects(N) :- hypotheses(Hs), counted(Hs, N).\n"
        "counted([], 0).\n"
        "counted([H | Hs], N) :- counted(Hs, M), one_more(H, M, N).\n"
        "one_more(H, M, N) :- present(H), N is M + 1.\n"
        "one_more(H, N, N) :- \\+ present(H).",
    ),
    Entry(
        "number_of",
        2,
        "N hypotheses of the type are present",
        "number_of(Type, N)",
        "number_of(T, N) :- hypotheses_of(T, Hs), counted(Hs, N).",
    ),
    Entry(
        "node",
        1,
        "X is a node of the part-whole tree of a present hypothesis",
        "node(X)",
        "node(X) :- belongs(X, H), present(H).",
    ),
    Entry(
        "part",
        2,
        "P is a direct or indirect part of the present hypothesis H",
        "part(P, H)",
        "part(P, H) :- hypothesis(H, _), pp(P, H).",
    ),
    Entry(
        "pp", 2, "X is a proper part of Y (A3)", "pp(X, Y)", "pp(X, Y) :- belongs(X, H), present(H), proper_part(X, Y)."
    ),
    Entry(
        "p", 2, "X is a part of Y: the same, or a proper part", "p(X, Y)", "p(X, X) :- node(X).\np(X, Y) :- pp(X, Y)."
    ),
    Entry("o", 2, "X and Y have a part in common", "o(X, Y)", "o(X, Y) :- p(X, Y).\no(X, Y) :- pp(Y, X)."),
    Entry(
        "dr",
        2,
        "X and Y are discrete: no part in common",
        "dr(X, Y)",
        "dr(X, Y) :- belongs(X, G), belongs(Y, H), G \\= H, present(G), present(H).\n"
        "dr(X, Y) :- belongs(X, H), belongs(Y, H), X \\= Y, \\+ proper_part(X, Y), \\+ proper_part(Y, X), present(H).",
    ),
    Entry(
        "max_object",
        1,
        "H is a present object that is part of no other (D3)",
        "max_object(H)",
        "max_object(H) :- hypothesis(H, _), present(H).",
    ),
    Entry(
        "atom_node",
        1,
        "X is a node without proper parts (D2); users write atom(X)",
        "atom(X)",
        "atom_node(X) :- node(X), \\+ proper_part(_, X).",
    ),
    Entry(
        "feature",
        3,
        "F is a feature of the present hypothesis H, of the type",
        "feature(H, F, Type)",
        "feature(H, F, T) :- feature_of(H, F, T), present(H).",
    ),
    Entry(
        "expected",
        2,
        "F of the present H should be seen: in the image, in a lobe, behind nothing opaque (D7)",
        "expected(H, F)",
        "expected(H, F) :- feature_of(H, F, _), present(H), in_view(H, F).",
    ),
    Entry(
        "detected",
        2,
        "F of the present H is matched to an appearance (D8)",
        "detected(H, F)",
        "detected(H, F) :- feature_of(H, F, _), present(H), found(H, F).",
    ),
    Entry(
        "case",
        3,
        "F of the present H is in case a (E∧D), b (¬E∧¬D), c (E∧¬D) or d (¬E∧D) of §4",
        "case(H, F, Case)",
        "case(H, F, a) :- in_image(H, F), present(H), in_view(H, F), found(H, F).\n"
        "case(H, F, b) :- in_image(H, F), present(H), \\+ in_view(H, F), \\+ found(H, F).\n"
        "case(H, F, c) :- in_image(H, F), present(H), in_view(H, F), \\+ found(H, F).\n"
        "case(H, F, d) :- in_image(H, F), present(H), \\+ in_view(H, F), found(H, F).",
    ),
    Entry(
        "cause",
        3,
        "appearance A is caused by F of H: the present, expected claimant with the least residual",
        "cause(A, H, F)",
        "cause(A, H, F) :- claims(H, F, A), \\+ outbid(A, H, F).\noutbid(A, H, F) :- preferred(A, G/E, H/F), claims(G, E, A).",
        "score",
    ),
    Entry(
        "cause",
        3,
        "appearance A is caused by F of H",
        "cause(A, H, F)",
        "cause(A, H, F) :- match(H, F, A), chosen(A, H/F), hitting(A, H, F).",
        "posterior",
    ),
    Entry(
        "noise",
        1,
        "no feature of a present hypothesis causes appearance A",
        "noise(A)",
        "noise(A) :- datum(A, _), \\+ caused(A).\ncaused(A) :- cause(A, _, _).",
    ),
    Entry(
        "why",
        3,
        "why F of the present H is not detected: it is `outside` the image, `turned_away`, `self_hidden`, `behind(G)`, or `missed` (case c);"
        " or detected and not expected: its appearance is `caused_by(G/E)`, or `noise`",
        "why(H, F, Cause)",
        "why(H, F, outside) :- feature_of(H, F, _), \\+ in_image(H, F), present(H).\n"
        "why(H, F, turned_away) :- case(H, F, b), \\+ in_lobe(H, F).\n"
        "why(H, F, self_hidden) :- case(H, F, b), own_host_hides(H, F).\n"
        "why(H, F, behind(G)) :- case(H, F, b), behind(H/F, G), G \\= H, opaque(G), \\+ rival(H, G).\n"
        "why(H, F, missed) :- case(H, F, c).\n"
        "why(H, F, caused_by(G/E)) :- case(H, F, d), match(H, F, A), cause(A, G, E).\n"
        "why(H, F, noise) :- case(H, F, d), match(H, F, A), noise(A).",
    ),
    Entry(
        "behind",
        2,
        "the line of sight to Y meets X first; Y is a feature H/F, or an object all of whose self-visible features are",
        "behind(Y, X)",
        "behind(H/F, G) :- behind_surface(H, F, G), present(H), present(G).\n"
        "behind(H, G) :- hypothesis(H, _), hypothesis(G, _), all_behind(H, G), present(H), present(G).",
    ),
    Entry(
        "hides_all_features",
        2,
        "opaque X hides every self-visible feature of Y, and there is one (D5, feature form)",
        "hides_all_features(X, Y)",
        "hides_all_features(X, Y) :- hypothesis(Y, _), behind(Y, X), opaque(X).",
    ),
    Entry(
        "roc",
        3,
        "the relation of X to Y is this one of ROC-20, by outlines and depth (§3.7); of opaque hypotheses X and Y exactly one holds; "
        "what is not opaque occludes nothing, and where ROC-20 has no name for that, none holds; also of parts that are objects",
        "roc(Relation, X, Y)",
        "roc(R, X, Y) :- outline_roc(R, X, Y), present(X), present(Y).\n"
        "roc(R, X, Y) :- part_roc(R, X, Y), node(X), node(Y).",
    ),
    Entry(
        "occludes",
        2,
        "some part of X totally occludes some part of Y (§3.6)",
        "occludes(X, Y)",
        "occludes(X, Y) :- partially_occludes(X, Y).\noccludes(X, Y) :- totally_occludes(X, Y).\n"
        "occludes(X, Y) :- mutually_occludes(X, Y).",
    ),
    _coarse("totally_occludes", "X covers Y, in front everywhere (D5, by outlines)"),
    _coarse("partially_occludes", "X is in front of a part of Y (D6, by outlines)"),
    _coarse("mutually_occludes", "each is in front of a part of the other, or they coincide"),
    _coarse("non_occludes", "neither is in front of a part of the other"),
    Entry(
        "surface_of",
        2,
        "S is the surface `surface(X)` of X, a present hypothesis or a part of it that is an object (§4.2)",
        "surface_of(S, X)",
        "surface_of(S, X) :- bounds(S, H), present(H), S = surface(X).",
    ),
    Entry(
        "surface_part",
        2,
        "S is part of the surface of the present H: `facet(H, Features)`, `face(H, Features)`, or the surface of a part",
        "surface_part(S, H)",
        "surface_part(S, H) :- bounds(S, H), S \\= surface(H), present(H).",
    ),
    Entry(
        "opaque",
        1,
        "X is opaque: a hypothesis, its surface, or a part of either (A5, A6)",
        "opaque(X)",
        "opaque(H) :- opaque_surface(H).\nopaque(H/P) :- bounds(surface(H/P), H), opaque_surface(H).\n"
        "opaque(S) :- bounds(S, H), opaque_surface(H).",
    ),
    Entry(
        "evidence_roc",
        3,
        "the relation of X to Y by what is detected of both, not by their poses, is this one of ROC-20 (§8, last paragraph); where "
        "one pose is withheld, roc is this",
        "evidence_roc(Relation, X, Y)",
        "evidence_roc(R, X, Y) :- stands(S), said_roc(S, R, X, Y), present(X), present(Y).",
    ),
    Entry(
        "evidence_relation",
        3,
        "the same, of the four coarse relations",
        "evidence_relation(Relation, X, Y)",
        "evidence_relation(R, X, Y) :- stands(S), said_relation(S, R, X, Y), present(X), present(Y).",
    ),
    Entry("dv", 2, "V is the distinctiveness of the feature type (§5.1)", "dv(Type, V)", ""),
    Entry("drawn", 1, "a feature drawn from Σo is of the type: its probability is P(dv) (§5.1)", "drawn(Type)", ""),
    Entry("rank", 2, "V is the rank of the object type (§5.3)", "rank(Type, V)", ""),
    Entry(
        "ev",
        2,
        "V is the explanatory value of the present H, given which of its occluders are present (§5.4, §5.5)",
        "ev(H, V)",
        "ev(H, V) :- hypothesis(H, _), present(H), context(H, C), ev_in(H, C, V).",
    ),
    Entry(
        "ev_holds",
        2,
        "H is accepted where of its occluders just those in the list are present: its probability is P(ev) (§5.4)",
        "ev_holds(H, Occluders)",
        "",
        "score",
    ),
    *SPACE,
)


def entries(reading: str) -> tuple[Entry, ...]:
    """The entries of one reading, in the order of the table."""
    return tuple(entry for entry in VOCABULARY if entry.reading in ("", reading))


def table() -> str:
    """The table as Markdown, for the documentation."""
    seen: dict[str, Entry] = {}
    for entry in VOCABULARY:
        seen.setdefault(entry.usage, entry)
    rows = [f"| `{usage}` | {entry.meaning} |" for usage, entry in seen.items()]
    return "\n".join(["| query | is true if |", "|---|---|", *rows])
