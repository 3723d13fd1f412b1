"""A detector that some pictures make die or wait: an entry point of a distribution that lies in a folder."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

DIES, WAITS, DIES_ONCE = 1, 2, 3
"""The first pixel's blue of pictures that the detector does this over; others are grey all over."""

DETECTOR = """
import os, signal, time
from pathlib import Path

class Detector:
    name = "hostile"
    types = ("patch",)

    def detect(self, image):
        print("what a library says on stdout")
        kind = image[0, 0, 0]
        once = Path(__file__).with_name("once")
        if kind == 1 or (kind == 3 and not once.exists()):
            once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        while kind == 2:
            time.sleep(1)
        return []
"""


def hostile(folder: Path) -> dict[str, str]:
    """The variables that let ``plogic`` find the detector; it is written into ``folder``."""
    about = folder / "hostile-1.dist-info"
    about.mkdir(parents=True)
    (folder / "hostile_detector.py").write_text(DETECTOR)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: hostile\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[plogic.detectors]\nhostile = hostile_detector:Detector\n")
    return {"PYTHONPATH": os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)}
