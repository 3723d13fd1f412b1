"""A folder with folders in it, written file by file, whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from sensing.errors import SensingError
from sensing.whole_files import check_new_folder

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """A folder to write into that becomes ``folder`` at the end, and is removed where anything goes wrong.

    Raises:
        SensingError: ``folder`` exists and is not empty, or cannot be written.
    """
    check_new_folder(folder)
    made: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}."))
        yield made
        made.chmod(0o755)
        made.replace(folder)
        made = None
    except OSError as error:
        raise SensingError(f"{folder}: cannot be written: {error.strerror}") from None
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)
