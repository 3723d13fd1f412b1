"""The YAML of a calibration: plain data and OpenCV's matrices, no other tag, no duplicate key, no YAML bomb."""

from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import MaxDepthExceededError
from ruamel.yaml.constructor import SafeConstructor
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from geometry.digits import TOO_LONG, start_of_too_long
from geometry.errors import CameraError

MAX_DEPTH = 20
"""Levels of nesting: a calibration has four."""


class _Constructor(SafeConstructor):
    """Plain YAML, and `!!opencv-matrix` as the mapping that it is."""

    def opencv_matrix(self, node: Any) -> dict[Any, Any]:  # noqa: ANN401 - ruamel's nodes have no common type
        return dict(self.construct_mapping(node, deep=True))


_Constructor.add_constructor("tag:yaml.org,2002:opencv-matrix", _Constructor.opencv_matrix)


def read_yaml(text: str, longest: int) -> object:
    """The data in `text`, of at most so many characters: mappings, lists, texts, numbers.

    Raises:
        CameraError: with the line where it can, for anything else.
    """
    if len(text) > longest:
        raise CameraError(f"must be a calibration of at most {longest} characters, not {len(text)}")
    loader = YAML(typ="safe", pure=True)
    loader.Constructor, loader.max_depth = _Constructor, MAX_DEPTH
    try:
        return loader.load(_without_directive(text))
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        deep = isinstance(error, MaxDepthExceededError)
        why = (
            f"nested deeper than {MAX_DEPTH} levels" if deep else " ".join(str(error.problem or error.context).split())
        )
        raise CameraError(f"is not plain YAML: {why}", line=None if mark is None else mark.line + 1) from error
    except (YAMLError, ValueError, RecursionError, TypeError, AssertionError) as error:  # the last of a %YAML 1.23
        start = start_of_too_long(text, "#.*")
        if start is not None:
            raise CameraError(TOO_LONG, line=text.count("\n", 0, start) + 1) from None
        why = " ".join(str(error).split())[:120]
        raise CameraError(f"is not plain YAML: {why}") from error


def _without_directive(text: str) -> str:
    """`text` with OpenCV's `%YAML:1.0`, which is no YAML, made a comment: lines keep their numbers."""
    return f"#{text}" if text.startswith("%YAML:") else text
