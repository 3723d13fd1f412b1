"""Which data a type's features look like: by the definition, one by one, is the oracle."""

from dataclasses import replace

import numpy as np
import pytest
from oriented_scenes import STRAIGHT, clouds, datum, kb_of, with_other_look

from plogic.match.gamma.data import data_of


@pytest.mark.parametrize("count", [0, 1, 40])
def test_a_datum_is_a_features_that_has_a_lobe_of_its_type(count):
    rng = np.random.default_rng(count)
    kind = replace(with_other_look(clouds().kb.types[0], clouds().kb.appearance_types[0]), name="both")
    index = kb_of(kind).rows[0]
    data = data_of(
        [
            datum(i, rng.choice([*clouds().kb.appearance_types, "stranger"]), rng.uniform(0, 400, 2))
            for i in range(count)
        ],
        STRAIGHT,
    )
    wanted = [
        [name in {a.type for a in feature.appearances} for name in data.types] for feature in index.object_type.features
    ]
    assert index.allowed(data).tolist() == wanted
    some = data.only(np.arange(count) % 3 == 0)
    assert index.allowed(some).tolist() == [row[::3] for row in wanted]
