"""What of a knowledge base is never found, and what of it may surprise: told before anything is searched for.

* ``findable(kb)``: the types that a search can find
* ``beforehand(kb, folder)``: a line for each reason why others cannot, and for meshes that are no solids
"""

from collections.abc import Iterator, Sequence
from shlex import quote

from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.shown.cautions import one_feature_type, remedy
from kb.shown.seen_from import FIXING_A_POSE

NAMED = 3
"""Types that a line names; the rest are counted."""


def findable(kb: KnowledgeBase) -> tuple[ObjectType, ...]:
    """The types with features enough for a pose; none where every dv is 0."""
    if one_feature_type(kb):
        return ()
    return tuple(kind for kind in kb.types if len(kind.seen_features) >= FIXING_A_POSE)


def beforehand(kb: KnowledgeBase, folder: str) -> Iterator[str]:
    """A line each, with the remedy; ``folder`` names the knowledge base on the command line."""
    if not kb.types:
        yield f"{kb.name} has no object type, so nothing can be found: plogic kb add NAME --mesh FILE --kb {quote(folder)}"
        return
    plain = [(kind, remedy(kind, f"--kb {quote(folder)}")) for kind in kb.types if not kind.features]
    for told in dict.fromkeys(told for _, told in plain):
        some = [kind for kind, other in plain if other == told]
        one = len(some) == 1
        what = f"{listed(some)} {'has' if one else 'have'} no features, so {'it is' if one else 'they are'} never found"
        yield f"{what}: {told}"
    if one_feature_type(kb):
        yield f"{one_feature_type(kb)}; give some features a type of their own"
    few = [kind for kind in kb.types if 0 < len(kind.seen_features) < FIXING_A_POSE]
    if len(few) == 1:
        yield f"{few[0].name} has {len(few[0].seen_features)} features, and a pose is taken from {FIXING_A_POSE}: it is never found; give it more"
    elif few:
        yield f"{listed(few)} have fewer than {FIXING_A_POSE} features, from which a pose is taken: they are never found; give them more"
    yield from _meshes(kb, folder)


def _meshes(kb: KnowledgeBase, folder: str) -> Iterator[str]:
    """What is no solid as it is; one line however many there are."""
    open_ones = [kind for kind in kb.types if kind.surface is not None and kind.surface.caution]
    if len(open_ones) == 1 and open_ones[0].surface is not None:
        yield f"{open_ones[0].name}: {open_ones[0].surface.caution}"
    elif open_ones:
        yield f"{listed(open_ones)}: their meshes are not closed, or not manifold; what A4 makes of each is told by: plogic kb check {quote(folder)}"


def listed(kinds: Sequence[ObjectType]) -> str:
    """The names of the first few, and how many more there are."""
    names = [kind.name for kind in kinds]
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + more
