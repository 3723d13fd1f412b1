"""A knowledge base with hand-modelled types back to its folder: the same objects give the same bytes."""

import os
import re

from kb.clouds.cloud import UNKNOWN_SUPPORT
from kb.errors import KBError
from kb.files.write import flow, obj_text, object_text

_SAFE_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_. -]*")


def kb_text(kb):
    """``kb.yaml``."""
    rates = kb.rates
    rows = {
        "name": kb.name,
        "appearance_types": list(kb.appearance_types),
        "f_ref": kb.f_ref,
    } | ({"gravity": _gravity(kb)} if kb.rests is not None else {})
    lines = [f"{key}: {flow(value)}" for key, value in rows.items()]
    lines += ["detector:", f"  hit: {flow(rates.hit)}", f"  clutter: {flow(rates.clutter)}"]
    lines += [
        f"  sigma: {flow(rates.sigma)}",
        f"  sigmas: {flow(rates.sigmas)}",
        f"  match_tolerance: {flow(rates.match_tolerance)}",
    ]
    lines += [] if rates.sigma_angle is None else [f"  sigma_angle: {flow(rates.sigma_angle)}"]
    lines += [f"priors: {flow(rates.prior)}", *_counts_lines(rates.counts)]
    return "\n".join(lines) + "\n"


def _gravity(kb):
    if kb.maybe:
        return "maybe"
    if kb.unknown_support == UNKNOWN_SUPPORT and kb.ground is None:
        return True
    return {"unknown_support": kb.unknown_support} | ({} if kb.ground is None else {"ground": kb.ground})


def _counts_lines(counts):
    if counts:
        yield "counts:"
        for name in ("hit", "clutter", "prior"):
            yield f"  {name}: {flow({key: list(pair) for key, pair in getattr(counts, name).items()})}"


def kb_files(kb):
    """Every file of the folder, by relative path.

    Surfaces are written as ``mesh.obj`` in metres; textures do not travel.

    Raises:
        KBError: for a type whose name cannot be a folder's; for learned types and their words, which only a copy of the
        folder keeps.
    """
    learned = [kind.name for kind in kb.types if kind.learned is not None]
    if learned or kb.words is not None:
        raise KBError(
            f"{kb.name}: what was learned ({', '.join(learned) or 'words'}) cannot be written anew: copy the knowledge base's folder"
        )
    files = {"kb.yaml": kb_text(kb)} | ({"rules.pl": kb.rules} if kb.rules else {})
    for kind in kb.types:
        if not _SAFE_NAME.fullmatch(kind.name):
            raise KBError(f"the type {kind.name!r} cannot be written: its name cannot be a folder's")
        folder = f"objects/{kind.name}"
        files[f"{folder}/object.yaml"] = object_text(kind, "mesh.obj" if kind.surface else None)
        if kind.surface:
            files[f"{folder}/mesh.obj"] = obj_text(kind.surface)
    return files


def write_kb(kb, folder):
    """Write every file of ``kb_files``, each whole or not at all, over those that are there.

    Raises:
        KBError: as ``kb_files`` does; nothing is written then.
    """
    for name, text in kb_files(kb).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        rough = path.with_name(f".{path.name}.part")
        rough.write_text(text, encoding="utf-8")
        os.replace(rough, path)  # noqa: PTH105 - the rename is what makes it whole
