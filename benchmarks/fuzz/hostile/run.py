"""One run of a program through a door: in a folder of its own, watched from outside and by Python's own hook.

Every process of a run is known by a mark in its environment, whatever session it made itself.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import signal
import sqlite3
import subprocess
import sys
import sysconfig
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

from benchmarks.fuzz import seeds
from benchmarks.fuzz.console import fault_of
from benchmarks.fuzz.hostile.doors import prepare

MARK = "PLOGIC_HOSTILE"
LOOK = 0.05
"""Seconds between two looks at the processes."""
AFTER = 2.0
"""Seconds after the end, by which nothing may live."""
PATIENCE = 120.0
"""Seconds over the limit after which a run is killed."""
AUDIT = Path(__file__).parent / "audit"
PAGE = os.sysconf("SC_PAGE_SIZE")
_OURS = re.compile(r"(?!subprocess)\S+ (\{place\}/tmp/|\{home\}/\.cache/plogic/)|subprocess.Popen \S*/problog/bin/")
"""What is no fault of a program: scratch files, of which none may be left, caches of surfaces, and the compilers that
ProbLog ships."""


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock, of the processor by the command itself, and by it and all that it waited for."""

    clock: float = 0.0
    own: float = 0.0
    together: float = 0.0

    def beside(self, other: Cost) -> Cost:
        """The more of each."""
        return Cost(max(self.clock, other.clock), max(self.own, other.own), max(self.together, other.together))

    def beyond(self, start: Cost, limit: float) -> float:
        """Seconds beyond a limit and what it takes to start.

        By the clock, or by the processor where that says less: on a machine that is busy a command waits for others.
        What it does itself counts from the first second, for its inference runs in another process.
        """
        worked = max(self.own - start.own, self.together - start.together - limit)
        return min(self.clock - start.clock - limit, worked)


@dataclass(frozen=True)
class Seen:
    """What was seen of a run. ``did``: what it opened and started.

    ``owned``: bait that was taken; ``told``: whether a secret was printed; ``left``: files and processes; ``fault``:
    what was wrong with how it ended.
    """

    status: int
    cost: Cost
    memory: int
    did: frozenset[str]
    owned: tuple[str, ...]
    told: bool
    left_files: tuple[str, ...]
    left_processes: int
    fault: str | None


def bait_in(folder: Path, secret: str) -> dict[str, str]:
    """Make the files that leave a trace, and return their paths, as programs name them."""
    folder.mkdir()
    paths = {
        name: str(folder / file)
        for name, file in (
            ("{py}", "evil.py"), ("{pl}", "evil.pl"), ("{secret}", "secret.pl"), ("{csv}", "secret.csv"), ("{db}", "secret.db"),
            ("{new}", "new"), ("{secret_folder}", "secrets"),
        )
    }  # fmt: skip
    Path(paths["{py}"]).write_text(
        f"import os, subprocess\nopen({str(folder / 'owned')!r}, 'w').close()\nos.system('true')\n"
        "subprocess.Popen(['sleep', '30'], start_new_session=True)\n"
        "from problog.extern import problog_export\n@problog_export('-int')\ndef owned():\n    return 7\n"
    )
    Path(paths["{pl}"]).write_text(f":- use_module('{paths['{py}']}').\nleaked.\ntoken('{secret}').\n")
    Path(paths["{secret}"]).write_text(f"token('{secret}').\n")
    Path(paths["{csv}"]).write_text(f"id,token\n1,{secret}\n")
    Path(paths["{secret_folder}"]).mkdir()
    (Path(paths["{secret_folder}"]) / f"{secret}.pl").write_text("leaked.\n")
    with sqlite3.connect(paths["{db}"]) as data:
        data.execute("create table t (x)")
        data.execute("insert into t values (?)", (secret,))
    data.close()
    return paths


def marked(mark: str, others: set[int]) -> list[int]:
    """The living processes with a mark; ``others`` are known to have none."""
    found = []
    for number in numbers() - others:
        try:
            has = f"{MARK}={mark}".encode() in Path(f"/proc/{number}/environ").read_bytes().split(b"\0")
        except OSError:
            has = False
        found.append(number) if has else others.add(number)
    return found


def numbers() -> set[int]:
    """Of all processes, as far as the system tells."""
    return {int(path.name) for path in Path("/proc").glob("[0-9]*")}


def resident(processes: list[int]) -> int:
    """Bytes of memory that processes have together, shared pages counted for each."""
    total = 0
    for number in processes:
        with suppress(OSError, IndexError, ValueError):
            total += int(Path("/proc", str(number), "statm").read_text().split()[1]) * PAGE
    return total


