"""Why nothing was found, or not a certain type: the first cause that explains it, a line a type.

Causes are looked for from the plain to the far-fetched: a picture that lacks what types were learned from, no data,
data of other types, too few of them, a camera that is no picture's, a type whose own files do not fit together, and one
thing of the knowledge base or of Γ that, were it otherwise, would let the type be found
(``plogic.run.silence.otherwise``). Else the best pose that was tried is told.
"""

from collections import Counter
from collections.abc import Iterator, Sequence

from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.word_names import is_word
from kb.shown.cautions import of_type, unseen_told
from kb.shown.seen_from import unseen_features
from plogic.cycle.judging import FEWEST
from plogic.facts.document import Interpretation, RejectedRow
from plogic.facts.interpretation import found_and_usual
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from plogic.run.silence.beforehand import findable, listed
from plogic.run.silence.otherwise import CONVINCING, camera_doubt, causes
from plogic.run.silence.picture import lacking
from plogic.run.silence.too_few import seldom_found
from sensing.appearance import Gamma

MOST_DATA = 400
"""Data with which it is still tried what would be found otherwise: each try is a search."""
MOST_TYPES = 5
"""Types of which it is tried, those first that attention is drawn to most."""
SHOWN = 3
"""Lines that are told of an empty answer."""


def why_nothing(document: Interpretation, gamma: Gamma, kb: KnowledgeBase) -> list[str]:
    """The lines on an empty answer, most telling first; none where ``beforehand`` has said it all."""
    kinds = findable(kb)
    return (
        [f"nothing found: {line}" for line in _lines(document, gamma, kb, kinds, thorough=False)][:SHOWN]
        if kinds
        else []
    )


def why_missing(document: Interpretation, gamma: Gamma, kb: KnowledgeBase, kind: ObjectType) -> list[str]:
    """The same of one type."""
    return list(_lines(document, gamma, kb, (kind,), thorough=True))


def _lines(
    document: Interpretation, gamma: Gamma, kb: KnowledgeBase, kinds: Sequence[ObjectType], *, thorough: bool
) -> Iterator[str]:
    learned, about_data = any(kind.learned is not None for kind in kinds), _of_data(gamma, kinds)
    if learned or about_data:
        yield from lacking(document, learned=learned)
    if about_data:
        yield about_data
        return
    doubt = camera_doubt(gamma.camera)
    if doubt:
        yield doubt
    some = _attended(document, [kind for kind in kinds if _enough(gamma, kind)])[:MOST_TYPES]
    cautions = {kind.name: [*of_type(kind, kb.f_ref)] for kind in some if kind.learned is None}
    unfit = {kind.name: lines[0] for kind in some if (lines := cautions.get(kind.name)) and _decides(lines, kind, kb)}
    yield from (f"{name}: {line}" for name, line in unfit.items())
    left = [kind for kind in some if kind.name not in unfit]
    shown = set()
    dv = distinctiveness(instance_counts(kb.types))
    enough = [kind for kind in left if _enough(gamma, kind, CONVINCING[0])]
    if len(gamma.appearances) <= MOST_DATA:
        for kind, told in causes(enough, kb, gamma, dv, thorough=thorough):
            shown.add(kind.name)
            yield f"{kind.name}: {told}"
    for kind in left:
        if kind.name not in shown:
            yield from _seldom(kind, kb) if thorough else ()
            yield best_told(document, kind.name)
        yield from (f"{kind.name}: besides, {line}" for line in cautions.get(kind.name, ()))


def _decides(lines: Sequence[str], kind: ObjectType, kb: KnowledgeBase) -> bool:
    """Whether what is amiss with a type keeps it from being found; unseen features do not, where the others suffice."""
    unseen = unseen_features(kind)
    return not unseen or list(lines) != [unseen_told(unseen)] or bool(_seldom(kind, kb))


def _seldom(kind: ObjectType, kb: KnowledgeBase) -> list[str]:
    """That it shows too little to be accepted, if it does."""
    return list(seldom_found(kb, {other.name for other in kb.types if other.name != kind.name}))


def _of_data(gamma: Gamma, kinds: Sequence[ObjectType]) -> str:
    """Why the data cannot be of any of these types, '' where they may be."""
    here = Counter(a.type for a in gamma.appearances)
    asked = sorted({name for kind in kinds for name in kind.lobes.types if not is_word(name)})
    looks = ", ".join(asked[:6]) + (", ..." if len(asked) > 6 else "") or "visual words"
    names = listed(kinds)
    if not here:
        return f"there are no appearances at all: nothing of the types that {names} looks like ({looks}) was detected"
    most = max(kinds, key=lambda kind: looks_like(here, kind).total())
    number = looks_like(here, most).total()
    if not number:
        seen = ", ".join(f"{count} {name}" for name, count in here.most_common(3))
        return (
            f"none of the {here.total()} appearances is of a type that {names} looks like ({looks}): there are {seen}"
        )
    if number < FEWEST:
        what = f"only {number} appearance{'s' * (number > 1)} of {here.total()} may be of {most.name}"
        return f"{what}, and {FEWEST} features must be detected: is more of it in sight, or can more be detected?"
    return ""


def looks_like(here: Counter[str], kind: ObjectType) -> Counter[str]:
    """The data, counted by type, that are of a type which some feature of the kind looks like."""
    looks = set(kind.lobes.types)
    return Counter({name: count for name, count in here.items() if name in looks})


def _enough(gamma: Gamma, kind: ObjectType, number: int = FEWEST) -> bool:
    return looks_like(Counter(a.type for a in gamma.appearances), kind).total() >= number


def _attended(document: Interpretation, kinds: Sequence[ObjectType]) -> list[ObjectType]:
    """In the order of attention, as the trace tells it."""
    order = [step["type"] for step in document.get("trace", []) if step["event"] == "rank"]
    return sorted(kinds, key=lambda kind: (order.index(kind.name) if kind.name in order else len(order), kind.name))


def tried(document: Interpretation, name: str) -> list[RejectedRow]:
    """The rejected hypotheses of a type that the document holds, best first."""
    rows = [h for h in document["hypotheses"] if h["status"] == "rejected" and h["type"] == name]
    return sorted(rows, key=lambda h: -h.get("log_likelihood_ratio", 0.0))


def best_told(document: Interpretation, name: str) -> str:
    """How far the best pose came, or that there was none."""
    rows = tried(document, name)
    if not rows:
        return f"{name}: no pose was found that explains the data well enough to be judged"
    found, expected = counted(rows[0])
    away = rows[0]["T_camera_object"][2][3]
    what = f"its best pose, {away:.2g} m away, has {found} of {expected} expected features detected"
    usual = found_and_usual(rows[0]["features"])
    what += "" if usual is None else f", where {usual[2]} were when it was learned"
    return f"{name}: {what}, but: {rows[0].get('why', '')}"


def counted(row: RejectedRow) -> tuple[int, int]:
    """Expected features that are detected, and all that are expected."""
    cells = row.get("support", {}).values()
    found = sum(cell["expected_detected"] for cell in cells)
    return found, found + sum(cell["expected_missed"] for cell in cells)
