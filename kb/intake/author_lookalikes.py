"""Write the KB of look-alikes: ``python -m kb.intake.author_lookalikes FOLDER``; the same bytes each time.

Two towers of one shape: the ``open_tower`` has windows on all sides, of the ``blind_tower`` the north wall has none.
From the south nothing tells which of them stands there. The ``pyramid_tower`` looks like neither. ``plogic demo
--look-again`` looks at them.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from kb.intake.author_towers import KB_YAML, Tower, t1, t2, write_towers

BLIND = "north"
"""The wall without windows."""
YAML = KB_YAML.replace("name: towers", "name: lookalikes").replace(
    "{t1: 0.5, t2: 0.5}", "{open_tower: 0.5, blind_tower: 0.5, pyramid_tower: 0.5}"
)


def look_alikes() -> tuple[Tower, ...]:
    """The three."""
    whole = replace(t1(), name="open_tower")
    walls = tuple(replace(panel, windows=()) if panel.name == BLIND else panel for panel in whole.panels)
    return whole, replace(whole, name="blind_tower", panels=walls), replace(t2(), name="pyramid_tower")


def author(folder: Path) -> None:
    """Write the KB's files into ``folder``, over those that are there."""
    write_towers(folder, YAML, look_alikes())


if __name__ == "__main__":
    author(Path(sys.argv[1] if len(sys.argv) > 1 else "kb/lookalikes"))
