"""Maps of one Γ that were drawn before say what maps drawn anew say, whatever was asked in between."""

import numpy as np
import pytest
from test_votes import data_at

from plogic.match.hand import distance_maps as maps_module
from plogic.match.hand.distance_maps import Drawn, distance_maps


@pytest.mark.parametrize("spare", [0, maps_module.SPARE])
def test_some_of_the_data_again_and_again(spare, monkeypatch):
    monkeypatch.setattr(maps_module, "SPARE", spare)
    rng = np.random.default_rng(4)
    data = data_at([tuple(row) for row in rng.uniform(5, 150, (12, 2)).tolist()])
    drawn, drawing, count = Drawn(data), maps_module._draw_map, []
    places = rng.uniform(-20, 200, (40, 3, 2))
    for _ in range(25):
        some = data.only(rng.random(12) < 0.7)
        allowed = rng.random((3, len(some.ids))) < 0.4
        sets = rng.integers(3, size=(40, 3))
        fresh = distance_maps(allowed, some).look_up(places, sets)
        monkeypatch.setattr(maps_module, "_draw_map", lambda *given: count.append(1) or drawing(*given))
        asked = drawn.maps(allowed, some)
        first = len(count)
        again = drawn.maps(allowed, some)
        assert len(count) == first
        monkeypatch.setattr(maps_module, "_draw_map", drawing)
        for maps in (asked, again):
            distance, datum = maps.look_up(places, sets)
            np.testing.assert_array_equal(distance, fresh[0])
            np.testing.assert_array_equal(datum, fresh[1])
            named = datum[datum >= 0]
            assert set(named.tolist()) <= set(np.flatnonzero(allowed.any(axis=0)).tolist())
