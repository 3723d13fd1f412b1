"""Learned rates back into the text of a ``kb.yaml`` that somebody wrote: everything else in it, comments included, stays."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kb.clouds.cloud import Rates

DIGITS = 4
"""Significant digits of a learned rate: a thousand scenes do not tell more."""


def with_rates(text: str, rates: Rates) -> str:
    """The text with the hit rates, clutter and priors that have counts, and with the counts; ``text`` must be a KB's that was read."""
    yaml = YAML(typ="rt")
    yaml.width = 4096
    yaml.preserve_quotes = True
    document = yaml.load(text)
    counts = rates.counts
    detector = _inner(document, "detector")
    _put(_inner(detector, "hit"), {name: rates.hit[name] for name in counts.hit})
    _put(_inner(detector, "clutter"), {name: rates.clutter[name] for name in counts.clutter})
    _put(_inner(document, "priors"), {name: rates.prior[name] for name in counts.prior})
    table = _inner(document, "counts")
    for key in ("hit", "clutter", "prior"):
        _put(_inner(table, key), {name: _pair(pair) for name, pair in getattr(counts, key).items()})
    buffer = io.StringIO()
    yaml.dump(document, buffer)
    return buffer.getvalue()


def rounded(value: float) -> float:
    """To ``DIGITS`` significant digits."""
    return float(f"{value:.{DIGITS}g}")


def _inner(document: Any, key: str) -> Any:  # noqa: ANN401 - ruamel's own mapping
    """The mapping under a key; a new one where there is none."""
    if document.get(key) is None:
        document[key] = CommentedMap()
    return document[key]


def _put(table: Any, values: Mapping[str, Any]) -> None:  # noqa: ANN401 - ruamel's own mapping
    if not len(table):
        table.fa.set_flow_style()
    for name, value in values.items():
        table[name] = rounded(value) if isinstance(value, float) else value


def _pair(pair: tuple[float, float]) -> Any:  # noqa: ANN401 - ruamel's own list
    numbers = CommentedSeq([int(n) if n == int(n) else round(n, 2) for n in pair])
    numbers.fa.set_flow_style()
    return numbers
