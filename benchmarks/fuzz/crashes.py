"""Commands that write, killed at each of their operations on files: what is read afterwards is the old or the new.

``python -m benchmarks.fuzz.crashes`` kills every command of ``commands()`` at each operation; ``--most 6``: at so many,
evenly chosen. A command runs in a copy (fork) of a process that has imported everything. CPython itself tells each file
that is opened to be written, renamed or removed (``sys.addaudithook``); what is written and synced is counted by
stand-ins of ``open``, ``os.write`` and ``os.fsync``. Before the operation whose turn it is the process kills itself
with SIGKILL; of a write, half is done first.

* ``old``, ``new``: kills after which everything that the command writes was as before, or as without a kill
* ``torn``: kills after which it was neither: a knowledge base is what ``read_kb`` makes of it, a file its bytes
* ``left``: kills after which the same command, run again, did not end with the files of a run without a kill
"""

from __future__ import annotations

import argparse
import builtins
import gc
import io
import json
import os
import pkgutil
import shutil
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
from typing import Any, NoReturn

from benchmarks.fuzz.crash_commands import ROOT, Command, Kind, commands, prepare
from plogic.face.shown.tables import plain_table

AUDITED = {
    "open": 0, "os.rename": 1, "os.remove": 0, "os.rmdir": 0, "os.mkdir": 0, "os.truncate": 0, "os.chmod": 0,
    "os.link": 1, "os.symlink": 1,
}  # fmt: skip
"""Operations that CPython tells, and which of what it tells is the place."""
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC


