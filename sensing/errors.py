"""What can go wrong with the data.

::

    PlogicError (geometry.errors)
    └── SensingError
        ├── GammaError      a gamma.json with mistakes, one line each
        ├── ImageError      a file that is no whole image of 8 or 16 bits, or an image of another size than its camera's
        ├── DetectorError   no such detector, a name taken twice, a plug-in that does not load, fails, or reports what
            cannot be
        └── SceneError      a simulated scene that cannot be: no camera pose, a body without triangles, no room

Messages state the place, the rule and the value. Only the command line turns one into an exit code.
"""

from collections.abc import Sequence

from geometry.errors import PlogicError, told


class SensingError(PlogicError):
    """Anything that is wrong with the data or with the simulated camera."""


class GammaError(SensingError):
    """A Γ with mistakes.

    ``mistakes`` holds every one as a line ``gamma.json: appearances.3.uv: ...``, and ``str()`` tells the first 100.
    """

    def __init__(self, mistakes: Sequence[str]) -> None:
        super().__init__(told(mistakes))
        self.mistakes = tuple(mistakes)


class ImageError(SensingError):
    """An image that cannot be read, is damaged, has floating-point pixels, or does not fit its camera."""


class DetectorError(SensingError):
    """A detector that is unknown, registered twice, cannot be loaded, fails, or reports what cannot be."""


class SceneError(SensingError):
    """A simulated scene that cannot be made as asked."""
