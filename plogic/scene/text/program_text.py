"""The program text of a situation: four layers, then the evidence (§8).

Making it and running it are two functions; this one makes it.

The text *is* the definition of the semantics: ``plogic.scene.worlds.ranked_worlds`` is tested equal to it. It is
deterministic. Layer 3, the choices, depends on the reading. Score: the choices that make P(present(H) | its occluders)
= P(ev). Posterior: which instance is which hypothesis, what hits, what causes what.
"""

from collections.abc import Iterator
from dataclasses import replace

from plogic.facts.dependence import Scene, dependence
from plogic.facts.sanity import check
from plogic.facts.situation import Situation, names_of
from plogic.logic.safety.author import FILE, author_rules
from plogic.logic.served.engine import Text
from plogic.scene.readings.unfinished import notice
from plogic.scene.readings.world_weights import lifted_smoothing
from plogic.scene.text import fact_layers as facts
from plogic.scene.text.choices import choices, evidence_of_data, pixel_facts, rates
from plogic.scene.text.evidence_layer import evidence_choices, evidence_facts, evidence_rules
from plogic.scene.text.layout import Writer, number, title
from plogic.scene.text.measures import cell_facts, measures
from plogic.scene.text.object_types import label_comments, object_types
from plogic.scene.text.rules import defined, fallbacks, rules, vocabulary_rules
from plogic.scene.text.support_layer import support_choices, support_facts


def program_text(situation: Situation) -> str:
    """The ProbLog program of the situation, without queries; runs in a stock ``problog``.

    Raises SituationError for a situation that contradicts itself, ProgramError for author's rules that cannot be used.
    """
    check(situation)
    scene = Scene(situation)
    return "\n".join(_lines(Writer(scene, dependence(scene), names_of(situation)))).rstrip() + "\n"


def program_of(situation: Situation) -> Text:
    """The same program in pieces, so that mistakes are told where the author wrote them.

    Its own clauses, the author's rules, and those of who asks.
    """
    return Text(program_text(replace(situation, rules="")), own=added_to(situation))


def added_to(situation: Situation) -> Text | None:
    """The author's rules and those of who asks; None where there are none."""
    return Text(situation.rules, FILE, situation.own) if situation.rules.strip() else situation.own


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
    of = "The possible worlds of one image" if situation.hypotheses or situation.appearances else "Σ, without an image"
    yield f"% {of}. Reading: {situation.reading}{mode}. A world is an assignment of present/1."
    if situation.stopped:
        yield f"% {notice(situation.stopped)}."
    yield from label_comments(w)
    told = list(_told(w))
    yield from told
    yield from ("", title(4, "Σc: constraints and definitions D1-D8, free of any object type"))
    yield from fallbacks(situation.reading, told)
    for block in rules(situation, cyclic=any(len(block) > 1 for block in w.graph.blocks)):
        yield from (block, "")
    yield from ("% ---- The vocabulary of queries", *vocabulary_rules(situation.reading))
    yield from evidence_rules(w)
    clauses = author_rules(situation.rules, w.names, defined())
    if clauses:
        yield from ("", "% ---- The rules of the knowledge base's author", *clauses)
    yield from (
        "",
        title(5, "Evidence: no violated constraint" + ("" if is_score else ", Γ, and what is missing in Γ")),
    )
    yield from facts.constraints(w)
    if not is_score:
        yield from evidence_of_data(w)


def _told(w: Writer) -> Iterator[str]:
    """Layers 1 to 3."""
    is_score = w.scene.situation.reading == "score"
    yield from ("", title(1, "Σo: object types as feature clouds, and the hypotheses that are of them"))
    yield from object_types(w)
    yield from ("", title(2, "The measures of Σo, and what geometry computed: poses, visibility, matches, outlines"))
    yield from measures(w)
    yield from [f"smoothing({number(lifted_smoothing(w.scene))})."] if is_score else (*rates(w), *pixel_facts(w))
    yield from facts.geometry(w)
    yield from support_facts(w)
    yield from cell_facts(w)
    yield from evidence_facts(w)
    yield from ("", title(3, "The choices"))
    yield from choices(w)
    yield from facts.excuses(w)
    yield from support_choices(w)
    yield from evidence_choices(w)
