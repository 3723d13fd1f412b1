"""A rival is called more probable where it is, and as probable where rounding alone says so."""

import pytest

from plogic.run.document import surpassed


def document(of_rival):
    rows = [
        {"id": "h1", "type": "t", "status": "accepted", "probability": 0.311594202899, "group": "g1"},
        {"id": "h2", "type": "t", "status": "rival", "probability": of_rival, "group": "g1"},
    ]
    return {"hypotheses": rows, "facts": []}


@pytest.mark.parametrize(
    ("of_rival", "said"),
    [
        (0.4, ["h2 (t, P 0.400) is a more probable reading of the same data than h1"]),
        (0.311594202999999, ["h2 (t, P 0.312) is as probable a reading of the same data as h1"]),
        (0.3112, ["h2 (t, P 0.311) is as probable a reading of the same data as h1"]),
        (0.2, []),
    ],
)
def test_it_is_named_where_it_is_as_probable_or_more(of_rival, said):
    assert list(surpassed(document(of_rival)).values()) == said
