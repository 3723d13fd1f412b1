"""Real photos enlarged or shrunk: what is found in them, at sizes other than those that types were learned from.

``python benchmarks/enlarged.py KB DATASET FACTOR``: the types of KB are those of DATASET, real photos in BOP's layout,
by number or by name. Each photo is made FACTOR times as large, with its camera, and perceived without support. Nothing
new is seen in an enlarged one: what a camera with more pixels sees of the same thing is at least that.
"""

from pathlib import Path

import cv2
import numpy as np

from benchmarks.photos.answers import Looker, Shown, photos_of
from benchmarks.photos.knowledge import numbers_of, resting
from benchmarks.photos.score import Counts
from benchmarks.photos.table import measure_of
from benchmarks.shared.arguments import of_kb_and_dataset
from plogic.run.bop.dataset import open_dataset
from plogic.run.sources import kb_of


def enlarged(shown: Shown, factor: float) -> Shown:
    """The photo ``factor`` times as large."""
    size = round(shown.camera.width * factor), round(shown.camera.height * factor)
    how = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    image = np.asarray(cv2.resize(shown.image, size, interpolation=how), np.uint8)
    return shown._replace(image=image, camera=shown.camera.resized(*size))


def main(kb_folder: str, dataset: Path, factor: float) -> None:
    """Print a line a photo, and the sums."""
    kb = kb_of(kb_folder)
    numbers = numbers_of(kb, dataset / "models")
    measure, looker = measure_of(kb, numbers, dataset / "models"), Looker(resting(kb, maybe=False), numbers)
    total = Counts()
    for photo in photos_of(open_dataset(dataset)):
        shown = enlarged(photo, factor)
        document, _, seconds = looker.looked(shown)
        one, _ = measure.counted(shown, list(looker.accepted(document).values()))
        total += one
        print(f"{shown.name}: {_told(one)}; {seconds:.1f} s", flush=True)  # noqa: T201 - a script
    print(f"all: {_told(total)}")  # noqa: T201


def _told(counts: Counts) -> str:
    of = f"of {counts.there} {counts.found} found, {counts.right} right"
    return f"{of}; {counts.accepted} accepted, {counts.false} of types that are not there"


if __name__ == "__main__":
    parser = of_kb_and_dataset(__doc__)
    parser.add_argument("factor", type=float, metavar="FACTOR")
    asked = parser.parse_args()
    main(asked.kb, asked.dataset, asked.factor)
