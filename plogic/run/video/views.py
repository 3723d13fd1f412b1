"""The frames of inputs that are views of one world: files, and every n-th frame of each video among them.

* ``views_in(["clip.mp4", "last.png"], every=30)``
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from plogic.base.errors import InputError
from plogic.run.cameras import GivenCamera, Shot, shot_of
from plogic.run.video.video import counted, frame_name, is_video, shot_at

MOST_VIEWS = 1000
"""Frames of one video that are taken as views of one world."""


class Input(NamedTuple):
    """One frame: a file, or the ``number``-th of a ``video``, called ``clip_000012``.

    ``fault``: what is wrong with the rest of the video, of what stands for that.
    """

    name: str
    video: str | None = None
    number: int = 0
    fault: str | None = None

    def shot(self, given: GivenCamera) -> Shot:
        """The picture with its camera. Raises InputError, ImageError or CameraError."""
        if self.fault is not None:
            raise InputError(self.fault)
        if self.video is None:
            return shot_of(self.name, given)
        return shot_at(self.video, (), self.number, given)


def views_in(inputs: Sequence[str], every: int) -> list[Input]:
    """Every frame in the order of the inputs.

    Raises InputError where a video has no frames, or more than can be taken together.
    """
    return [view for name in inputs for view in (_of_video(name, every) if is_video(name) else [Input(name)])]


def _of_video(name: str, every: int) -> list[Input]:
    frames, fault = counted(name)
    if fault is not None and not frames:
        raise InputError(fault)
    numbers = range(0, frames, every)
    if len(numbers) > MOST_VIEWS:
        what = f"has {frames} frames, and at most {MOST_VIEWS} are taken as views of one world"
        raise InputError(f"{name}: {what}: give --every {-(-frames // MOST_VIEWS)}")
    views = [Input(frame_name(Path(name), number), name, number) for number in numbers]
    return views + [Input(name, name, frames, fault)] * (fault is not None)
