"""What ``settle`` answers: worlds let go, a row an object, as a table and as ``settled/1``."""

from dataclasses import dataclass

import numpy as np

from plogic.face.session.blocks import Block, Column, Lines, Note, Rows, Table
from plogic.face.shown.figures import chance
from plogic.run import settling

COLUMNS = (
    Column("object"),
    Column("verdict"),
    *(
        Column(name, right=True)
        for name in ("moved, m", "seated, m, deg", "pushed, m", "fell, m", "slid, m", "tilted, deg", "allowed, m")
    ),
)
LEGEND = (
    "moved    how far its middle of mass is from where it was",
    "seated   of that, how far it was first put on what it is said to stand on, and by how much it was turned for it",
    "pushed   how far it was moved out of others and the floor then, before it was let go",
    "fell     how much lower its lowest place is, pushing aside; slid: how far its middle went level; tilted: how much",
    "allowed  5 mm + 2 % of its distance from the camera: who is moved by less, sinks by less than 60 % of it, and tilts",
    "         by less than 15 degrees, stands",
)


@dataclass(frozen=True)
class SettledObject:
    """What became of one object of a world, ``world`` being its rank from 1; metres and radians."""

    world: int
    id: str
    type: str
    verdict: settling.Verdict
    moved: float
    seated: float
    turned: float
    pushed: float
    fell: float
    slid: float
    tilted: float
    allowed: float
    still: bool


@dataclass(frozen=True, repr=False)
class Settled(Rows[SettledObject]):
    """Worlds let go; ``document``: ``settled/1``, which has the poses, too."""

    document: settling.Settled

    @property
    def rows(self) -> tuple[SettledObject, ...]:
        """The objects of all worlds."""
        worlds = enumerate(self.document["worlds"], 1)
        return tuple(_row(i, row) for i, world in worlds for row in world["objects"])

    def blocks(self) -> tuple[Block, ...]:
        """A table a world."""
        worlds = self.document["worlds"]
        if not worlds:
            return (Note("the interpretation lists no world"),)
        tables = (block for i, world in enumerate(worlds, 1) for block in _blocks(i, world))
        return *tables, Lines("columns", LEGEND)


def _row(rank: int, row: settling.ObjectRow) -> SettledObject:
    return SettledObject(rank, **{key: value for key, value in row.items() if key != "T_camera_object"})  # type: ignore[arg-type] # the keys of a row


def _blocks(rank: int, world: settling.SettledWorld) -> tuple[Block, ...]:
    title = f"world {rank}, probability {chance(world['probability'])}; floor: {world['floor']['told_by']}"
    table = Table(title, COLUMNS, tuple(_cells(row) for row in world["objects"]))
    return table, *(Note(f"{row['id']} is left out: {row['why']}") for row in world["left_out"])


def _cells(row: settling.ObjectRow) -> tuple[str, ...]:
    seated = f"{row['seated']:.3f}, {np.degrees(row['turned']):.1f}" if row["seated"] or row["turned"] else ""
    metres = (f"{row['moved']:.3f}", seated, f"{row['pushed']:.3f}", f"{row['fell']:.3f}", f"{row['slid']:.3f}")
    verdict = row["verdict"] if row["still"] else f"{row['verdict']}, still moving"
    return f"{row['type']} {row['id']}", verdict, *metres, f"{np.degrees(row['tilted']):.1f}", f"{row['allowed']:.3f}"
