"""A command run in this process, and the lines that it prints, stdout and stderr in the order of printing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from click.testing import CliRunner

import cli
from geometry.errors import PlogicError

if TYPE_CHECKING:
    from collections.abc import Iterable


def told(*args: object, stdin: str | None = None) -> list[str]:
    """The lines of a command; mistakes are told as ``cli.main`` tells them. Any other exception is raised."""
    result = CliRunner().invoke(cli.cli, [str(arg) for arg in args], input=stdin)
    if result.exception is not None and not isinstance(result.exception, PlogicError | SystemExit):
        raise result.exception
    mistakes: Iterable[str] = cli._told(result.exception) if isinstance(result.exception, PlogicError) else ()
    return [*result.output.splitlines(), *(f"plogic: {line}" for line in mistakes)]
