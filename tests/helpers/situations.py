"""Situations to test with: built by hand, and drawn by hypothesis."""

from __future__ import annotations

from dataclasses import replace
from random import Random

from hypothesis import strategies as st

from geometry.visibility.roc import ROC20
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.pixel_table import PixelTable
from plogic.facts.situation import AppearanceFact, PairFact, Situation, pair_facts
from plogic.facts.spatial import Foot, Gravity
from plogic.facts.stances import Stance, Support, SupportPlane

POSE = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 5.0), (0.0, 0.0, 0.0, 1.0))
INSTANCES = {"apex": 1, "corner": 16, "other": 95}
DV = {name: 1 - n / sum(INSTANCES.values()) for name, n in INSTANCES.items()}
"""dv over the towers' own composition (§5.6), not from constants."""

T2_DISTORTED = {"apex": (1, 0, 0, 0), "corner": (0, 6, 1, 2), "other": (1, 16, 12, 16)}
T2_CORRECT = {"apex": (1, 0, 0, 0), "corner": (4, 2, 2, 0), "other": (9, 4, 16, 2)}
T1_CORRECT = {"apex": (0, 0, 0, 0), "corner": (7, 0, 0, 0), "other": (27, 0, 23, 0)}


def feature(name, case="A", **changes):
    """One feature in case A, C, B or D of the hypothesis alone; matched to the appearance of its own name."""
    matched = case in "AD"
    plain = FeatureFact(
        id=name,
        type="corner",
        at=(0.0, 0.0, 5.0),
        uv=(1.0, 1.0),
        dv=0.5,
        in_image=True,
        in_lobe=case in "AC",
        self_hidden=False,
        match=f"a_{name}" if matched else None,
        residual=0.5 if matched else None,
        density=0.05 if matched else 0.0,
    )
    return replace(plain, **changes)


def from_table(name, cells):
    """The features of one row of Table 1, each matched to an appearance of its own."""
    return tuple(
        feature(
            f"{kind}/{case.lower()}{i}",
            case,
            type=kind,
            dv=DV[kind],
            match=f"{name}_{kind}_{case}{i}" if case in "AD" else None,
        )
        for kind, row in cells.items()
        for case, n in zip("ACBD", row, strict=True)
        for i in range(n)
    )


def hypothesis(name, features, **changes):
    return replace(
        Hypothesis("box", POSE, opaque=True, id=name, group=f"g_{name}", features=tuple(features)), **changes
    )


def situation(hypotheses, reading="score", mode="to_B", **changes):
    """A situation whose Γ is what its hypotheses are matched to."""
    names = sorted({f.match for h in hypotheses for f in h.features if f.match})
    data = tuple(AppearanceFact(name, "l_junction", (1.0, 1.0), 2e-5) for name in names)
    plain = Situation(
        reading, tuple(hypotheses), data, mode, dv=DV, rank={"box": 0.9}, priors={"box": 0.3, "t1": 0.5, "t2": 0.5}
    )
    return replace(plain, **changes)


def towers(reading="score", mode="drop", **changes):
    """The worked example of §8: T1 hides what is missed of the right T2; the distorted T2 shares volume with it."""
    behind_t1 = tuple(replace(f, hidden_by=("t1",)) if "/c" in f.id else f for f in from_table("y", T2_CORRECT))
    hypotheses = (
        hypothesis("t1", from_table("x", T1_CORRECT), type="t1"),
        hypothesis("t2", behind_t1, type="t2", group="g"),
        hypothesis("t2_distorted", from_table("z", T2_DISTORTED), type="t2", group="g"),
    )
    pair = frozenset({("t2", "t2_distorted")})
    relations = (PairFact("partially_occludes", "t1", "t2", "partially_occludes_po"),)
    return situation(hypotheses, reading, mode, overlaps=pair, rivals=pair, relations=relations, **changes)


def _features(rng, names, me):
    """Up to four features; appearances are shared between hypotheses, never within one."""
    others = [name for name in names if name != me]
    matches = rng.sample([f"a{i}" for i in range(6)], rng.randint(1, 4))
    return tuple(
        FeatureFact(
            id=f"part/f{i}",
            type="corner",
            at=(0.0, 0.0, 5.0),
            uv=(1.0, 1.0),
            dv=rng.choice([0.0, 0.15, 0.5, 0.86, 0.99]),
            in_image=rng.random() < 0.8,
            in_lobe=rng.random() < 0.8,
            self_hidden=rng.random() < 0.2,
            hidden_by=tuple(sorted(rng.sample(others, rng.randint(0, min(2, len(others)))))),
            match=match if rng.random() < 0.6 else None,
            residual=rng.choice([0.2, 0.5, 1.5]),
            density=rng.choice([1e-7, 1e-3, 0.05, 0.2]),
            hit_rate=rng.choice([0.3, 0.8, 0.95]),
        )
        for i, match in enumerate(matches)
    )


def _some(rng, pairs):
    return frozenset(rng.sample(pairs, rng.randint(0, min(2, len(pairs)))))


def random_situations(most=5, readings=("score", "posterior"), modes=("to_B", "drop", "reassign")):
    """1 to ``most`` hypotheses: cyclic occlusion, rivals, overlaps, exclusive pairs, groups, smoothing.

    Drawn from a seed: what hypothesis draws one by one keeps near its simplest, a lone hypothesis that shares nothing,
    far too often.
    """
    return st.integers(0, 2**32 - 1).map(lambda seed: _random_situation(Random(seed), most, readings, modes))  # noqa: S311 - a test's


