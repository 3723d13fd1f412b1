"""The vocabulary of space: each predicate with its definition, over the facts that ``plogic.scene.text.fact_layers`` writes.

They speak of bodies, not of origins of meshes: docs/space.md has the definitions, the frames and the tolerances.
"""

from __future__ import annotations

from plogic.facts.vocabulary_entry import Entry

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
        "on(X, Y) :- stands_on(X, Y), present(X), present(Y).\n"
        "on(X, Y) :- stands_on_both(X, Y, Z), present(X), present(Y), present(Z).\n"
        "on(X, Y) :- stands_on_both(X, Z, Y), present(X), present(Y), present(Z).",
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
        "rests_on",
        2,
        "X touches Y from above, Y being another hypothesis or `ground`; where gravity is not said to hold, or up is unknown, of nothing",
        "rests_on(X, Y)",
        "rests_on(X, Y) :- body_rests(X, Y), Y \\= ground, present(X), present(Y).\n"
        "rests_on(X, ground) :- body_rests(X, ground), present(X).\n"
        "rests_on(X, ground) :- open_foot(X, _, _), present(X), \\+ higher_up(X).\n"
        "higher_up(X) :- open_foot(X, A, _), open_foot(Y, _, B), B < A, present(Y).",
    ),
    Entry("held", 1, "X rests on something present, or on the ground", "held(X)", "held(X) :- rests_on(X, _)."),
    Entry(
        "floats",
        1,
        "gravity is said to hold, and nothing holds X",
        "floats(X)",
        "floats(X) :- weighs(X), present(X), \\+ held(X).",
    ),
)
