"""Users' names and programs' atoms, the table between them (contract, "Names"), and the tokens of a typed goal.

A name whose every segment matches ``[a-z][a-z0-9_]*`` is its own atom, in quotes where it has several segments or is an
operator; any other gets a generated one. Atoms stand only in argument places, so no name can be read as program text.

Vocabulary: a *label* is the user's word, ``"roof/apex"`` or ``"Grand Hall"``; an *atom* is the program's,
``"'roof/apex'"`` or ``"n1"``.

``tokens("present( 'h1' ).")`` → ``("present", "(", "h1", ")")`` serves to complete a goal, to compare two of them and
to put one on one line. It is no parser: the meaning of a goal is for ProbLog's parser to say.
"""

import re
from dataclasses import dataclass

SIMPLE = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
PLAIN = re.compile(r"[a-z][a-z0-9_]*(?:/[a-z][a-z0-9_]*)*", re.ASCII)
OPERATORS = frozenset(
    {"is", "mod", "rem", "div", "rdiv", "not", "xor", "as", "rule", "dynamic", "discontiguous", "initialization"}
)
"""Words that ProbLog's parser reads, or could read, as something else than a constant."""

SPELLINGS = {("atom", 1): "atom_node"}
"""Predicates that ProbLog already has: what a user writes → what programs say; mapped on the syntax tree."""


@dataclass(frozen=True)
class Names:
    """The two directions of one table; built once, then only read."""

    atoms: dict[str, str]
    labels: dict[str, str]

    @classmethod
    def of(cls, atoms: dict[str, str]) -> "Names":
        """The table of these atoms by their labels."""
        return cls(atoms, {atom: label for label, atom in atoms.items()})

    def atom(self, label: str) -> str:
        """The atom of a label; a label that the table does not know is a mistake of ours (KeyError)."""
        return self.atoms[label]

    def generated(self) -> list[tuple[str, str]]:
        """(atom, label) of every name that is not its own atom, in the order of the table."""
        return [(atom, label) for label, atom in self.atoms.items() if not is_plain(label)]


def own_atom(label: str) -> bool:
    """Whether the label is its own atom without quotes."""
    return SIMPLE.fullmatch(label) is not None and label not in OPERATORS


def is_plain(label: str) -> bool:
    """Whether the label is its own atom, in quotes or without: ``quoted`` gives it."""
    return PLAIN.fullmatch(label) is not None


_TOKEN = re.compile(
    r"""(?P<gap>\s+|%[^\n]*|/\*.*?\*/)
      | (?P<quoted>'(?:\\.|''|[^'\\])*' | "(?:\\.|""|[^"\\])*")
      | (?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)
      | (?P<word>\w+)
      | (?P<mark>\\\+|=\\=|\\==|\\=|:-|=<|>=|=:=|=\.\.|-->|->|::|.)""",
    re.VERBOSE | re.DOTALL,
)


def tokens(goal: str) -> tuple[str, ...]:
    """The tokens without white space, comments and a last full stop; a quoted name that needs no quotes loses them."""
    found = [_unquoted(match.group()) for match in _TOKEN.finditer(goal) if match.lastgroup != "gap"]
    return tuple(found[:-1] if found and found[-1] == "." else found)


def one_line(goal: str) -> str:
    """The goal as it was typed, each gap outside quotes a single space, without comments and a last full stop."""
    pieces: list[str] = []
    for match in _TOKEN.finditer(goal):
        piece = " " if match.lastgroup == "gap" else match.group()
        if piece != " " or (pieces and pieces[-1] != " "):
            pieces.append(piece)
    while pieces and pieces[-1] == " ":
        pieces.pop()
    return "".join(pieces[:-1] if pieces and pieces[-1] == "." else pieces).rstrip(" ")


def is_ground(goal: str) -> bool:
    """Whether the goal has no variable, not even ``_``."""
    return not any(token[0].isupper() or token[0] == "_" for token in tokens(goal))


def quoted(label: str) -> str:
    """A name as a goal writes it: ``h1``, ``'roof/apex'``."""
    return label if own_atom(label) else "'" + label.replace("\\", "\\\\").replace("'", "\\'") + "'"


def _unquoted(token: str) -> str:
    inner = token[1:-1]
    return inner if token[0] in "'\"" and own_atom(inner) else token
