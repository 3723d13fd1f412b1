"""What a picture lacks: light that is neither too little nor too much, and the colours that types were learned in.

* ``lacking(document, learned=True)``: a sentence each, by the picture that an interpretation holds
"""

import base64
from collections.abc import Iterator

import cv2
import numpy as np

from plogic.facts.document import Interpretation
from sensing.detectors.keypoints import grey_of

DULL = 3
"""Levels by which the channels of a picture without colours may differ, for the document may hold it as JPEG."""
DARK = 50
"""Levels that a hundredth of a picture's pixels must reach. Two of the ``ycb`` photos of shared/data in ever less
light, three types: of three objects none was lost at 76, one at 38, two at 20."""
BURNT, SHARE = 250, 0.5
"""Levels from which a pixel is burnt out, and the share of a picture's pixels that may be: with 0.3 of them, in the
same photos in three times the light, nothing was lost."""


def lacking(document: Interpretation, *, learned: bool) -> Iterator[str]:
    """What of the picture keeps types from being found, ``learned`` or by hand; nothing where there is none."""
    row = document["assets"].get("image")
    if row is None:
        return
    image = cv2.imdecode(np.frombuffer(base64.b64decode(row["base64"]), np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        return
    if learned and np.ptp(image.astype(np.int16), axis=2).max() <= DULL:
        yield (
            "the picture has no colours, and types were learned in colour: their print is compared by brightness, but "
            "what has little print is hardly ever found so; give a picture in colour"
        )
    grey = grey_of(np.asarray(image, np.uint8))
    most = float(np.quantile(grey, 0.99))
    if most < DARK:
        yield (
            f"the picture is dark: 99 of 100 pixels are at most {most:.0f} of 255"
            f"{', and types were learned in light' if learned else ''}; give it more light, or a longer exposure"
        )
    burnt = float((grey >= BURNT).mean())
    if burnt > SHARE:
        yield (
            f"the picture is over-exposed: {burnt:.0%} of its pixels are burnt out, so nothing is detected there; "
            "give it a shorter exposure"
        )
