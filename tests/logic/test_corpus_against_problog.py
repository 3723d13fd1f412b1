"""Programs of our own, by area of the language, with their answers in the file.

Stock ProbLog and we are both held to them.

A file ends with what it expects: ``% expect: goal = probability`` (every answer), ``% expect nothing``, ``% expect
error: Kind`` (stock fails, too), or ``% expect refused: line:column`` (by the safety rule).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from plogic.base import errors
from plogic.logic.served.engine import Text
from plogic.logic.served.program_child import serve
from plogic.scene.asking.query import answers

pytestmark = pytest.mark.filterwarnings("ignore:The use of '")  # ProbLog's parser doubts that one means it
FILES = sorted(Path(__file__).parent.glob("programs/*/*.pl"))
LINE = re.compile(r"^% expect(?: (error|refused|nothing))?(?:: (.*))?$", re.MULTILINE)


@dataclass(frozen=True)
class Expected:
    """``answers``: goal → probability; ``error``: the kind of our error; ``refused``: where the safety rule refuses."""

    answers: dict[str, float]
    error: str | None
    refused: str | None


def expected_of(text):
    found = LINE.findall(text)
    kinds = dict(found)
    goals = [rest.rsplit(" = ", 1) for kind, rest in found if not kind]
    return Expected({goal: float(p) for goal, p in goals}, kinds.get("error"), kinds.get("refused"))


PROGRAMS = [(path, path.read_text(), expected_of(path.read_text())) for path in FILES]
ANSWERED = [(path, text, expected) for path, text, expected in PROGRAMS if not (expected.error or expected.refused)]


def stock(text):
    """What ProbLog's own command line would print."""
    from problog import get_evaluatable
    from problog.engine import DefaultEngine
    from problog.evaluator import SemiringLogProbability
    from problog.program import PrologString

    engine = DefaultEngine()
    db = engine.prepare(PrologString(text))
    formula = get_evaluatable().create_from(db, engine=engine, database=db, propagate_evidence=True)
    return {str(goal): p for goal, p in formula.evaluate(semiring=SemiringLogProbability()).items()}


def ours(path, text):
    """One list of answers, as the child process would reply."""
    (found,) = serve({"texts": [{"text": text, "file": path.name}], "goals": [], "given": [], "names": None})["answers"]
    return found


def test_the_corpus_is_large_and_says_what_it_expects():
    assert len(ANSWERED) >= 100
    assert sum(len(expected.answers) for _, _, expected in ANSWERED) >= 350
    assert sum(bool(expected.error) for _, _, expected in PROGRAMS) >= 15
    refused = sum(bool(expected.refused) for _, _, expected in PROGRAMS)
    assert 1 <= refused <= 0.05 * (len(ANSWERED) + refused), "at most one in twenty of what stock answers is refused"


@pytest.mark.parametrize(("path", "text", "expected"), PROGRAMS, ids=lambda p: getattr(p, "stem", ""))
def test_a_file_says_one_thing_that_the_tests_read(path, text, expected):
    """No line of expectations that is passed over, none that another takes the place of."""
    lines = [line for line in text.splitlines() if re.match(r"\s*%\s*expect", line, re.IGNORECASE)]
    found = LINE.findall(text)
    assert len(found) == len(lines) >= 1
    kinds = {kind for kind, _ in found}
    assert len(kinds) == 1
    if kinds == {""}:
        assert len(expected.answers) == len(found)
        assert all(0.0 <= p <= 1.0 for p in expected.answers.values())
    else:
        assert len(found) == 1
        assert not expected.error or issubclass(getattr(errors, expected.error), errors.PlogicError)
        assert not expected.refused or re.fullmatch(r"\d+:\d+", expected.refused)


@pytest.mark.parametrize(
    ("path", "text", "expected"), [p for p in PROGRAMS if not p[2].refused], ids=lambda p: getattr(p, "stem", "")
)
def test_stock_problog_answers_what_the_file_says(path, text, expected, capfd):
    if expected.error:
        with pytest.raises(Exception):  # noqa: B017, PT011 - ProbLog raises what Python raises; which, our own test says
            stock(text)
    else:
        assert stock(text) == pytest.approx(expected.answers, abs=1e-6)
    assert path in FILES
    capfd.readouterr()


@pytest.mark.parametrize(("path", "text", "expected"), PROGRAMS, ids=lambda p: getattr(p, "stem", ""))
def test_we_answer_what_the_file_says(path, text, expected, capfd):
    if expected.refused:
        with pytest.raises(errors.UnsafeProgramError, match=rf"^{path.name}:{expected.refused}: "):
            ours(path, text)
    elif expected.error:
        with pytest.raises(getattr(errors, expected.error)):
            ours(path, text)
    else:
        found = ours(path, text)
        assert dict(found) == pytest.approx(expected.answers, abs=1e-6)
        assert len(found) == len(expected.answers)
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize(("path", "text", "expected"), ANSWERED[::12], ids=lambda p: getattr(p, "stem", ""))
def test_the_entry_that_users_take_answers_the_same(path, text, expected):
    found = answers(Text(text, path.name))
    assert {answer.goal: answer.probability for answer in found} == pytest.approx(expected.answers, abs=1e-6)
    assert found == sorted(found, key=lambda answer: (-float(f"{answer.probability:.11e}"), answer.goal))
