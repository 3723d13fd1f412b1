"""Write the generated pages of docs, and what the commands of README.md and the guides print.

The pages are vocabulary.md, commands.md, formats.md, api.md, and architecture.md with its drawing.

``python docs/generate.py`` does all of it; ``--quick`` leaves README and guides alone. A test holds all of them to what
this would write. ``--occlusion BENCH.json`` writes docs/occlusion.md and its composition table alone, from
``plogic bench occlusion --json``, which takes a quarter of an hour.
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click
from api_page import api
from architecture import drawing, page
from formats_page import page as formats

if TYPE_CHECKING:
    from collections.abc import Iterator

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
WIDTH = 100
GUIDES = (ROOT / "README.md", HERE / "asking.md", HERE / "knowledge-bases.md", HERE / "frames.md")
"""The pages whose commands are run, in this order, each in the folder that the ones before it left."""
BLOCK = re.compile(r"(?<=^```console\n).*?(?=^```$)", re.DOTALL | re.MULTILINE)
"""The text in a fence that is called console: commands after ``$ ``, each with what it prints below it."""


def vocabulary() -> str:
    """The text of docs/vocabulary.md."""
    from plogic.facts.vocabulary import table

    return f"""# The vocabulary of queries

Written by `python docs/generate.py` from `plogic/facts/vocabulary.py`, which also makes the program's rules. Do not edit.

Every predicate holds *in a world*: of hypotheses that are not present nothing is true, except `opaque`, `dv` and `rank`.
`H`, `X`, `Y` are hypotheses (`h1`), `F` a feature (`'roof/apex'`, quoted because of the slash), `A` an appearance (`a1`).
A *node* of the part-whole tree is a hypothesis, or `H/P` for a part or a feature of it. Names that begin with a capital are variables.

{table()}

Conjunction is `,`, negation is `\\+`. Rules of your own go into the KB's `rules.pl`,
or into a file for `--rules FILE` (`query`, `worlds`, `explain`, `shell`);
they may choose, observe and constrain too ([Rules of your own](knowledge-bases.md#rules-of-your-own)).
"""


def commands() -> str:
    """The text of docs/commands.md."""
    from cli import cli

    parts = [f"## {' '.join(path)}\n\n```text\n{text}\n```" for path, text in helps(cli, ("plogic",), None)]
    head = "# The commands\n\nWritten by `python docs/generate.py` from the help texts. Do not edit."
    codes = (
        "Exit codes: 0 done (an empty answer is an answer), 1 bad input, or a claim of a benchmark that was not met, 2 bad usage, "
        "3 deadline reached, with the best answer so far."
    )
    return "\n\n".join([head, codes, *parts]) + "\n"


def helps(
    command: click.Command, path: tuple[str, ...], parent: click.Context | None
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Every command with its path and its help text, groups before their members."""
    settings = command.context_settings | {"terminal_width": WIDTH, "max_content_width": WIDTH}
    context = click.Context(command, info_name=path[-1], parent=parent, **settings)
    yield path, command.get_help(context)
    for name, member in sorted(getattr(command, "commands", {}).items()):
        yield from helps(member, (*path, name), context)


def guides(texts: list[str]) -> list[str]:
    """These pages with what their commands print now.

    They run one after the other, in an empty folder that has the examples in it.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "examples").symlink_to(ROOT / "examples")
        return [BLOCK.sub(lambda found: _session(found[0], Path(folder)), text) for text in texts]


def _session(block: str, folder: Path) -> str:
    typed = [line for line in block.splitlines() if line.startswith("$ ")]
    return "\n\n".join(f"{line}\n{_printed(line[2:], folder)}".rstrip() for line in typed) + "\n"


def _printed(command: str, folder: Path) -> str:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    run = subprocess.run(  # noqa: S602 - the README's own commands, as a user types them
        command,
        shell=True,
        cwd=folder,
        env=os.environ | {"PATH": path, "COLUMNS": "110", "NO_COLOR": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode:
        sys.exit(f"{command}: exit {run.returncode}\n{run.stderr}")
    return "\n".join(line.rstrip() for line in run.stdout.strip("\n").splitlines()).rstrip("\n")


def occlusion(bench: Path) -> None:
    """The ``gamma/1`` document: features in a lobe and not behind the box, moved by noise, ordered by place."""
    from benchmarks.occlusion import page as of_occlusion
    from benchmarks.occlusion.bench import MOTIONS
    from benchmarks.occlusion.neighbours import MOVED
    from benchmarks.occlusion.page import LINES_FILE, bounds, lines

    lower, upper = bounds()
    text = of_occlusion.page(json.loads(bench.read_text(encoding="utf-8")), lower, upper, len(MOVED), MOTIONS)
    (HERE / "occlusion.md").write_text(text, encoding="utf-8")
    (HERE / LINES_FILE).write_text(lines(lower, upper), encoding="utf-8")


def main() -> None:
    """Write the files."""
    sys.path.insert(0, str(ROOT))
    if "--occlusion" in sys.argv[1:]:
        occlusion(Path(sys.argv[sys.argv.index("--occlusion") + 1]))
        return
    (HERE / "vocabulary.md").write_text(vocabulary(), encoding="utf-8")
    (HERE / "commands.md").write_text(commands(), encoding="utf-8")
    (HERE / "api.md").write_text(api(), encoding="utf-8")
    (HERE / "formats.md").write_text(formats(), encoding="utf-8")
    (HERE / "architecture.md").write_text(page(), encoding="utf-8")
    (HERE / "architecture.svg").write_text(drawing(), encoding="utf-8")
    if "--quick" not in sys.argv[1:]:
        texts = guides([guide.read_text(encoding="utf-8") for guide in GUIDES])
        for guide, text in zip(GUIDES, texts, strict=True):
            guide.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
