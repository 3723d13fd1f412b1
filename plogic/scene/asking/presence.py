"""The presence of an interpretation's hypothesis as a user wants to read it.

Its features' evidence, from the situation itself (§4, §5, §8).

The exact explanations pick one feature at a time; this is their sum. Everything is said of one world: the most probable
one that holds the hypothesis. Lines of text; nothing here is a probability that the program does not give.

In the posterior reading each datum speaks by its log-likelihood ratio: ``Contribution("a3", 5.9)``, that a3 is there
makes the hypothesis e^5.9 times likelier; ``Contribution("h1/roof/apex", -1.6)``, that nothing was detected where h1's
apex should be seen speaks against it. The features of others that it hides count for it: explaining away.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Mask
from plogic.base.walk import by_key
from plogic.facts.dependence import Scene
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.interpretation import beside_usual
from plogic.facts.situation import OTHERS, Situation
from plogic.facts.spatial import words_of_shared
from plogic.scene.readings.standing import Standing
from plogic.scene.readings.world_weights import (
    Present,
    appearance_weight,
    cells,
    four,
    group_shares,
    miss_weight,
    p_ev,
    pixel_odds,
    unmatched,
)


@dataclass(frozen=True)
class Contribution:
    """``datum``: an appearance, or a feature that has none, or a hypothesis, of which the photo's pixels speak.

    Or ``STANDS``: where it stands, and what stands on it.

    ``llr``: ln P(datum | hypothesis) − ln P(datum | without it).
    """

    datum: str
    llr: float


def contributions(situation: Situation, hypothesis: str, world: Iterable[str]) -> list[Contribution]:
    """Every datum that tells ``world`` with the hypothesis from ``world`` without it, the strongest first.

    Ties by name.

    The ratios sum to the logarithm of the Bayes factor between these two worlds. A ratio may be infinite (a hit rate of
    1).
    """
    others = set(world) - {hypothesis}
    scene = Scene(situation)
    present = {h.id: np.array([h.id in others, h.id in others or h.id == hypothesis]) for h in situation.hypotheses}
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = [
            Contribution(name, float(np.log(weight[1]) - np.log(weight[0])))
            for name, weight in _weights(scene, present)
        ]
    told = (c for c in ratios if not math.isnan(c.llr) and abs(c.llr) > 1e-12)
    return sorted(told, key=lambda c: (-abs(c.llr), c.datum))


def _weights(scene: Scene, present: dict[str, Mask]) -> Iterator[tuple[str, Floats]]:
    for appearance in scene.claimants:
        yield appearance, appearance_weight(scene, appearance, present)
    if scene.situation.support is not None:
        standing = Standing(scene.situation, scene.situation.support)
        worlds = [[name for name, column in present.items() if column[i]] for i in range(2)]
        logs = np.array([standing.log_weight(world) for world in worlds])
        yield STANDS, np.exp(logs - max(logs.max(), 0.0))
    for h in scene.situation.hypotheses:
        yield h.id, np.exp(pixel_odds(h, present))
        for f in unmatched(h):
            yield f"{h.id}/{f.id}", miss_weight(scene, h, f, present)


STANDS = "(stands)"
"""Name of the datum that poses fit a plane or each other (§9.9); no name of an appearance has parentheses."""
LISTED = 8
"""Features, or data, that a line names; the rest is counted."""
TYPES = 10
"""Feature types that a line tells apart; visual words are more, and nobody knows them by name."""
SAID = {
    "A": "expected and detected",
    "B": "neither expected nor detected",
    "C": "expected but not detected",
    "D": "detected but not expected",
}


class View(NamedTuple):
    """A hypothesis in a world: ``present`` as ``plogic.scene.readings.world_weights`` wants it."""

    scene: Scene
    h: Hypothesis
    world: tuple[str, ...]
    present: Present


def presence(situation: Situation, name: str, world: Sequence[str]) -> tuple[str, ...]:
    """The lines for one hypothesis in a world that holds it."""
    scene = Scene(situation)
    present = {h.id: np.array([h.id in world]) for h in situation.hypotheses}
    view = View(scene, scene.by_id[name], tuple(world), present)
    told = _score(view) if situation.reading == "score" else _posterior(view)
    beside = ", ".join(w for w in world if w != name) or "no other"
    where = f"{name} is a {view.h.type}; in the most probable world that holds it, beside {beside}:"
    return (where, *told, *_usual(view), *_pixels(view), *_sure(view), *_stands(view), *_held(view), *_excluded(view))


def _score(view: View) -> Iterator[str]:
    """Concordant or not, by the four cases of those in the sum; dv-weighted the concordant ones are P(ev)."""
    in_image = [f for f in view.h.features if f.in_image]
    cases = [(four(view.scene, view.h, f, view.present), f) for f in in_image]
    by_case = by_key((name.upper(), f) for case, f in cases for name, mask in case._asdict().items() if mask[0])
    seen = list(chain(*by_case.values()))
    good = _count([*by_case.get("A", ()), *by_case.get("B", ())])
    p = float(p_ev(view.scene, view.h, view.present)[0])
    over = "dv-weighted" if view.scene.situation.dv_over == "types" else "weighed by dv over the instances in Δ"
    weighted = f"{over}: undefined (0/0)" if np.isnan(p) else f"{over} {p:.4g} = P(ev), ev = {2 * p - 1:.3g}"
    out = _count(in_image) - _count(seen)
    left = f", but for {out} hidden, which mode drop leaves out of the sum," if out else ""
    yield f"  {good} of {_count(seen)} features in the image{left} are concordant, {weighted}"
    for case, mark in (("A", "for"), ("B", "for"), ("C", "against"), ("D", "against")):
        if case in by_case:
            yield f"  {mark}: {SAID[case]}: {_by_type(by_case[case], name_all=case in 'CD')}"
    yield from _hiding(view, in_image)


def _usual(view: View) -> Iterator[str]:
    """How many features of a learned type are found, beside how many were when it was learned."""
    rows = [f for f in view.h.features if f.learned_rate is not None and f.stands_for == 1 and f.in_image]
    seen = [(f.learned_rate or 0.0, cells(view.scene, view.h, f, view.present)) for f in rows]
    counts = beside_usual([(rate, bool(cell.detected[0])) for rate, cell in seen if cell.expected[0]])
    if counts is not None:
        found, expected, usual = counts
        yield (
            f"  to compare: {found} of {expected} expected features are found; when its"
            f" type was learned, {usual} of them were found from there: most visual words come and go"
        )


def _pixels(view: View) -> Iterator[str]:
    """What the photo's pixels say, where they were asked (§9.10): in the posterior, of those that nobody hides here."""
    if view.scene.situation.reading == "score":
        fit, where = view.h.pixels, ", it is accepted by that, P(ev) is not"
    else:
        table = view.h.pixel_table
        fit = None if table is None else float(table.told(view.present)[0])
        before = [name for name in table.occluders if name in view.world] if table is not None else []
        where = f", where {listed(before)} hides some of it" if before else ""
    if fit is not None:
        mark, how = ("for", "is") if fit > 0.0 else ("against", "is not")
        yield f"  {mark}: drawn at its pose it {how} what the photo shows, by outline, colours and print: {fit:+.3g} in log-odds{where}"


