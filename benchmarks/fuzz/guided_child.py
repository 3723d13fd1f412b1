"""The process that reads one kind of input and is led by the code that an input reaches: libFuzzer, through atheris.

``python -m benchmarks.fuzz.guided_child KIND COUNT SEED FOLDER POOL START``: ``FOLDER`` is for what a reader needs, in
``POOL`` libFuzzer puts what reached new code, ``START`` holds what it begins with. To stdout goes a line an input: how
its reading ended, in eight hexadecimal digits, or a fault (JSON). What libFuzzer says goes to stderr.
"""

from __future__ import annotations

import json
import os
import re
import sys
import warnings
from base64 import b64encode
from importlib import import_module
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any
from zlib import crc32

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.fuzz.kinds import Kind

PACKAGES = "geometry", "kb", "sensing", "plogic", "cli", "problog"
"""Whose code is watched."""
LONGEST = 20_000
"""Bytes of an input, or twice those of the longest good one: what is kept is read again and again."""
OWN = 16
"""Of so many changes one is libFuzzer's own, which knows what the code compares with; the others keep the structure."""


COMPILED = re.compile(r"^@(njit|compiled)\b|^from numba\b", re.MULTILINE)
"""What a module has whose functions numba compiles."""


def main() -> None:
    """Read so many inputs."""
    atheris: Any = import_module("atheris")
    atheris.instrument_imports(include=PACKAGES, exclude=compiled()).__enter__()  # for good: readers import late
    from plogic.base.children import begin

    begin()
    from benchmarks.fuzz.kinds import kinds
    from benchmarks.fuzz.worker import limit, place_for

    name, count, seed, folder, pool, start = sys.argv[1:]
    kind = kinds()[name]
    warnings.simplefilter("ignore")
    path = place_for(kind, Path(folder))
    with os.fdopen(os.dup(1), "wb", buffering=0) as out:
        os.dup2(2, 1)  # whatever a library prints is no line
        reading = reader(kind, path, out.write)
        for data in kind.seeds():  # what is imported from now on would not be watched
            reading(data)
        limit()
        longest = max([LONGEST, *(2 * len(data) for data in kind.seeds())])
        words = [
            sys.argv[0],
            f"-runs={count}",
            f"-seed={seed}",
            f"-max_len={longest}",
            "-len_control=0",
            "-reload=0",
            "-reduce_inputs=0",
            "-mutate_depth=1",
        ]
        words += ["-rss_limit_mb=0", "-timeout=1000000", "-handle_segv=0", f"-artifact_prefix={folder}/", pool, start]
        own = lambda *data: atheris.Mutate(*data)  # noqa: E731, PLW0108 - which Fuzz makes another
        atheris.Setup(words, reading, custom_mutator=mutator(kind, own))
        atheris.Fuzz()


def compiled() -> list[str]:
    """The modules that numba compiles, which cannot be watched."""
    root = Path(__file__).resolve().parents[2]
    paths = [
        path for name in PACKAGES for path in (root / name).rglob("*.py") if COMPILED.search(path.read_text("utf-8"))
    ]
    return [".".join(path.relative_to(root).with_suffix("").parts) for path in paths]


def reader(kind: Kind, path: Path, tell: Callable[[bytes], Any]) -> Callable[[bytes], None]:
    """What libFuzzer calls with each input."""
    from benchmarks.fuzz.worker import outcome

    def reading(data: bytes) -> None:
        path.write_bytes(data)
        sign, fault = outcome(kind, path, data)
        told = f"{crc32(sign.encode()):08x}"
        if fault is not None:
            told = json.dumps({"what": fault.what, "where": fault.where, "data": b64encode(data).decode()})
        tell(told.encode() + b"\n")

    return reading


def mutator(kind: Kind, own: Callable[[bytes, int], bytes]) -> Callable[[bytes, int, int], bytes]:
    """What libFuzzer calls to change an input: the kind's way, or its ``own``."""
    pool: Sequence[bytes] = kind.seeds()

    def mutate(data: bytes, most: int, seed: int) -> bytes:
        rng = Random(seed)  # noqa: S311 - no secret
        if rng.randrange(OWN) == 0:
            return own(data, most)
        return kind.mutate(data, rng, pool)[:most]

    return mutate


if __name__ == "__main__":
    main()
