"""Commands that write, killed at each of their operations on files: what is read afterwards is the old or the new.

``python -m benchmarks.fuzz.crashes`` tries every command of ``commands()`` at each operation; ``--most 6``: at so many,
evenly chosen. A command runs once, in a copy (fork) of a process that has imported everything, and before each of its
operations what lies in its folder is copied: what a kill would leave, as the kernel has it. Of a write, half is done in
the copy. Each copy that is like no other, but for what is in files and folders that are only begun, is then looked at,
and the command is run again there. One kill of each command, at an operation drawn by its name, is a kill in earnest,
which must leave what was copied.

* ``states``: how many copies were like no other, so far
* ``old``, ``new``: kills after which everything that the command writes was as before, or as without a kill
* ``torn``: kills after which it was neither: a knowledge base is what ``read_kb`` makes of it, a file its bytes
* ``left``: kills after which the same command, run again, did not end with the files of a run without a kill
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import pkgutil
import signal
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from random import Random
from time import monotonic
from typing import Any, NoReturn

from benchmarks.fuzz.crash_commands import ROOT, Command, Kind, commands, prepare
from benchmarks.fuzz.crash_hook import FILE, Held, Hook, alike, held, kept, laid
from plogic.face.shown.tables import plain_table


def copied(work: Callable[[], object], said: Path | None = None) -> int:
    """The exit status of a copy of this process that did some work; its streams go to a file, or nowhere."""
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    status = 70
    try:
        out = os.open(said or os.devnull, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(out, 1)
        os.dup2(out, 2)
        work()
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:  # noqa: BLE001 - the process ends here
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def run(command: Sequence[str], folder: Path, stdin: str | None = None, hook: Hook | None = None) -> None:
    """Be the console script in a folder."""
    from cli import main

    os.chdir(folder)
    os.dup2(os.open(stdin or os.devnull, os.O_RDONLY), 0)
    sys.argv = ["plogic", *command]
    if hook is not None:
        hook.install()
    main()


def asked(question: Callable[[], object]) -> Any:  # noqa: ANN401 - whatever JSON holds
    """The answer of a copy of this process, which alone remembers what it read."""
    with tempfile.TemporaryFile() as answer:

        def answered() -> None:
            answer.write(json.dumps(question()).encode())
            answer.flush()

        if copied(answered):
            raise RuntimeError("what was written cannot be looked at")
        answer.seek(0)
        return json.loads(answer.read())


def state(command: Command, folder: Path) -> dict[str, str]:
    """What can be read of what a command writes in ``folder``, by name; "absent" where nothing is."""
    places = {name: folder / name for name in command.outputs}
    if command.kind is Kind.KB:
        return {name: _read(place) for name, place in places.items()}
    if command.kind is Kind.FOLDER:
        return {name: _digest(_files(place)) for name, place in places.items()}
    files = {f"{name}{path.relative_to(place)}": path for name, place in places.items() for path in _files(place)}
    return dict.fromkeys(command.outputs, "absent") | {name: _digest([path]) for name, path in files.items()}


def _files(place: Path) -> list[Path]:
    """The file, or all below a folder but those that plogic has only begun."""
    every = [place] if place.is_file() else sorted(path for path in place.rglob("*") if path.is_file())
    return [path for path in every if not any(part.startswith(".") for part in path.relative_to(place).parts)]


def _digest(files: Sequence[Path]) -> str:
    total = sha256()
    for path in files:
        total.update(f"{path.name}\n".encode() + sha256(path.read_bytes()).digest())
    return total.hexdigest() if files else "absent"


def _read(folder: Path) -> str:
    """The digest of a knowledge base as it is read; the mistakes where it cannot be."""
    from kb.errors import KBErrors
    from kb.files.read import read_kb

    try:
        return read_kb(folder).digest
    except KBErrors as error:
        return f"mistakes: {error}" if _files(folder) else "absent"


@dataclass(frozen=True)
class Tried:
    """A command's operations, a line each, and what each kill before one of them left.

    ``states``: how many of the kills leave what no other leaves.
    """

    command: Command
    operations: list[str]
    found: dict[int, str]
    left: dict[int, list[str]]
    states: int
    seconds: float

    def row(self) -> dict[str, Any]:
        """For the table."""
        counts = {what: sum(found == what for found in self.found.values()) for what in ("old", "new", "torn")}
        kills = {"command": self.command.name, "operations": len(self.operations), "kills": sum(counts.values())}
        return kills | {"states": self.states} | counts | {"left": len(self.left), "s": round(self.seconds, 1)}

    def lines(self) -> Iterator[str]:
        """Where it was torn, and what was left."""
        for number in sorted(number for number, found in self.found.items() if found == "torn" or number in self.left):
            what = self.found[number] + (f", left: {' '.join(self.left[number][:4])}" if number in self.left else "")
            yield f"{self.command.name}: killed before {number}, {self.operations[number - 1]}: {what}"


class Trial:
    """A command in the folder ``work/run``, which begins as ``before``."""

    def __init__(self, command: Command, before: Path, work: Path) -> None:
        self._command, self._work, self._folder, self._blobs = command, work, work / "run", work / "blobs"
        self._blobs.mkdir(exist_ok=True)
        self._before = held(before, self._blobs)
        if command.kind is Kind.FILES:
            old = {name for name in command.outputs if "." in name and name in command.arguments}
            self._before |= dict.fromkeys(old, (FILE, kept(b"old", self._blobs)))
        laid(self._before, self._folder, self._blobs)
        if self._ran(command.arguments, blobs=self._blobs):
            raise RuntimeError(f"{command.name}: {(work / 'said').read_text()}")
        told = [json.loads(line) for line in (work / "operations").read_text().splitlines()]
        self.operations = [str(row["what"]) for row in told]
        self._left: list[Held] = [row["held"] for row in told]
        self._after = held(self._folder, self._blobs)
        self._new = self._looked()
        laid(self._before, self._folder, self._blobs)
        self._old = self._looked()
        self._known = dict[str, tuple[str, list[str]]]()

    @property
    def states(self) -> int:
        """How many different states were looked at."""
        return len(self._known)

    def killed(self, last: int) -> tuple[str, list[str]]:
        """Whether old, new or torn is found after a kill before an operation, and what is left in the end."""
        state = alike(self._left[last - 1], inside=False)
        if state not in self._known:
            self._known[state] = self._judged(self._left[last - 1])
        return self._known[state]

    def _judged(self, found: Held) -> tuple[str, list[str]]:
        if alike(found) == alike(self._after):
            return "new", []
        if alike(found) == alike(self._before):  # from which the first run went
            return "old", []
        laid(found, self._folder, self._blobs)
        now = self._looked()
        laid(found, self._folder, self._blobs)  # once more: who reads a knowledge base moves what is left
        self._ran(self._command.again or self._command.arguments)
        after, every = self._looked(), held(self._folder, self._blobs)
        left = sorted(set(every) ^ set(self._after))
        left += [f"{name}: is another" for name in self._new if after.get(name) != self._new[name]]
        if self._command.kind is Kind.LOG:
            return ("torn" if after != self._new else "new" if now == self._new else "old"), left
        if self._command.kind is Kind.FILES:  # of which each may be old or new
            names = {*self._old, *self._new, *now}
            mixed = any(now.get(name) not in (self._old.get(name), self._new.get(name)) for name in names)
        else:
            mixed = now not in (self._old, self._new)
        return "torn" if mixed else "new" if now == self._new else "old", left

    def hold_to_a_kill(self, last: int) -> None:
        """Kill it in earnest. Raises RuntimeError where that leaves anything else than was kept of the operation."""
        laid(self._before, self._folder, self._blobs)
        status = self._ran(self._command.arguments, last=last)
        if status != -signal.SIGKILL or alike(held(self._folder, self._blobs)) != alike(self._left[last - 1]):
            raise RuntimeError(f"{self._command.name}: killed before {last}, it left what no copy of the folder holds")

    def _ran(self, arguments: Sequence[str], blobs: Path | None = None, last: int | None = None) -> int:
        with (self._work / "operations").open("wb", buffering=0) as told:
            hook = Hook(self._folder, told.fileno(), blobs, last)
            return copied(lambda: run(arguments, self._folder, self._command.stdin, hook), self._work / "said")

    def _looked(self) -> dict[str, str]:
        return dict(asked(lambda: state(self._command, self._folder)))


def tried(command: Command, before: Path, work: Path, most: int | None) -> Tried:
    """Look at what a kill of a command at each operation leaves, or at ``most`` evenly chosen ones."""
    began = monotonic()
    trial = Trial(command, before, work)
    found, left = dict[int, str](), dict[int, list[str]]()
    for last in reversed(_chosen(len(trial.operations), most)):  # those first that have begun most
        found[last], what = trial.killed(last)
        if what:
            left[last] = what
    if command.kind is not Kind.LOG:  # whose processes do not take the same turns twice
        trial.hold_to_a_kill(Random(command.name).randint(1, len(trial.operations)))  # noqa: S311 - no secret
    return Tried(command, trial.operations, found, left, trial.states, monotonic() - began)


def _chosen(count: int, most: int | None) -> list[int]:
    """Numbers from 1, the first and the last among them."""
    if most is None or count <= most:
        return list(range(1, count + 1))
    return sorted({round(1 + i * (count - 1) / (most - 1)) for i in range(most)})


FEWER = """\
import os
import kb.clouds.words as words
import kb.learning.observations as views
views.PIXELS, views.DIRECTIONS, views.PICTURES = (120.0,), 12, 2
words.MOST = 256
"""
"""Read by Python as it starts (``sitecustomize``): types are learned from few and small views."""


def main() -> NoReturn:
    """Print the table, and where anything was torn; the exit status is 1 if it was."""
    parser = argparse.ArgumentParser(description="Kill every command that writes at each of its operations on files.")
    parser.add_argument("names", nargs="*", help="rows of the table; all where none is named")
    parser.add_argument("--most", type=int, help="operations of a command, evenly chosen; else all")
    parser.add_argument("--json", action="store_true", help="the rows as JSON")
    options = parser.parse_args()
    if WORK not in os.environ:
        sys.exit(_afresh())
    work = Path(os.environ[WORK])
    chosen = [command for command in commands() if not options.names or command.name in options.names]
    before = work / "before"
    before.mkdir()
    _import_all()
    prepare(before, chosen, _well)
    rows = [_told(tried(command, before, work, options.most)) for command in chosen]
    sys.stdout.write(
        f"{json.dumps(rows) if options.json else plain_table('killed at each operation', rows).rstrip()}\n"
    )
    sys.exit(1 if any(row["torn"] or row["left"] for row in rows) else 0)


def _told(found: Tried) -> dict[str, Any]:
    sys.stderr.write(f"{json.dumps(found.row())}\n")
    for line in found.lines():
        sys.stderr.write(f"{line}\n")
    sys.stderr.flush()
    return found.row()


WORK = "PLOGIC_CRASHES"
"""The variable that names the folder to work in, of a process that was started for it."""


def _afresh() -> int:
    """The exit status of the same command in a process that starts with few views and with caches of its own."""
    with tempfile.TemporaryDirectory(prefix="plogic-crashes-") as folder:
        start = Path(folder) / "start"
        start.mkdir()
        (start / "sitecustomize.py").write_text(FEWER)
        paths = os.pathsep.join([str(start), str(ROOT), os.environ.get("PYTHONPATH", "")])
        own = {"XDG_CACHE_HOME": f"{folder}/cache", "XDG_STATE_HOME": f"{folder}/state", "OPENBLAS_NUM_THREADS": "1"}
        environment = os.environ | own | {WORK: str(Path(folder).resolve()), "PYTHONPATH": paths}
        command = [sys.executable, "-m", "benchmarks.fuzz.crashes", *sys.argv[1:]]
        return subprocess.run(command, env=environment, check=False).returncode  # noqa: S603 - ourselves


def _import_all() -> None:
    """Import what commands do, so that copies have it."""
    for package in ("geometry", "kb", "sensing", "plogic"):
        for module in pkgutil.walk_packages([str(ROOT / package)], f"{package}."):
            if not module.name.startswith("plogic.logic.") and not module.name.endswith("_child"):
                with suppress(ModuleNotFoundError):
                    import_module(module.name)
    for name in ("cli", "trimesh", "cv2"):
        import_module(name)
    gc.collect()
    gc.freeze()  # a copy's collector would write to, and so copy, the memory of what is imported


def _well(folder: Path, line: str) -> None:
    said = folder.parent / "said"
    if copied(lambda: run(line.split(), folder), said):
        raise RuntimeError(f"{line}: {said.read_text()}")


if __name__ == "__main__":
    main()
