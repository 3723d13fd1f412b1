"""What is nearer to 0 or 1 than the least chance counts as that, and a knowledge base may not say it."""

import pytest

from kb.files import values
from plogic.base.bounds import LEAST, bounded


def test_the_least_chance_of_a_knowledge_base_is_the_programs():
    assert values.LEAST == LEAST


@pytest.mark.parametrize(
    ("p", "counts"), [(0.0, 0.0), (1e-300, LEAST), (LEAST, LEAST), (0.3, 0.3), (1 - 1e-12, 1 - LEAST), (1.0, 1.0)]
)
def test_what_is_possible_stays_so(p, counts):
    assert bounded(p) == counts