def environment(place: Path, mark: str, secret: str) -> dict[str, str]:
    """Where the run finds its packages, and writes, a home with caches for all; what it must not tell is in it."""
    known = {
        sysconfig.get_path("stdlib"),
        sysconfig.get_path("platstdlib"),
        sysconfig.get_path("purelib"),
        str(seeds.ROOT),
    }
    known |= {
        sys.prefix,
        sys.base_prefix,
        str(Path(sys.prefix).resolve()),
        "/proc/",
        "/sys/",
        "/dev/null",
        "/dev/urandom",
    }
    kept = {name: os.environ[name] for name in ("PATH", "LANG", "LD_LIBRARY_PATH") if name in os.environ}
    return {
        **kept,
        "PYTHONPATH": os.pathsep.join([str(AUDIT), str(seeds.ROOT)]), "OPENBLAS_NUM_THREADS": "1", "HOME": str(place.parent / "home"),
        "TMPDIR": str(place / "tmp"), "PLOGIC_AUDIT": str(place / "audit"), "PLOGIC_AUDIT_KNOWN": os.pathsep.join(sorted(known)),
        "PLOGIC_BAIT": secret, MARK: mark,
    }  # fmt: skip


def run(door: str, text: str, goal: str, place: Path, limit: float) -> Seen:
    """Run a text with bait through a door, in a new folder."""
    secret, mark = secrets.token_hex(12), secrets.token_hex(8)
    shutil.rmtree(place, ignore_errors=True)
    for made in (place / "run", place / "tmp", place.parent / "home"):
        made.mkdir(parents=True, exist_ok=True)
    folder = place / "run"
    paths = bait_in(place / "bait", secret)
    for name, path in paths.items():
        text, goal = text.replace(name, path), goal.replace(name, path)
    words = prepare(folder, door, text, goal, limit)
    before = _files(place)
    begun, others = monotonic(), numbers()
    started = _started(words, place, environment(place, mark, secret))
    cost, memory = _watched(started, begun, begun + limit + PATIENCE, mark, others)
    left = _settled(mark, others)
    wrote = {name for name in _files(place) - before if not name.startswith(("run/.", "audit"))}
    said = [(folder / name).read_text("utf-8", "replace") for name in (".out", ".err")]
    return Seen(
        started.returncode, cost, memory, _did(place), tuple(sorted(name for name in wrote if name.startswith("bait"))),
        any(secret in part for part in said), tuple(sorted(name for name in wrote if not name.startswith("bait"))), left,
        fault_of(started.returncode, 0.0, 0, folder),
    )  # fmt: skip


def _started(words: list[str], place: Path, variables: dict[str, str]) -> subprocess.Popen[bytes]:
    folder = place / "run"
    with (folder / ".in").open("rb") as asked, (folder / ".out").open("wb") as out, (folder / ".err").open("wb") as err:
        command = [str(Path(sys.executable).parent / "plogic"), *words]
        return subprocess.Popen(  # noqa: S603 - our own
            command, stdin=asked, stdout=out, stderr=err, cwd=folder, env=variables, start_new_session=True
        )


def killed(text: str, place: Path) -> int | None:
    """How many processes live on after SIGKILL to a command whose compiler is at work; None where none was seen."""
    mark = secrets.token_hex(8)
    for path in (place / "run", place / "tmp"):
        path.mkdir(parents=True)
    words, others = prepare(place / "run", "explain", text, "a", 0.0), numbers()
    started, end = _started(words, place, environment(place, mark, "")), monotonic() + PATIENCE
    while not (compiles := any(map(_compiles, marked(mark, others)))) and monotonic() < end:
        sleep(LOOK)
    started.kill()
    started.wait()
    left = _settled(mark, others)
    return left if compiles else None


def _compiles(number: int) -> bool:
    try:
        return b"/problog/bin/" in Path(f"/proc/{number}/cmdline").read_bytes()
    except OSError:
        return False


def _watched(
    started: subprocess.Popen[bytes], begun: float, end: float, mark: str, others: set[int]
) -> tuple[Cost, int]:
    """Wait for the command: what it took, and the memory of all its processes at worst."""
    memory, own = 0, 0.0
    while True:
        ended, status, used = os.wait4(started.pid, os.WNOHANG)
        if ended:
            started.returncode = os.waitstatus_to_exitcode(status)
            return Cost(monotonic() - begun, own, used.ru_utime + used.ru_stime), memory
        own = max(own, _own_seconds(started.pid))
        memory = max(memory, resident(marked(mark, others)))
        if monotonic() > end:
            started.kill()
        sleep(LOOK)


def _own_seconds(number: int) -> float:
    """Seconds of the processor that a process has used, without its children; 0 where the system does not tell."""
    try:
        fields = (
            Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
        )  # after the name: state, parent, ...
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _settled(mark: str, others: set[int]) -> int:
    """How many processes live some time after the end; they are killed."""
    end = monotonic() + AFTER
    while (living := marked(mark, others)) and monotonic() < end:
        sleep(LOOK)
    for number in living:
        with suppress(ProcessLookupError):
            os.kill(number, signal.SIGKILL)
    return len(living)


def _files(place: Path) -> set[str]:
    return {str(path.relative_to(place)) for path in place.rglob("*")}


def _did(place: Path) -> frozenset[str]:
    """What the hook wrote down, with the names that differ from run to run taken out."""
    log, home = place / "audit", str(place.parent / "home")
    lines = log.read_text("utf-8", "replace").splitlines() if log.exists() else []
    named = (
        re.sub(r"(plogic-child-)\w+|\d{3,}", r"\1*", line.replace(str(place), "{place}").replace(home, "{home}"))
        for line in lines
    )
    return frozenset(line for line in named if not _OURS.match(line))
