"""Layer 1 of the program: Σo, each object type once, and of which type each hypothesis is (§8).

What is said of a hypothesis follows from its type by rules (``plogic.scene.text.rules.OBJECT_TYPES``); what a
document tells of one hypothesis and not of all of its type is said of that one alone.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from plogic.base.walk import by_key
from plogic.facts.hypothesis import PartFact, feature_nodes
from plogic.facts.situation import TypeFact
from plogic.scene.text.layout import Writer, number, quoted


class Said(NamedTuple):
    """What is said of a hypothesis, or of a type.

    Part → the node that it is a part of, '' the object itself; feature → its type; the parts that are objects; whether
    it is opaque.
    """

    parts: dict[str, str]
    features: dict[str, str]
    objects: frozenset[str]
    opaque: bool


def label_comments(w: Writer) -> Iterator[str]:
    """What generated names stand for."""
    generated = w.names.generated()
    if generated:
        yield "% Names in this text, and the labels that they stand for:"
        yield from (f"%   {atom} = {quoted(label)}" for atom, label in generated)


def object_types(w: Writer) -> Iterator[str]:
    """Each type, with its parts, its features and how they look, and its facets; then the hypotheses."""
    types = _types(w)
    if any(fact.looks for fact in w.scene.situation.types.values()):
        yield "% A look is seen from its lobe: axis x, y, z in the object's frame, half angle, rad, nearest and farthest, m."
    for name, said in types.items():
        yield ""
        yield from _type(w, name, said)
    if w.scene.situation.hypotheses:
        yield from ("", "% Δh: of which type each hypothesis is, and for which instance it competes.")
    for h in w.scene.situation.hypotheses:
        yield f"{w.fact('hypothesis', h.id, h.type)} {w.fact('instance', h.id, h.group)}"
        yield from _own(w, h.id, _said(h.parts, [(f.id, f.type) for f in h.features], opaque=h.opaque), types[h.type])
    yield from _lists(w, types)


def _lists(w: Writer, types: Iterable[str]) -> Iterator[str]:
    """All hypotheses, and those of each type, as lists that are counted along."""
    everyone = w.scene.situation.hypotheses
    yield f"hypotheses({w.list(h.id for h in everyone)})."
    yield from (
        f"hypotheses_of({w.names.atom(name)}, {w.list(h.id for h in everyone if h.type == name)})." for name in types
    )


def _types(w: Writer) -> dict[str, Said]:
    """Of each type what is said of all its hypotheses; where there is none, what Σo says."""
    found: dict[str, list[Said]] = {}
    for h in w.scene.situation.hypotheses:
        said = _said(h.parts, [(f.id, f.type) for f in h.features], opaque=h.opaque)
        found.setdefault(h.type, []).append(said)
    for name, fact in w.scene.situation.types.items():
        found.setdefault(name, [_said(fact.parts, fact.features, opaque=fact.opaque)])
    return {name: _common(several) for name, several in found.items()}


def _said(parts: Sequence[PartFact], features: Iterable[tuple[str, str]], *, opaque: bool) -> Said:
    kinds, known = feature_nodes(parts, features), {part.id for part in parts}
    wholes = {part.id: part.parent if part.parent in known else "" for part in parts}
    wholes |= {path: _host(path, known) for path in kinds if path not in known}
    return Said(wholes, kinds, frozenset(part.id for part in parts if part.kind == "object"), opaque)


def _host(path: str, known: set[str]) -> str:
    """The nearest part on the way to the feature; '' where there is none."""
    steps = path.split("/")[:-1]
    ways = ("/".join(steps[:n]) for n in range(len(steps), 0, -1))
    return next((way for way in ways if way in known), "")


def _common(several: Sequence[Said]) -> Said:
    first, *rest = several
    parts = {part: whole for part, whole in first.parts.items() if all(s.parts.get(part) == whole for s in rest)}
    features = {path: kind for path, kind in first.features.items() if all(s.features.get(path) == kind for s in rest)}
    objects = first.objects.intersection(*(s.objects for s in rest))
    return Said(parts, features, objects, all(s.opaque for s in several))


def _type(w: Writer, name: str, said: Said) -> Iterator[str]:
    fact = w.scene.situation.types.get(name, TypeFact())
    kind = w.names.atom(name)
    yield f"object_type({kind})." + (f" type_opaque({kind})." if said.opaque else "")
    for part, whole in said.parts.items():
        if part not in said.features:
            is_object = f" object_part({kind}/{w.names.atom(part)})." if part in said.objects else ""
            yield _part(w, name, part, whole) + is_object
    looks = by_key((look.feature, look) for look in fact.looks)
    for path, type_of in said.features.items():
        yield f"{_part(w, name, path, said.parts[path])} {w.fact('type_feature', name, path, type_of)}"
        for look in looks.get(path, ()):
            numbers = ", ".join(map(number, (*look.axis, look.half_angle, look.r_min, look.r_max)))
            yield f"  type_look({w.atoms(name, path, look.type)}, lobe({numbers}))."
    for polygon, several in (("facet", fact.facets), ("face", fact.faces)):
        yield from (f"{polygon}({kind}, {w.list(v)})." for v in several if said.features.keys() >= set(v))


def _part(w: Writer, name: str, part: str, whole: str) -> str:
    kind = w.names.atom(name)
    return f"type_part({kind}/{w.names.atom(part)}, {f'{kind}/{w.names.atom(whole)}' if whole else kind})."


def _own(w: Writer, name: str, said: Said, of_type: Said) -> Iterator[str]:
    """What is said of a hypothesis and not of its type."""
    me = w.names.atom(name)
    if said.opaque > of_type.opaque:
        yield f"opaque_surface({me})."
    for part, whole in said.parts.items():
        if part not in of_type.parts:
            yield f"part_of({me}/{w.names.atom(part)}, {f'{me}/{w.names.atom(whole)}' if whole else me})."
    yield from (
        w.fact("feature_of", name, path, kind) for path, kind in said.features.items() if path not in of_type.features
    )
