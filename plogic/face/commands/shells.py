"""``plogic completion`` and ``plogic man``: what a shell asks for the next word, and the manual as one roff page.

Both are made of the commands themselves, so that they hold what the commands do.
"""

from collections.abc import Iterator

import click

from plogic.base.errors import InputError

WHERE = {
    "bash": "plogic completion bash > ~/.local/share/bash-completion/completions/plogic",
    "zsh": "plogic completion zsh > ~/.zfunc/_plogic, with fpath+=~/.zfunc before compinit in ~/.zshrc",
    "fish": "plogic completion fish > ~/.config/fish/completions/plogic.fish",
}
"""Where each shell looks for it."""
NAME = "plogic"


def completion_text(shell: str) -> str:
    """The script that a shell reads; its first comment says where to put it. Raises InputError for an unknown shell."""
    from click.shell_completion import get_completion_class

    maker = get_completion_class(shell)
    if maker is None or shell not in WHERE:
        raise InputError(f"{shell}: no such shell; there are: {', '.join(WHERE)}")
    script = maker(click.Group(NAME), {}, NAME, "_PLOGIC_COMPLETE")
    body = maker.source_template % script.source_vars()
    lines = body.strip().splitlines()
    place = 1 if lines[0].startswith("#compdef") else 0
    return "\n".join([*lines[:place], f"# {WHERE[shell]}", *lines[place:]]) + "\n"


def man_text(root: click.Group, version: str) -> str:
    """The manual page of a group and its commands, roff for ``man -l FILE``."""
    lines = [
        f'.TH PLOGIC 1 "" "plogic {version}" "User Commands"',
        ".SH NAME",
        f"plogic \\- {_roff(_first(root))}",
        ".SH SYNOPSIS",
        ".B plogic",
        "COMMAND [OPTIONS] ARGUMENTS",
        ".SH DESCRIPTION",
        *_paragraphs(root.help or ""),
        ".SH COMMANDS",
    ]
    for path, command, parameters in _commands(root, NAME):
        lines += [f".SS {_roff(path)}", *_paragraphs(command.help or "")]
        for names, text in parameters:  # an argument has no help
            lines += [".TP", f".B {_roff(names)}", _roff(text)]
    lines += [
        ".SH EXIT STATUS",
        "0 done (an empty answer is an answer), 1 bad input, 2 bad usage, 3 deadline reached, with the best answer so far.",
        ".SH ENVIRONMENT",
        ".TP",
        ".B NO_COLOR",
        "No colours.",
        ".TP",
        ".B XDG_CACHE_HOME",
        "Where learned types and indices are kept.",
    ]
    return "\n".join(lines) + "\n"


def _commands(group: click.Group, path: str) -> Iterator[tuple[str, click.Command, list[tuple[str, str]]]]:
    """Every command below a group, with the names and help of its parameters."""
    for name, command in sorted(group.commands.items()):
        if isinstance(command, click.Group):
            yield from _commands(command, f"{path} {name}")
            continue
        context = click.Context(command, info_name=name)
        rows = [row for p in command.get_params(context) if (row := p.get_help_record(context)) is not None]
        usage = " ".join(command.collect_usage_pieces(context))
        yield f"{path} {name} {usage}".strip(), command, rows


def _first(command: click.Command) -> str:
    return (command.help or "").strip().splitlines()[0].rstrip(".")


def _paragraphs(text: str) -> Iterator[str]:
    for number, paragraph in enumerate(text.strip().split("\n\n")):
        if number:
            yield ".PP"
        yield _roff(" ".join(paragraph.replace("\b", "").split()))


def _roff(text: str) -> str:
    """A text whose signs roff would take for its own are told apart."""
    plain = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{plain}" if plain.startswith((".", "'")) else plain
