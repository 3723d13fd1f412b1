"""Mutants: small mistakes put into the code, one at a time, and which tests find them.

    python tests/helpers/mutants.py --seed 38 --count 40 -o mutants.jsonl

Draws places by the seed from all packages but the commands, and runs for each mutant, in a copy of the repository, the
tests that name its module, then those of its room, of its floor, and the rest, until one fails or a group takes more of
a processor than it may. What is done stands in the file given, a line a mutant, and is not done again. At the end: a
table, and of each survivor its diff.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = "geometry", "kb", "sensing", "plogic"
LEFT_OUT = "plogic/face/commands/", "plogic/face/authoring/kb_group.py"
COPIED = "*.py", "*.pl", "*.toml", "*.md"
COMPARED = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
COUNTED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
JOINED = {ast.And: ast.Or, ast.Or: ast.And}


class Mutant(NamedTuple):
    """One mistake: in ``file``, the bytes ``start:end`` become ``text``."""

    file: str
    line: int
    kind: str
    start: int
    end: int
    text: str

    def applied(self, source: bytes) -> bytes:
        """Return the source with the mistake in it."""
        return source[: self.start] + self.text.encode() + source[self.end :]


def changed(node):
    """What may stand in a node's place: (kind, text)."""
    match node:
        case ast.Compare(ops=[op]) if type(op) in COMPARED:
            yield "comparison", ast.unparse(ast.Compare(node.left, [COMPARED[type(op)]()], node.comparators))
        case ast.BinOp(op=op) if type(op) in COUNTED:
            yield "arithmetic", f"({ast.unparse(ast.BinOp(node.left, COUNTED[type(op)](), node.right))})"
        case ast.BoolOp(op=op):
            yield "and, or", f"({ast.unparse(ast.BoolOp(JOINED[type(op)](), node.values))})"
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield "negation", f"({ast.unparse(operand)})"
        case ast.Constant(value=bool() as value):
            yield "constant", str(not value)
        case ast.Constant(value=int() as value):
            yield "constant", str(value + 1)
        case ast.Constant(value=float() as value):
            yield "constant", repr(value * 2 if value else 1.0)
        case ast.Return(value=ast.expr() as value) if not _is_none(value):
            yield "return", "return None"
        case ast.Expr(value=ast.Call()) | ast.Assign() | ast.AugAssign():
            yield "removed", "pass"


def _is_none(node):
    return isinstance(node, ast.Constant) and node.value is None


def nodes(tree):
    """The nodes that run; what is for the type checker, and what a decorator is given, is left alone."""
    for field, value in ast.iter_fields(tree):
        if field in {"annotation", "returns", "decorator_list", "type_params", "bases", "keywords"} and isinstance(
            tree, ast.arg | ast.AnnAssign | ast.FunctionDef | ast.ClassDef
        ):
            continue
        for node in value if isinstance(value, list) else [value]:
            if not isinstance(node, ast.AST):
                continue
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                continue
            if isinstance(node, ast.expr | ast.stmt):
                yield node
            yield from nodes(node)


def mutants_of(source: bytes, file: str):
    """All mutants of a file, in the order of their places."""
    starts = [0]
    for line in source.split(b"\n"):
        starts.append(starts[-1] + len(line) + 1)
    for node in nodes(ast.parse(source)):
        for kind, text in changed(node):
            start = starts[node.lineno - 1] + node.col_offset
            yield Mutant(file, node.lineno, kind, start, starts[node.end_lineno - 1] + node.end_col_offset, text)


def drawn(root: Path, seed: int, count: int):
    """As many mutants as asked for, the same for the same code and seed, no two in one place."""
    files = sorted(path for package in PACKAGES for path in (root / package).rglob("*.py"))
    names = [str(path.relative_to(root)) for path in files]
    every = [
        mutant
        for name in names
        if not name.startswith(LEFT_OUT)
        for mutant in mutants_of((root / name).read_bytes(), name)
    ]
    return random.Random(seed).sample(every, count)  # noqa: S311 - nothing secret


