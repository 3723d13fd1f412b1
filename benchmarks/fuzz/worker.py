"""One lot of inputs in a process of its own, which may die of them.

What a lot is made of follows from its kind, the seed, its number and the inputs that earlier lots found of interest, so
that it can be made again.
"""

from __future__ import annotations

import re
import resource
import shutil
import sys
import tempfile
import traceback
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from time import process_time
from typing import TYPE_CHECKING, Any, Protocol
from zlib import crc32

from geometry.errors import PlogicError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from multiprocessing.connection import Connection

    from benchmarks.fuzz.kinds import Kind


class Counter(Protocol):
    """A number that two processes share."""

    value: int


SLOW = 10.0
"""Processor seconds of one input that count as a hang."""
MEMORY = 2 << 30
"""Bytes of address space that the reading of one input may take beside what the process has."""
SMALL = 10_000
"""Bytes of an input from which others are made: most of those that are larger are long in one place alone."""
_OWN = re.compile(r"\d+|'[^']*'|\"[^\"]*\"|/[^\s:]*")


@dataclass(frozen=True)
class Fault:
    """What must not happen: an exception that is none of ours, a hang, a death."""

    kind: str
    what: str
    data: bytes
    where: str = ""

    @property
    def sign(self) -> tuple[str, str, str]:
        """Faults of one sign are one mistake."""
        return self.kind, _OWN.sub("", self.what), self.where


@dataclass
class Lot:
    """What came of one lot, or of a part of it; ``last``: nothing follows."""

    last: bool = False
    tried: int = 0
    accepted: int = 0
    seconds: float = 0.0
    slowest: float = 0.0
    slowest_data: bytes = b""
    memory: int = 0
    faults: list[Fault] = field(default_factory=list)
    found: list[bytes] = field(default_factory=list)


def inputs(kind: Kind, seed: int, number: int, pool: Sequence[bytes], count: int) -> Any:  # noqa: ANN401 - an iterator of bytes
    """The inputs of a lot, in order: of the first lot the good ones come first; most are made from those."""
    good = pool[: len(kind.seeds())]
    rng = Random(f"{kind.name} {seed} {number}")  # noqa: S311 - no secret
    start = list(pool)[:count] if number == 0 else []
    yield from start
    for _ in range(count - len(start)):
        data = kind.mutate(rng.choice(rng.choice((good, pool))), rng, pool)
        yield kind.mutate(data, rng, pool) if rng.randrange(4) == 0 else data


def work(
    kind: Kind, lot: tuple[int, int, int, int], pool: Sequence[bytes], folder: Path, at: Counter, end: Connection
) -> None:
    """Read a lot's inputs, from one on, and send what came of it.

    ``at`` is twice the number of the input that is read, and one more once it has been.
    """
    seed, number, count, first = lot
    warnings.simplefilter("ignore")
    limit()
    path = place_for(kind, folder)
    known: set[str] = set()
    done = Lot()
    start = process_time()
    for i, data in enumerate(inputs(kind, seed, number, pool, count)):
        if i >= first:
            at.value = 2 * i
            _one(kind, path, data, done, known)
            at.value = 2 * i + 1
        if done.faults:  # told at once: the next input may be the end
            end.send(_measured(done, start))
            done, start = Lot(), process_time()
    done.last = True
    end.send(_measured(done, start))


def _measured(done: Lot, start: float) -> Lot:
    done.seconds = process_time() - start
    done.memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return done


def limit() -> None:
    """Let this process take so much more memory than it has, and write no core."""
    size = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def place_for(kind: Kind, folder: Path) -> Path:
    """The input's path, below a folder with all that belongs beside it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    tempfile.tempdir = None
    kind.beside(folder)
    path = folder / kind.file
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _one(kind: Kind, path: Path, data: bytes, done: Lot, known: set[str]) -> None:
    path.write_bytes(data)
    start = process_time()
    sign, fault = outcome(kind, path, data)
    took = process_time() - start
    done.tried += 1
    done.accepted += sign == "accepted"
    if took > done.slowest:
        done.slowest, done.slowest_data = took, data
    if fault is not None and fault.sign not in {f.sign for f in done.faults}:
        done.faults.append(fault)
    if len(data) > SMALL or fault is not None:
        return
    if (sign == "accepted" and done.accepted % 50 == 1) or sign not in known:
        known.add(sign)
        done.found.append(data)


def outcome(kind: Kind, path: Path, data: bytes) -> tuple[str, Fault | None]:
    """How the reading of an input ended, in words without names and numbers, and whether it should not have."""
    try:
        kind.read(path)
        if crc32(data) % kind.every == 0:
            kind.use(path)
    except PlogicError as error:
        return f"{type(error).__name__} {_OWN.sub('', str(error)[:2000])[:200]}", None
    except Exception as error:  # noqa: BLE001 - any other is what is looked for
        last = traceback.extract_tb(sys.exc_info()[2])
        ours = [frame for frame in last if "site-packages" not in frame.filename and "/fuzz/" not in frame.filename]
        frame = (ours or last)[-1]
        where = f"{Path(frame.filename).name}:{frame.lineno}"
        what = f"{type(error).__name__}: {str(error)[:200]}"
        return what, Fault(kind.name, what, data, where)
    return "accepted", None
