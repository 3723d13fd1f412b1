"""Terms of proofs are written so that ProbLog reads the same terms again."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from problog.program import PrologString

from plogic.logic.proof.terms import PRIORITY, small, text
from plogic.logic.safety.atoms import Names

leaves = st.one_of(
    st.integers(1, 9), st.sampled_from([0.5, 2.25]), st.sampled_from([("a",), ("h1",)]), st.just(("f", ("b",), 3))
)
TIGHT = sorted(name for name, priority in PRIORITY.items() if priority < 700)


def compound(inner):
    return st.one_of(
        st.tuples(st.sampled_from(TIGHT), inner, inner), st.tuples(st.just("-"), inner), st.tuples(st.just("g"), inner)
    )


sums = st.recursive(leaves, compound, max_leaves=12)


def plain(term):
    """Without the quotes that ProbLog keeps; the minus of a number is a part of it."""
    if not isinstance(term, tuple):
        return term
    name, *inner = (str(term[0]).strip("'"), *map(plain, term[1:]))
    return -inner[0] if name == "-" and len(inner) == 1 and not isinstance(inner[0], tuple) else (name, *inner)


def read(written):
    (fact,) = PrologString(f"x({written}).")
    return plain(small(fact.args[0], {}))


@given(sums)
def test_what_is_written_is_read_as_it_was(term):
    assert read(text(term, None)) == plain(term)


@given(sums, st.sampled_from(["is", "<", "=:="]), sums)
def test_comparisons_too(left, name, right):
    assert read(text((name, left, right), None)) == plain((name, left, right))


@pytest.mark.parametrize(
    ("term", "written"),
    [
        (("/", ("-", 3, 1), ("+", 3, 1)), "(3-1)/(3+1)"),
        (("-", ("-", 3, 1)), "-(3-1)"),
        (("/", 1, ("*", 2, 3)), "1/(2*3)"),
        (("/", ("h1",), ("roof",)), "h1/roof"),
        (("is", 1.5, ("-", ("-", 5, 2), 1)), "1.5 is 5-2-1"),
    ],
)
def test_of_scenes_and_of_plain_programs(term, written):
    assert text(term, None) == written
    assert text(term, Names.of({})) == written