def stages(root: Path, file: str):
    """Lists of files of tests, the likeliest to find a mistake in ``file`` first, no test twice."""
    module = file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    room = Path(file).parent
    place = root / "tests" / (room.relative_to("plogic") if room.is_relative_to("plogic") else room)
    every = sorted((root / "tests").rglob("test_*.py"))
    about = [
        lambda path: f"{module} " in path.read_text(encoding="utf-8"),
        lambda path: path.is_relative_to(place),
        lambda path: path.is_relative_to(root / "tests" / place.relative_to(root / "tests").parts[0]),
        lambda path: "laws" in path.parts or "cycle" in path.parts,
        lambda _: True,
    ]
    for condition in about:
        chosen = sorted(filter(condition, every), key=lambda path: -len(os.path.commonpath([path, place])))
        every = [path for path in every if path not in chosen]
        yield chosen


def found_by(root: Path, mutant: Mutant, most_stages: int, seconds: int):
    """What finds the mutant: the first test that fails, or the stage whose time was over; None where it survives."""
    source = (root / mutant.file).read_bytes()
    (root / mutant.file).write_bytes(mutant.applied(source))
    try:
        for number, chosen in enumerate(list(stages(root, mutant.file))[:most_stages], 1):
            failed = first_failure(root, chosen, seconds) if chosen else None
            if failed is not None:
                return f"{failed} (stage {number})"
        return None
    finally:
        (root / mutant.file).write_bytes(source)


def first_failure(root: Path, files, seconds: int):
    """The name of the first test that fails, of those in the files; None where all pass."""
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "--tb=no", "-p", "no:cacheprovider", "-p", "no:xdist"]
    environment = os.environ | {"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}

    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))

    options = {"cwd": root, "env": environment, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    run = subprocess.run([*command, *map(str, files)], check=False, preexec_fn=limit, start_new_session=True, **options)
    if run.returncode < 0:
        return "takes too long"
    if run.returncode == 0:
        return None
    marked = [line for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return (marked or run.stdout.splitlines() or ["no word"])[-1].split(" - ")[0]


def diff(root: Path, mutant: Mutant):
    source = (root / mutant.file).read_bytes()
    one, other = (text.decode().splitlines() for text in (source, mutant.applied(source)))
    return "\n".join(difflib.unified_diff(one, other, mutant.file, mutant.file, lineterm="", n=1))


def copy_of(folder: Path):
    """The repository's files as they are here, in a folder of their own."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in listed.splitlines():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    subprocess.run(["git", "init", "-q"], cwd=folder, check=True)
    return folder


def table(rows):
    """What became of each, and the diffs of those that live."""
    lines = [
        f"{number:>3}  {row['kind']:<11} {row['place']:<62} {row['found'] or 'SURVIVED'}"
        for number, row in enumerate(rows, 1)
    ]
    killed = sum(row["found"] is not None for row in rows)
    lines.append(f"\n{killed} of {len(rows)} killed ({killed / max(len(rows), 1):.0%})")
    return "\n".join([*lines, *(f"\n{row['diff']}" for row in rows if row["found"] is None)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--stages", type=int, default=5, help="how many of the five groups of tests are run")
    parser.add_argument("--seconds", type=int, default=1800, help="of a processor that one group may take")
    parser.add_argument("-o", "--out", type=Path, default=Path("mutants.jsonl"))
    asked = parser.parse_args()
    done = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.exists() else []
    with TemporaryDirectory(prefix="mutants-") as scratch:
        root = copy_of(Path(scratch))
        for mutant in drawn(root, asked.seed, asked.count)[len(done) :]:
            begun = time.monotonic()
            row = {"place": f"{mutant.file}:{mutant.line}", "kind": mutant.kind, "diff": diff(root, mutant)}
            row |= {"found": found_by(root, mutant, asked.stages, asked.seconds)}
            done.append(row | {"seconds": round(time.monotonic() - begun)})
            with asked.out.open("a") as out:
                out.write(json.dumps(done[-1]) + "\n")
    sys.stdout.write(table(done) + "\n")


if __name__ == "__main__":
    main()