def _sure(view: View) -> Iterator[str]:
    """How surely its pose is right, where a photo was asked."""
    if view.h.pose_probability is not None:
        yield f"  if it is there, its pose is within a tenth of its diameter of the true one (ADD) with probability {view.h.pose_probability:.3f}"


def _by_type(features: list[FeatureFact], *, name_all: bool) -> str:
    """``1 apex, 5 corner, 12 patch``; with the features' names where they are few or speak against it."""
    types: dict[str, list[FeatureFact]] = {}
    for f in sorted((f for f in features if f.stands_for), key=lambda f: -f.dv):  # parts of a compound stand for none
        types.setdefault(f.type, []).append(f)
    if len(types) > TYPES:
        return f"{_count(features)} features of {len(types)} types ({listed([f.id for f in features if f.stands_for == 1])})"
    rows = [(kind, some, [f.id for f in some if f.stands_for == 1]) for kind, some in types.items()]
    return ", ".join(
        f"{_count(some)} {'others' if kind == OTHERS else kind}"
        + (f" ({listed(names)})" if names and (name_all or len(names) <= 2) else "")
        for kind, some, names in rows
    )


def _count(features: Iterable[FeatureFact]) -> int:
    return sum(f.stands_for for f in features)


def listed(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    return ", ".join(names[:LISTED]) + (f", and {len(names) - LISTED} more" if len(names) > LISTED else "")


def _hiding(view: View, features: Iterable[FeatureFact]) -> Iterator[str]:
    """Which present objects hide what would otherwise be expected."""
    hidden: dict[str, list[str]] = {}
    for f in features:
        for g in view.scene.hiders(view.h, f) if view.h.expects(f) else ():
            hidden.setdefault(g, []).append(f.id)
    present = {g: names for g, names in hidden.items() if g in view.world}
    yield from (
        f"  hidden by {g}, so not expected: {len(names)} feature{'s' * (len(names) > 1)} ({listed(names)})"
        for g, names in present.items()
    )


def _posterior(view: View) -> Iterator[str]:
    """Log-likelihood ratios: this world against the same without the hypothesis."""
    told = contributions(view.scene.situation, view.h.id, view.world)
    share = next(p for shares in group_shares(view.scene).values() for name, p in shares if name == view.h.id)
    total = float(np.sum([c.llr for c in told]))
    found = [c for c in told if c.datum not in (view.h.id, STANDS)]  # these two have lines of their own
    own = {view.h.id: "the photo's pixels", STANDS: "where it stands"}
    besides = [own[c.datum] for c in told if c.datum in own]
    what = "what is detected and what is not" + (f", and {' and '.join(besides)}," if besides else "")
    yield f"  prior {share:.4g}; {what} changes its log-odds against this world without it by {total:+.4g}"
    for mark, side in (("for", [c for c in found if c.llr > 0]), ("against", [c for c in found if c.llr < 0])):
        yield from (f"  {mark}: {_datum(view, c)}: {c.llr:+.3g}" for c in side[:LISTED])
        if len(side) > LISTED:
            yield f"  {mark}: {len(side) - LISTED} more, together {float(np.sum([c.llr for c in side[LISTED:]])):+.3g}"


def _datum(view: View, c: Contribution) -> str:
    """An appearance with the feature that it is matched to, or a place where one should be."""
    if c.datum in view.scene.by_id:
        return f"it hides some of {c.datum}'s pixels, which are told without them"
    appearance = next((a for a in view.scene.situation.appearances if a.id == c.datum), None)
    if appearance is not None:
        owner = next((f.id for f in view.h.features if f.match == c.datum), None)
        whose = f"is its {owner}" if owner is not None else "is matched to another"
        return f"{c.datum} ({appearance.type}) at ({appearance.uv[0]:.0f}, {appearance.uv[1]:.0f}) {whose}"
    name, _, feature = c.datum.partition("/")
    f = next(f for f in view.scene.by_id[name].features if f.id == feature)
    whose = f"its {feature}" if name == view.h.id else c.datum
    why = " is expected" if c.llr < 0 else " would be expected without it"
    return f"no appearance at ({f.uv[0]:.0f}, {f.uv[1]:.0f}), where {whose}{why}"


def _stands(view: View) -> Iterator[str]:
    """What it stands on most probably in this world, and by how much that changes its log-odds (§9.9, posterior)."""
    situation, name = view.scene.situation, view.h.id
    if situation.support is None:
        return
    standing = Standing(situation, situation.support)
    told = standing.told(view.world)
    if name not in told.stances:
        return
    on, _, _ = told.stances[name].rpartition("/")
    others = [other for other, stance in told.stances.items() if stance.startswith(f"{on}/") and other != name]
    if situation.reading == "score":
        yield f"  most probably it {_standing(standing, on, others)}; where it stands is no evidence in this reading"
        return
    without = [other for other in view.world if other != name]
    gain = standing.log_weight(view.world) - standing.log_weight(without)
    mark = "no evidence:" if abs(gain) < NOTHING else "believed because" if gain > 0.0 else "against:"
    where = _standing(standing, on, others)
    if not on and (name, told.state) in standing.level:
        where = f"is level above {told.state}, on something unknown, or stands on nothing"
    yield f"  {mark} it {where}: {gain:+.3g} in log-odds{_by_chance(standing, name)}"


NOTHING = 1e-9
"""Log-odds that rounding alone may make."""


def _by_chance(standing: Standing, name: str) -> str:
    e = standing.by_chance.get(name, 0.0)
    return f", its pose standing so by chance with {e:.3g} if it is not there" if e else ""


def _standing(standing: Standing, on: str, others: Sequence[str]) -> str:
    """``stands on s1, the plane of h3, h4``."""
    if not on:
        return "stands on nothing known: it is held, leans or hangs, or its pose is wrong"
    plane = f", the plane of {listed(others)}" if others else ", a plane of its own"
    return f"stands on {on}" + (plane if on in standing.states else "")


def _held(view: View) -> Iterator[str]:
    """Who holds it in this world, or that it floats (Σc), where gravity is said to hold of it."""
    gravity, name = view.scene.situation.gravity, view.h.id
    if gravity is None or all(foot.id != name for foot in gravity.feet):
        return
    if gravity.floating(name, view.world):
        yield f"  against: it floats, nothing in this world holds it: the world weighs {gravity.unknown_support:.4g} of what it would"
        return
    holders = [x for x in gravity.holders(name) if x in view.world]
    yield f"  held by {listed(holders) if holders else 'the ground'}"


def _excluded(view: View) -> Iterator[str]:
    """Hypotheses that the constraints keep out of its worlds."""
    situation, h = view.scene.situation, view.h
    reasons = [("shares volume with (A4)", situation.overlaps)]
    if situation.reading == "score":
        reasons.append(("lives on the same appearances as (D8)", situation.exclusive - situation.overlaps))
    for reason, pairs in reasons:
        others = sorted({x if y == h.id else y for x, y in pairs if h.id in (x, y)}, key=list(view.scene.by_id).index)
        if others:
            known = {x: situation.space.sharing(h.id, x) if pairs is situation.overlaps else None for x in others}
            told = [x if shared is None else f"{x} ({words_of_shared(shared)})" for x, shared in known.items()]
            yield f"  excludes, since it {reason}: {listed(told)}"
    if situation.reading == "posterior":
        rivals = [g.id for g in situation.hypotheses if g.group == h.group and g.id != h.id]
        if rivals:
            yield f"  excludes, as rivals for one instance: {listed(rivals)}"
