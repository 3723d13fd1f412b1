"""JSON files that strangers wrote: the document, or what is wrong with the file in one line, whatever it holds."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path


class JsonError(Exception):
    """What is wrong with a JSON file, after its name, and the line and column where they are known."""


def json_of(path: Path, most: int, holds: str) -> Any:  # noqa: ANN401 - parsed JSON
    """The document of a file, or of a pipe, of at most ``most`` bytes; ``holds`` says what should be in it where it is nested too deeply.

    Raises:
        JsonError: The file cannot be read, or is no JSON.
    """
    try:
        if path.stat().st_size > most:
            raise JsonError(f"{path}: is larger than the {most} bytes that are read")
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except json.JSONDecodeError as error:
        raise JsonError(f"{path}:{error.lineno}:{error.colno}: is no JSON: {error.msg}") from None
    except UnicodeDecodeError as error:
        raise JsonError(f"{path}: is no JSON: byte {error.start} is no UTF-8") from None
    except RecursionError:
        raise JsonError(f"{path}: is nested too deeply: {holds}") from None
    except ValueError:  # json's own is above
        raise JsonError(f"{path}: holds a whole number of more digits than can be read") from None
    except OSError as error:
        raise JsonError(f"{path}: cannot be read: {error.strerror}") from None
