"""What in a knowledge base is no mistake and yet matters: what will never be found, or be found where it is not."""

from __future__ import annotations

from itertools import permutations
from typing import TYPE_CHECKING

from kb.shown.contained import contained_in
from kb.shown.learned_summary import MANY, learned_summary
from kb.shown.unseen import FEWEST, most_together, unseen_features

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kb.clouds.cloud import KnowledgeBase, ObjectType

MOST_NAMED = 5
"""Features named in one warning; the rest are counted."""
MOST_TYPES = 60
"""Types that are compared with each other."""


def cautions(kb: KnowledgeBase) -> Iterator[str]:
    """A sentence about each, the KB's own first, then by type."""
    sorts = {feature.type for kind in kb.types for feature in kind.all_features}
    if len(sorts) == 1:
        yield f"every feature is of type {sorts.pop()!r}, so that every dv is 0 and ev is undefined: nothing will be accepted"
    for kind in kb.types:
        yield from (f"{kind.name}: {text}" for text in _of_type(kind))
    yield from _contained(tuple(kind for kind in kb.types if kind.learned is None)[:MOST_TYPES])
    yield from _same_clouds([kind for kind in kb.types if kind.learned is not None])


def _of_type(kind: ObjectType) -> Iterator[str]:
    yield from _of_mesh(kind)
    if not kind.features:
        yield "has no features, so it is never found; learn them: plogic kb learn"
        return
    if kind.learned is not None:
        yield from _of_learned(kind)
        return
    unseen = unseen_features(kind)
    if unseen:
        yield f"no viewpoint sees {_named(unseen)}: the lobes lie inside or behind the type's own body"
    together = most_together(kind)
    if len(kind.features) < FEWEST:
        yield f"has {len(kind.features)} features, and a pose is taken from {FEWEST}: it is never found"
    elif together < FEWEST and len(unseen) < len(kind.features):
        yield f"its lobes never meet: no viewpoint was found that sees {FEWEST} features at once ({together} at most), so it is never found"


def _of_learned(kind: ObjectType) -> Iterator[str]:
    """Its lobes were measured, so that each is seen from somewhere; but there may be too few."""
    summary = learned_summary(kind)
    if summary.most < FEWEST:
        yield f"no viewpoint expects {FEWEST} of its learned features at once ({summary.most} at most), so it is never found"
    elif summary.most < MANY:
        yield f"no viewpoint expects {MANY} of its learned features at once ({summary.most} at most): it will seldom be found; its texture is plain"


def _of_mesh(kind: ObjectType) -> Iterator[str]:
    surface = kind.surface
    if surface is None or surface.solid is surface:
        return
    what = f"the mesh is not closed ({surface.faults})" if not surface.closed else "the mesh encloses no volume"
    solid, done, refused = surface.mended
    if solid is not None:
        yield f"{what}; repaired for shared volume (A4): {done}; {solid.volume:.4g} m3"
    else:
        yield f"{what}; refused as a solid: {refused}. It hides what is behind it all the same, but A4 says nothing of it: others may stand in it"


def _named(names: list[str]) -> str:
    more = f" and {len(names) - MOST_NAMED} more features" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more


def _contained(types: tuple[ObjectType, ...]) -> Iterator[str]:
    inside = {(a.name, b.name) for a, b in permutations(types, 2) if contained_in(a, b)}
    for a, b in sorted(inside):
        if (b, a) not in inside:
            yield f"{a}: its cloud is contained in that of {b}: wherever {b} stands, {a} fits as well"
        elif a < b:
            yield f"{a}: its cloud is the same as that of {b}: nothing tells them apart"


def _same_clouds(learned: list[ObjectType]) -> Iterator[str]:
    """Types that were learned from the same mesh and paint."""
    first: dict[bytes, str] = {}
    for kind in learned:
        assert kind.learned is not None  # noqa: S101 - the caller chose
        looks = kind.learned.at.tobytes() + kind.learned.descriptor.tobytes()
        if looks in first:
            yield f"{kind.name}: its cloud is the same as that of {first[looks]}: nothing tells them apart"
        first.setdefault(looks, kind.name)
