"""The program text of a situation: four layers, then the evidence (§8). Making it and running it are two functions; this one makes it.

The text *is* the definition of the semantics: ``plogic.scene.worlds.ranked_worlds`` is tested equal to it. It is
deterministic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.facts.dependence import Scene, dependence
from plogic.facts.names import names_of
from plogic.facts.sanity import check
from plogic.logic.safety.author import author_rules
from plogic.scene.readings.score_reading import lifted_smoothing
from plogic.scene.readings.unfinished import notice
from plogic.scene.text import fact_layers as facts
from plogic.scene.text import posterior_choices as posterior
from plogic.scene.text import score_choices as score
from plogic.scene.text import support_text as floating
from plogic.scene.text.contexts import ev_facts
from plogic.scene.text.layout import Writer, title
from plogic.scene.text.rules import defined, fallbacks, rules, vocabulary_rules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.situation import Situation


def program_text(situation: Situation) -> str:
    """The ProbLog program of the situation, without queries; runs in a stock ``problog``.

    Raises SituationError for a situation that contradicts itself, ProgramError for author's rules that cannot be used.
    """
    check(situation)
    scene = Scene(situation)
    writer = Writer(scene, dependence(scene), names_of(situation))
    return "\n".join(_lines(writer)).rstrip() + "\n"


def query_lines(situation: Situation) -> str:
    """``query(present(h1)).`` for every hypothesis: appended for the stock command line."""
    names = names_of(situation)
    return "".join(f"query(present({names.atom(h.id)})).\n" for h in situation.hypotheses)


def left_out(situation: Situation) -> dict[str, tuple[str, ...]]:
    """Hypothesis → the occluders that the choices do not look at, since at most six are (§8, mode `drop`)."""
    return dependence(Scene(situation)).left_out if situation.reading == "score" else {}


def _lines(w: Writer) -> Iterator[str]:
    situation = w.scene.situation
    is_score = situation.reading == "score"
    mode = f", reconsideration: {situation.reconsider}" if is_score else ""
    yield f"% The possible worlds of one image. Reading: {situation.reading}{mode}. A world is an assignment of present/1."
    if situation.stopped:
        yield f"% {notice(situation.stopped)}."
    yield from facts.label_comments(w)
    yield from ("", title(1, "Σo: the feature-cloud trees of the hypotheses and their part-whole hierarchy"))
    yield from facts.trees(w)
    yield from (
        "",
        title(2, "What geometry computed: poses, visibility, matches, overlaps, outlines; then the measures"),
    )
    yield from facts.geometry(w)
    yield from ev_facts(w)
    yield from ("", title(3, "The choices"))
    yield from score.choices(w) if is_score else posterior.choices(w)
    yield from floating.excuses(w)
    yield from ("", title(4, "Σc: constraints and definitions D1-D8, free of any object type"))
    yield from ("% Predicates that may have no facts in this image.", fallbacks(), "")
    for block in rules(situation, smoothed=lifted_smoothing(w.scene) > 0):
        yield from (block, "")
    yield from ("% ---- The vocabulary of queries", *vocabulary_rules(situation.reading))
    yield from _author(w)
    yield from (
        "",
        title(5, "Evidence: no violated constraint" + ("" if is_score else ", Γ, and what is missing in Γ")),
    )
    yield from facts.constraints(w)
    if not is_score:
        yield from posterior.evidence(w)


def _author(w: Writer) -> Iterator[str]:
    clauses = author_rules(w.scene.situation.rules, w.names, defined())
    if clauses:
        yield from ("", "% ---- The rules of the knowledge base's author", *clauses)
