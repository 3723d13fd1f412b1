"""A command run in this process, and the lines that it prints, stdout and stderr in the order of printing."""

from __future__ import annotations

import os
from contextlib import contextmanager
from tempfile import TemporaryFile
from typing import TYPE_CHECKING

from click.testing import CliRunner
from so_far import without_so_far

import cli
from geometry.errors import PlogicError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


def told(*args: object, stdin: str | None = None) -> list[str]:
    """The lines of a command; mistakes are told as ``cli.main`` tells them. Any other exception is raised."""
    with standard_input(stdin or ""):
        result = CliRunner().invoke(cli.cli, [str(arg) for arg in args], input=stdin)
    if result.exception is not None and not isinstance(result.exception, PlogicError | SystemExit):
        raise result.exception
    mistakes: Iterable[str] = cli._told(result.exception) if isinstance(result.exception, PlogicError) else ()
    return [*without_so_far(result.output).splitlines(), *(f"plogic: {line}" for line in mistakes)]


@contextmanager
def standard_input(text: str) -> Iterator[None]:
    """This process's standard input, for those who read it by its number."""
    own = os.dup(0)
    with TemporaryFile() as file:
        file.write(text.encode())
        file.seek(0)
        os.dup2(file.fileno(), 0)
    try:
        yield
    finally:
        os.dup2(own, 0)
        os.close(own)
