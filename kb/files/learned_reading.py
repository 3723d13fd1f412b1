"""What a KB's folder holds of learned clouds and words, read with the mistakes met.

And a learned cloud as features of its type.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from kb.clouds.learned import MAX_BYTES, LearnedCloud, read_cloud
from kb.clouds.lobes import Feature, LobeTable
from kb.clouds.words import MAX_BYTES as MAX_WORDS
from kb.clouds.words import Words, dominant, read_words
from kb.errors import CloudError
from kb.files.branches import nodes
from kb.files.folder import Folder
from kb.files.yaml_text import Document

Kind = TypeVar("Kind")


def words_of(place: Folder, document: Document) -> Words | None:
    """The vocabulary that ``kb.yaml`` names; None where it names none, or with a mistake."""
    return _read(place, document, place.root, "words", MAX_WORDS, read_words)


def learned_of(place: Folder, document: Document, folder: Path) -> LearnedCloud | None:
    """The learned cloud that ``object.yaml`` names; None where it names none, or with a mistake."""
    by_hand = isinstance(document.data, dict) and any(kind != "object" for _, kind, _ in nodes(document.data))
    if by_hand and document.data.get("cloud"):
        why = "a type is learned or written by hand: with cloud there are no features, of the whole or of a part"
        place.mistakes.append(document.mistake(("cloud",), why, key=True))
    return _read(place, document, folder, "cloud", MAX_BYTES, read_cloud)


def _read(
    place: Folder, document: Document, folder: Path, key: str, limit: int, read: Callable[[bytes], Kind]
) -> Kind | None:
    entry = document.data.get(key) if isinstance(document.data, dict) else None
    file = entry.get("file") if isinstance(entry, dict) else None
    if not isinstance(file, str) or not file or "\0" in file:
        return None
    fault = place.fault(folder / file, limit)
    if fault is not None:
        place.mistakes.append(document.mistake((key, "file"), f"the file {file!r:.100} {fault}"))
        return None
    content = place.content(folder / file, limit)
    try:
        return None if content is None else read(content)
    except CloudError as error:
        place.mistakes.append(document.mistake((key, "file"), f"{file!r:.100} {error}"))
        return None


def check_words(place: Folder, document: Document, cloud: LearnedCloud | None, words: Words | None) -> None:
    """A learned cloud needs the vocabulary that it was learned with."""
    if cloud is None:
        return
    if words is None:
        place.mistakes.append(
            document.mistake(
                ("cloud",), "the knowledge base has no words (kb.yaml: words): learn the type again", key=True
            )
        )
    elif words.detector != cloud.detector or max(cloud.word.max(initial=-1), cloud.lobe_word.max(initial=-1)) >= len(
        words.centroids
    ):
        place.mistakes.append(
            document.mistake(
                ("cloud",), "was learned with other words than kb.yaml names: learn the type again", key=True
            )
        )


def check_parts(place: Folder, document: Document, cloud: LearnedCloud | None) -> None:
    """A learned cloud names no part that the type does not have."""
    objects = sum(1 for _, kind, _ in nodes(document.data) if kind == "object")
    if cloud is not None and cloud.part.max(initial=0) >= objects:
        what = f"knows {cloud.part.max()} parts, where there are {objects - 1}: learn the type again"
        place.mistakes.append(document.mistake(("cloud",), what, key=True))


def learned_features(cloud: LearnedCloud, words: Words, parts: Sequence[str] = ("",)) -> tuple[Feature, ...]:
    """Features ``f0001``, ..., ``lid/f0001``, or ``lid/c0001/f0001`` of a compound, each of the type of its dominant word.

    ``parts``: the objects of the type's tree. Their appearances are in ``learned_lobes``, as arrays.
    """
    names, still = words.names, np.eye(3)
    heads = [f"{part}/" if part else "" for part in parts]
    rows = zip(cloud.at, cloud.word, cloud.part.tolist(), cloud.compound.tolist(), strict=True)
    return tuple(
        Feature(f"{heads[part]}{f'c{group:04d}/' if group else ''}f{i:04d}", names[word], at, still, ())
        for i, (at, word, part, group) in enumerate(rows, 1)
    )


def with_compounds(
    seen: tuple[Feature, ...], cloud: LearnedCloud, words: Words
) -> tuple[tuple[Feature, ...], tuple[Feature, ...]]:
    """The maximal features, and every Feature node, of a learned cloud whose features are ``seen``: a compound before its parts (A1).

    A compound has the type of the word that dominates its parts' appearances, stands in their middle, and looks like
    any of them.
    """
    whole = dominant(cloud.compound[cloud.feature], cloud.lobe_word, cloud.hit, cloud.compounds + 1)
    maximal: list[Feature] = []
    every: list[Feature] = []
    order = np.argsort(cloud.compound, kind="stable")
    members = np.split(order, np.searchsorted(cloud.compound[order], np.arange(1, cloud.compounds + 1)))
    for row, group in enumerate(cloud.compound.tolist()):
        if not group:
            maximal.append(seen[row])
            every.append(seen[row])
        elif row == members[group][0]:
            its = [seen[i] for i in members[group].tolist()]
            name, middle = its[0].name.rpartition("/")[0], np.mean([part.at for part in its], axis=0)
            one = Feature(
                name, words.names[whole[group]], middle, np.eye(3), (), parts=tuple(part.name for part in its)
            )
            maximal.append(one)
            every += [one, *its]
    return tuple(maximal), tuple(every)


def learned_lobes(cloud: LearnedCloud, words: Words) -> LobeTable:
    """The lobes of a learned cloud as those of any type."""
    names = words.names
    return LobeTable(
        feature=cloud.feature.astype(np.intp),
        types=tuple(names[word] for word in cloud.lobe_word),
        at=cloud.at[cloud.feature],
        axis=cloud.axis,
        cos_half=np.cos(cloud.half_angle),
        r_min=cloud.r_min,
        r_max=cloud.r_max,
        features=len(cloud.at),
        size=cloud.size,
    )
