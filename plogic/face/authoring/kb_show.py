"""``plogic kb check``, ``show`` and ``measures``: what a knowledge base holds, as text, as JSON and as a page."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from kb.files.folder import parts_of
from kb.files.schema import json_schema
from kb.shown.show import check_report, tree_document, tree_text
from plogic.base.errors import InconsistentError, InputError
from plogic.face.shown.printed import written
from plogic.face.shown.tables import plain_table
from plogic.measures.distinctiveness import distinctiveness, instance_counts, probability_of_distinctiveness
from plogic.run.sources import kb_of
from plogic.scene.worlds.blame import blamed_without_scene

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase, ObjectType


def check_command(folder: str, *, as_json: bool) -> str:
    """Read the KB; every mistake is raised at once. The text says what was read, and warns of what matters.

    Raises InconsistentError too, where the author's rules leave no world, whatever is seen.
    """
    kb = kb_of(folder)
    excluded = blamed_without_scene(kb.rules)
    if excluded is not None:
        raise InconsistentError(f"{folder}: {excluded}, whatever is seen")
    from plogic.logic.safety.notes import notes
    from plogic.run.silence.too_few import seldom_found

    lines = check_report(kb)
    warned = sum(line.startswith("warning: ") for line in lines)
    but = {line.split(": ")[1] for line in lines[:warned]}
    noted = notes(kb.rules, "rules.pl", added=True)
    lines[warned:warned] = [f"warning: {text}" for text in (*seldom_found(kb, but), *noted)]
    if as_json:
        warnings = [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]
        return json.dumps(
            {"format": "kb_check/1", "kb": kb.name, "digest": kb.digest, "report": lines, "warnings": warnings}
        )
    return "\n".join(lines)


def show_command(folder: str, name: str | None = None, *, geometry: bool = False, as_json: bool) -> str:
    """The trees, of one type where it is named; the counts and dv, which are about all types. Or the ``geometry``."""
    kb = kb_of(folder)
    shown = kb if name is None else replace(kb, types=(type_of(kb, name),))
    if geometry:
        from plogic.face.authoring.kb_geometry import geometry_rows, geometry_text

        if as_json:
            return json.dumps({"format": "kb_geometry/1", "kb": kb.name, "types": geometry_rows(kb, shown.types)})
        return geometry_text(kb, shown.types)
    if as_json:
        return json.dumps({**tree_document(shown), "format": "kb_show/1"})
    return tree_text(shown) + "\n\n" + measures_command(folder, None, as_json=False)


def measures_command(folder: str, gamma: str | None, *, as_json: bool) -> str:
    """|S(F)|, P(dv), dv; with a Γ, every type's rank and what decides ties."""
    kb = kb_of(folder)
    counts = instance_counts(kb.types)
    dv, share = distinctiveness(counts), probability_of_distinctiveness(counts)
    rows = [{"type": name, "instances": counts[name], "p_dv": share[name], "dv": dv[name]} for name in counts]
    document: dict[str, Any] = {"format": "kb_measures/1", "kb": kb.name, "features": rows}
    if gamma is not None:
        document["ranks"] = _ranks(kb, gamma, dv)
    if as_json:
        return json.dumps(document)
    texts = [plain_table("features of Σo", _words_in_one_row(rows, kb))]
    if "ranks" in document:
        texts.append(plain_table("object types by rank", document["ranks"]))
    return "\n".join(texts)


def _words_in_one_row(rows: list[dict[str, Any]], kb: "KnowledgeBase") -> list[dict[str, Any]]:
    """The rows for people: those of visual words, hundreds of them, summed up with the range of their dv."""
    names = set(kb.words.names) if kb.words is not None else set()
    words, others = [row for row in rows if row["type"] in names], [row for row in rows if row["type"] not in names]
    if not words:
        return others
    share, dv = sum(row["p_dv"] for row in words), [row["dv"] for row in words]
    texts = f"{len(words)} visual words of {len(names)}", f"{min(dv):.3f} to {max(dv):.3f}"
    return [
        *others,
        {"type": texts[0], "instances": sum(row["instances"] for row in words), "p_dv": share, "dv": texts[1]},
    ]


def _ranks(kb: "KnowledgeBase", gamma: str, dv: dict[str, float]) -> list[dict[str, Any]]:
    from plogic.cycle.perception import attend
    from plogic.match.kinds import models_of
    from sensing.files.gamma_files import read_gamma

    types = [a.type for a in read_gamma(gamma, kb.appearance_types).appearances]
    rows = attend(models_of(kb, dv).values(), types, kb)
    return [{"type": r.type, "rank": r.rank, "excess": r.excess, "within_cell": r.within_cell} for r in rows]


def schema_command(which: Literal["kb", "object"]) -> str:
    """JSON Schema of a KB's file."""
    return json.dumps(json_schema(which), indent=1)


def page_command(
    folder: str, name: str | None, out: str, *, say: Callable[[str], None], write: Callable[[str], None]
) -> None:
    """Write the page of a type, the KB's only one where none is named; `-` is stdout. Raises InputError."""
    from plogic.face.pages.type_content import type_page
    from sensing.files.whole_files import check_places

    if out != "-":
        check_places([Path(out)], parts_of(folder))
    kb = kb_of(folder)
    written(type_page(kb, type_of(kb, name)), out, say=say, write=write)


def type_of(kb: "KnowledgeBase", name: str | None) -> "ObjectType":
    """The type of that name. Raises InputError, naming those that there are."""
    known = {kind.name: kind for kind in kb.types}
    there = f"there are: {', '.join(known) or 'none (plogic kb add)'}"
    if name is not None and name not in known:
        raise InputError(f"{name}: no such object type; {there}")
    if name is None and len(known) != 1:
        raise InputError(f"{kb.name}: a page shows one object type: name it; {there}")
    return known[name] if name is not None else kb.types[0]
