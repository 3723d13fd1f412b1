"""Layer 3 of the program in the posterior reading: which instance is which hypothesis, what hits, what causes what (§8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.base.bounds import bounded
from plogic.scene.readings.posterior_reading import causes_of, group_shares, unmatched
from plogic.scene.text.layout import disjunction, number

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.scene.text.layout import Writer


def choices(w: Writer) -> Iterator[str]:
    """One alternative per instance and per claimed appearance, one hit per candidate feature."""
    yield "hit(_, _) :- fail. chosen(_, _) :- fail. present(_) :- fail."
    yield "% Rivals for one instance are one alternative; the rest of the prior says that there is none."
    for shares in group_shares(w.scene).values():
        yield disjunction([(p, f"present({w.names.atom(name)})") for name, p in shares])
    yield "% Each expected feature is detected with its hit rate."
    for h in w.scene.situation.hypotheses:
        for f in (f for f in h.features if h.expects(f)):
            yield f"{number(bounded(f.hit_rate))}::hit({w.feature(h, f)})."
    yield "% Each claimed appearance has one cause: densities over their sum (bounded, so that ProbLog can read them)."
    for appearance in w.scene.claimants:
        yield from _causes(w, appearance)


def _causes(w: Writer, appearance: str) -> Iterator[str]:
    causes = causes_of(w.scene, appearance)
    named = [(p, w.node(h, f.id)) for p, (h, f) in zip(causes.shares, causes.claimants, strict=True)]
    heads = [
        (p, f"chosen({w.names.atom(appearance)}, {cause})") for p, cause in [*named, (causes.noise, "noise")] if p > 0
    ]
    if heads:
        yield disjunction(heads)
    else:
        yield f"% {w.names.atom(appearance)}: every density is 0: nothing can cause it."


def evidence(w: Writer) -> Iterator[str]:
    """Γ, and what is not in Γ."""
    yield from (f"evidence(explained({w.names.atom(appearance)}))." for appearance in w.scene.claimants)
    for h in w.scene.situation.hypotheses:
        yield from (f"evidence(\\+ missed({w.feature(h, f)}))." for f in unmatched(h))