def _random_situation(rng, most, readings, modes):
    names = [f"h{i}" for i in range(1, rng.randint(1, most) + 1)]
    pairs = [(x, y) for i, x in enumerate(names) for y in names[i + 1 :]]
    exclusive = _some(rng, pairs)
    hypotheses = tuple(
        Hypothesis(
            rng.choice(["t1", "t2", "A Box"]),
            POSE,
            id=name,
            opaque=rng.random() < 0.8,
            group=rng.choice(["g1", "g2", "g3"]),
            features=_features(rng, names, name),
        )
        for name in names
    )
    return Situation(
        reading=rng.choice(readings),
        hypotheses=hypotheses,
        appearances=tuple(
            AppearanceFact(f"a{i}", "l_junction", (1.0, 1.0), rng.choice([1e-5, 1e-3])) for i in range(6)
        ),
        reconsider=rng.choice(modes),
        overlaps=_some(rng, pairs),
        rivals=_some(rng, pairs) | exclusive,
        exclusive=exclusive,
        relations=tuple(fact for x, y in sorted(_some(rng, pairs)) for fact in pair_facts(rng.choice(ROC20), x, y)),
        priors={"t1": 0.4, "t2": 0.2},
        smoothing=rng.choice([0.0, 0.01]),
    )


def with_gravity(subject, seed, **changes):
    """Of which some float in some worlds: heights and who rests on whom are drawn.

    The ground's height is told in half of them.
    """
    rng = Random(seed)  # noqa: S311 - a test's
    known = [h.id for h in subject.hypotheses if rng.random() < 0.9]
    feet = tuple(
        Foot(name, low, low + rng.choice([0.0, 0.05])) for name in known for low in [rng.choice([0.0, 0.1, 0.2, 0.3])]
    )
    apart = {frozenset(pair) for pair in subject.overlaps}
    rests = [(x, y) for x in known for y in known if x != y and frozenset((x, y)) not in apart and rng.random() < 0.25]
    ground = rng.choice([None, 0.02])
    rests += [(foot.id, "ground") for foot in feet if ground is not None and foot.low <= ground]
    return replace(
        subject, gravity=replace(Gravity(rng.choice([0.02, 0.3, 0.9, 1.0]), ground, feet, tuple(rests)), **changes)
    )


def with_pixels(subject, seed, most=2):
    """Of which some have pixels that a photo told, by who of others is present before them."""
    rng = Random(seed)  # noqa: S311 - a test's

    def table(h):
        others = [g.id for g in subject.hypotheses if g.id != h.id]
        before = rng.sample(others, rng.randint(0, min(most, len(others))))
        odds = tuple(rng.choice([0.0, rng.uniform(-12.0, 8.0), 30.0]) for _ in range(2 ** len(before)))
        return PixelTable(tuple(before), odds) if rng.random() < 0.8 else None

    return replace(subject, hypotheses=tuple(h.told(pixel_table=table(h)) for h in subject.hypotheses))


LEVEL = (0.0, -1.0, 0.0)
TIGHT = ((1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4))


def plane(name, prior, **changes):
    """A level plane half a metre below the camera."""
    return replace(SupportPlane(name, LEVEL, -0.5, TIGHT, prior), **changes)


def shares(rng, count):
    """So many shares of 1, and at times 0 of what is left."""
    weights = [rng.choice([0.0, 0.1, 0.3, 0.5, 1.0]) for _ in range(count)] + [rng.choice([0.0, 0.1, 0.5])]
    return [w / (sum(weights) or 1.0) for w in weights[:count]]


def with_support(subject, seed, most=4):
    """Planes, up to ``most``, and ways to stand on them and on each other, drawn; some priors and chances are 0.

    In half of them some stand by chance where they are absent; some may be level above a plane on something unknown.
    """
    rng = Random(seed)  # noqa: S311 - a test's
    *priors, none = shares(rng, rng.randint(0, most) + 1)
    planes = tuple(plane(f"s{i}", prior) for i, prior in enumerate(priors, 1))
    rests = rng.choice([0.0, 0.3, 0.9, 0.9, 0.95, 1.0])
    ids = [h.id for h in subject.hypotheses]
    order = rng.sample(ids, len(ids))
    stances = []
    for i, name in enumerate(order):
        below = [(x, rng.randint(0, 2)) for x in order[:i] if rng.random() < 0.7]
        here = {p.name: [(p.name, face) for face in range(rng.randint(1, 2))] for p in planes if rng.random() < 0.7}
        for ways in (below, *here.values()):  # at most half of the chances on others, half on any plane
            stances += [
                Stance(
                    name,
                    on,
                    face,
                    0.5 * rests * share,
                    rng.choice([0.0, *(rng.uniform(-4.0, 6.0) for _ in range(3)), -40.0]),
                )
                for (on, face), share in zip(ways, shares(rng, len(ways)), strict=True)
            ]
    some = [name for name in ids if rng.random() < 0.8] if rng.random() < 0.5 else []
    by_chance = tuple((name, rng.choice([0.12, 0.12, 0.5, 0.0, 1.0])) for name in some)
    level = [(name, p.name, rng.choice([0.5, 3.0, 20.0])) for name in ids for p in planes if rng.random() < 0.2]
    return replace(subject, support=Support(rests, none, planes, tuple(stances), by_chance, tuple(level)))
