"""``plogic settle``: the best worlds let go by physics, as a table, as ``settled/1``, and as a picture."""

import json
from pathlib import Path

from plogic.base.errors import InputError
from plogic.face.python.interpretation import Interpretation
from plogic.run.settling import SettledWorld
from sensing.files.whole_files import check_places, write_whole


def settle_command(source: str, worlds: int, picture: Path | None, *, drop: bool, as_json: bool) -> str:
    """The tables, or the document; the ``picture`` is of the best world.

    Raises:
        InputError: there is no physics, nobody knows which way is up, or nothing to draw.
        InterpretationError: it is no interpretation.
    """
    if picture is not None:
        check_places([picture], [source])
    asked = Interpretation.load(source)
    found = asked.settle(worlds, drop=drop)
    if picture is not None:
        if not found.document["worlds"]:
            raise InputError("--picture: the interpretation lists no world")
        write_whole(picture, _png(asked, found.document["worlds"][0]))
    return json.dumps(found.document) if as_json else str(found)


def _png(asked: Interpretation, world: SettledWorld) -> bytes:
    import cv2

    from plogic.face.shown.settled import settled_picture

    return bytes(cv2.imencode(".png", settled_picture(asked.document, world, asked.image))[1].tobytes())
