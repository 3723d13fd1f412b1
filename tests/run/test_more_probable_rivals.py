"""A rival is called more probable where it is, and not where rounding says so."""

import pytest

from plogic.run.document import surpassed


def document(of_rival):
    rows = [
        {"id": "h1", "type": "t", "status": "accepted", "probability": 0.311594202899, "group": "g1"},
        {"id": "h2", "type": "t", "status": "rival", "probability": of_rival, "group": "g1"},
    ]
    return {"hypotheses": rows, "facts": []}


@pytest.mark.parametrize(
    ("of_rival", "named"), [(0.4, True), (0.311594202999999, False), (0.311594202899, False), (0.2, False)]
)
def test_it_is_named_where_it_is_more_probable(of_rival, named):
    assert bool(surpassed(document(of_rival))) == named