class Hook:
    """Counts a process's operations on files in ``folder``; kills it at the one numbered ``last``, from 1."""

    def __init__(self, folder: Path, last: int | None, note: int) -> None:
        """``note``: a descriptor that every operation is told to, a line each."""
        self._folder, self._last, self._note = f"{folder}{os.sep}", last, note
        self._count, self._pid = 0, os.getpid()
        self._write, self._open, self._sync, self._cut = os.write, io.open, os.fsync, os.ftruncate

    def install(self) -> None:
        """From now on, for good."""
        sys.addaudithook(self._audited)
        io.open = builtins.open = self._opened
        os.fsync, os.ftruncate = self._synced, self._shortened
        os.write = self._written  # type: ignore[assignment]

    def step(self, what: str, place: object, half: Callable[[], object] | None = None) -> None:
        """An operation is next; where it is the last, ``half`` of it is done and the process ends."""
        if os.getpid() != self._pid or not self._concerns(place):
            return
        self._count += 1
        self._write(self._note, f"{what} {self._place(place)}\n".encode())
        if self._count == self._last:
            if half is not None:
                half()
            os.kill(self._pid, signal.SIGKILL)

    def _concerns(self, place: object) -> bool:
        return (self._place(place) or "").startswith(self._folder)

    def _place(self, place: object) -> str | None:
        if isinstance(place, int):
            try:
                return str(Path(f"/proc/self/fd/{place}").readlink())
            except OSError:
                return None
        return str(Path.cwd() / os.fsdecode(place)) if isinstance(place, str | bytes | os.PathLike) else None

    def _audited(self, event: str, told: tuple[Any, ...]) -> None:
        which = AUDITED.get(event)
        if which is None or (event == "open" and not told[2] & WRITES):
            return
        place, folder = told[which], told[-1]
        if event in ("os.remove", "os.rmdir") and isinstance(folder, int) and folder >= 0:
            place = f"{self._place(folder)}/{os.fsdecode(place)}"
        self.step(event, place)

    def _synced(self, fd: Any) -> None:  # noqa: ANN401 - as os.fsync
        self.step("fsync", fd)
        self._sync(fd)

    def _shortened(self, fd: int, length: int) -> None:
        self.step("truncate", fd)
        self._cut(fd, length)

    def _written(self, file: int, data: bytes) -> int:
        self.step("write", file, lambda: self._write(file, bytes(data)[: len(data) // 2]))
        return self._write(file, data)

    def _opened(self, file: Any, mode: str = "r", buffering: int = -1, *more: Any, **named: Any) -> Any:  # noqa: ANN401 - as open
        if not set(mode) & set("wax+") or not self._concerns(file):
            return self._open(file, mode, buffering, *more, **named)
        own = {key: named.pop(key) for key in ("closefd", "opener") if key in named}
        raw = _Raw(file, mode.replace("b", "").replace("t", ""), **own)
        raw.hook = self
        if buffering == 0:
            return raw
        held = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return held if "b" in mode else io.TextIOWrapper(held, *more, **named)


class _Raw(io.FileIO):
    """A file whose writes are counted."""

    hook: Hook

    def write(self, data: Any) -> int:  # noqa: ANN401 - any buffer
        """As ``io.FileIO`` does."""
        some = memoryview(data).cast("B")
        self.hook.step("write", self.fileno(), lambda: super(_Raw, self).write(some[: len(some) // 2]))
        return super().write(some) or 0


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
        hook._pid = os.getpid()  # noqa: SLF001 - it was made before the copy
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
    """A command's operations, a line each, and what each kill before one of them left."""

    command: Command
    operations: list[str]
    found: dict[int, str]
    left: dict[int, list[str]]

    def row(self) -> dict[str, Any]:
        """For the table."""
        counts = {what: sum(found == what for found in self.found.values()) for what in ("old", "new", "torn")}
        kills = {"command": self.command.name, "operations": len(self.operations), "kills": sum(counts.values())}
        return kills | counts | {"left": len(self.left)}

    def lines(self) -> Iterator[str]:
        """Where it was torn, and what was left."""
        for number in sorted(number for number, found in self.found.items() if found == "torn" or number in self.left):
            what = self.found[number] + (f", left: {' '.join(self.left[number][:4])}" if number in self.left else "")
            yield f"{self.command.name}: killed before {number}, {self.operations[number - 1]}: {what}"


class Trial:
    """A command in the folder ``work/run``, which begins as ``before``."""

    def __init__(self, command: Command, before: Path, work: Path) -> None:
        self._command, self._before, self._work, self._folder = command, before, work, work / "run"
        self._first(1)
        self._old, _ = self._looked()
        if self._first(None):
            raise RuntimeError(f"{command.name}: {(work / 'said').read_text()}")
        self.operations = (work / "operations").read_text().splitlines()
        self._new, self._every = self._looked()

    def killed(self, last: int) -> tuple[str, list[str]]:
        """Whether old, new or torn was found after a kill before an operation, and what was left in the end.

        "missed" where a command of several processes came to its end with fewer operations than the first time.
        """
        status = self._first(last)
        if not status and self._command.kind is Kind.LOG:
            return "missed", []
        if status != -signal.SIGKILL:
            raise RuntimeError(f"{self._command.name}: has fewer than {last} operations the second time")
        now = self._looked()[0]
        self._ran(None, self._command.again or self._command.arguments)
        after, every = self._looked()
        left = sorted(set(every) ^ set(self._every))
        left += [f"{name}: is another" for name in self._new if after.get(name) != self._new[name]]
        if self._command.kind is Kind.LOG:
            return ("torn" if after != self._new else "new" if now == self._new else "old"), left
        if self._command.kind is Kind.FILES:  # of which each may be old or new
            names = {*self._old, *self._new, *now}
            mixed = any(now.get(name) not in (self._old.get(name), self._new.get(name)) for name in names)
        else:
            mixed = now not in (self._old, self._new)
        return "torn" if mixed else "new" if now == self._new else "old", left

    def _first(self, last: int | None) -> int:
        shutil.rmtree(self._folder, ignore_errors=True)
        shutil.copytree(self._before, self._folder)
        if self._command.kind is Kind.FILES:
            for name in self._command.outputs:
                if "." in name and name in self._command.arguments:
                    (self._folder / name).write_bytes(b"old")
        return self._ran(last, self._command.arguments)

    def _ran(self, last: int | None, arguments: Sequence[str]) -> int:
        with (self._work / "operations").open("wb", buffering=0) as told:
            hook = Hook(self._folder, last, told.fileno())
            return copied(lambda: run(arguments, self._folder, self._command.stdin, hook), self._work / "said")

    def _looked(self) -> tuple[dict[str, str], list[str]]:
        found = asked(lambda: state(self._command, self._folder))
        return found, sorted(str(path.relative_to(self._folder)) for path in self._folder.rglob("*"))


def tried(command: Command, before: Path, work: Path, most: int | None) -> Tried:
    """Kill a command that finds ``before`` in its folder at each operation, or at ``most`` evenly chosen ones."""
    trial = Trial(command, before, work)
    found, left = dict[int, str](), dict[int, list[str]]()
    for last in _chosen(len(trial.operations), most):
        found[last], what = trial.killed(last)
        if what:
            left[last] = what
    return Tried(command, trial.operations, found, left)


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
