"""Stock ProbLog in a child process: one program, one knowledge compiler, a limit of time and one of memory.

Its times come apart.

Run as ``python -m benchmarks.worlds.stock ddnnf MEGABYTES`` with the program on stdin, it is the child. It grounds as
ProbLog's command line does (evidence propagated), and compiles and evaluates with ProbLog's own defaults (log
semiring). ``plogic`` is our own way from the program's text, under the same conditions: a fresh process, so that
nothing is remembered from an earlier run.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TextIO

from benchmarks.shared.processor import group_seconds, processor_seconds

if TYPE_CHECKING:
    from collections.abc import Callable

Knowledge = Literal["ddnnf", "sdd", "plogic"]
MEGABYTES = 4000
"""Memory that a stock run may have."""
SHORT = 1.0
"""Seconds below which a stock run is repeated, and the fastest counts."""
OVER = "> "


@dataclass(frozen=True)
class StockRun:
    """Processor seconds to parse, ground, and compile and evaluate; P of each query atom.

    ``why`` there is no answer ('' where there is one).

    Where it ran out of time, ``infer`` is how long it had compiled by then.
    """

    knowledge: Knowledge
    parse: float = 0.0
    ground: float = 0.0
    infer: float = 0.0
    answers: dict[str, float] = field(default_factory=dict)
    why: str = ""

    @property
    def whole(self) -> float:
        """Seconds from the characters of the program to its answers; Python's start-up and imports are not counted."""
        return self.parse + self.ground + self.infer

    @property
    def timed_out(self) -> bool:
        """Whether it ran into its limit of time."""
        return self.why.startswith(OVER)


def fastest(text: str, knowledge: Knowledge, seconds: float) -> StockRun:
    """The fastest of three runs, of one where that is long."""
    runs = [stock(text, knowledge, seconds)]
    while len(runs) < 3 and not runs[-1].why and runs[-1].whole < SHORT:
        runs.append(stock(text, knowledge, seconds))
    return min((r for r in runs if not r.why), key=lambda r: r.infer, default=runs[0])


def stock(text: str, knowledge: Knowledge, seconds: float, megabytes: int = MEGABYTES) -> StockRun:
    """Run stock ProbLog on a program with its ``query/1`` lines; what keeps it from an answer is told in ``why``."""
    command = [sys.executable, "-m", "benchmarks.worlds.stock", knowledge, str(megabytes)]
    with tempfile.TemporaryDirectory() as scratch:
        reply = _reply(command, text, scratch, seconds)
    if isinstance(reply, str):
        return StockRun(knowledge, why=reply)
    return StockRun(knowledge, **reply)


def _reply(command: list[str], text: str, scratch: str, seconds: float) -> dict[str, Any] | str:
    """The child's last line, or why there is none; the limit starts when the child has read its imports and says so."""
    root = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join([root, *(entry for entry in sys.path if entry)])
    environment = {**os.environ, "PYTHONPATH": path, "TMPDIR": scratch, "PYTHONHASHSEED": "0"}
    pipe = subprocess.PIPE
    options: dict[str, Any] = {
        "stderr": subprocess.DEVNULL,
        "env": environment,
        "text": True,
        "start_new_session": True,
    }
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, **options) as child:  # noqa: S603 - our own module, no shell
        if child.stdout is not None:
            child.stdout.readline()
        before = group_seconds(child.pid)
        try:
            output = child.communicate(text, timeout=seconds)[0]
        except subprocess.TimeoutExpired as late:
            return _cut_off(late.stdout, group_seconds(child.pid) - before, seconds)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)  # the compiler that it may have started goes with it
    try:
        reply: dict[str, Any] = json.loads(output.splitlines()[-1])
    except (json.JSONDecodeError, IndexError):
        return "memory"
    return reply if "answers" in reply or "why" in reply else {**reply, "why": "memory"}


def _cut_off(output: bytes | str | None, used: float, limit: float) -> dict[str, Any]:
    """What is known of a run that was ended: the stages that it had told of, and the rest of what it had used."""
    told = output.decode() if isinstance(output, bytes) else output or ""
    stages: dict[str, float] = json.loads(told.splitlines()[-1]) if told.strip() else {}
    rest = max(0.0, used - sum(stages.values())) if stages else 0.0
    return {**stages, "infer": rest, "why": f"{OVER}{limit:g}"}


def main() -> None:
    """The child: says that it is ready, reads the program, writes one JSON object."""
    knowledge, megabytes = sys.argv[1], int(sys.argv[2])
    import problog  # noqa: F401 - imported before the clock starts

    import plogic.logic.answers.answer
    import plogic.logic.answers.by_tables
    import plogic.logic.dnnf.compiled  # noqa: F401 - the same, for our own way

    limit = megabytes * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    answer_to = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no part of the reply
    answer_to.write("ready\n")
    answer_to.flush()
    with answer_to:
        _tell(_run(sys.stdin.read(), knowledge, lambda stages: _tell(stages, answer_to)), answer_to)


def _tell(what: dict[str, Any], answer_to: TextIO) -> None:
    answer_to.write(json.dumps(what) + "\n")
    answer_to.flush()


def _run(text: str, knowledge: str, say: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    from problog.errors import ProbLogError

    from plogic.base.errors import BeliefError

    try:
        return _ours(text) if knowledge == "plogic" else _timed(text, knowledge, say)
    except MemoryError:
        return {"why": "out of memory"}
    except RecursionError:
        return {"why": "recursion too deep"}
    except (ProbLogError, BeliefError, ArithmeticError) as error:
        return {"why": type(error).__name__}


def _ours(text: str) -> dict[str, Any]:
    """Our own way from the same characters, in a process that has seen nothing before.

    Its stages are not told apart.
    """
    from plogic.logic.answers.answer import answers_of_text

    start = processor_seconds()
    answers = answers_of_text(text)
    return {"infer": processor_seconds() - start, "answers": answers}


def _timed(text: str, knowledge: str, say: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """The stages in turn; ``say`` is told of the first two before the third begins."""
    from problog import get_evaluatable
    from problog.engine import DefaultEngine
    from problog.formula import LogicFormula
    from problog.program import PrologString

    start = processor_seconds()
    engine = DefaultEngine()
    database = engine.prepare(PrologString(text))
    parsed = processor_seconds()
    formula = LogicFormula.create_from(database, engine=engine, database=database, propagate_evidence=True)
    grounded = processor_seconds()
    stages = {"parse": parsed - start, "ground": grounded - parsed}
    say(stages)
    answers = get_evaluatable(knowledge).create_from(formula).evaluate()
    done = processor_seconds()
    return {**stages, "infer": done - grounded, "answers": {str(term): float(p) for term, p in answers.items()}}


if __name__ == "__main__":
    main()
