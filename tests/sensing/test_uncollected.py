"""The garbage collector rests inside, and is as it was afterwards."""

import gc

import pytest

from sensing.uncollected import uncollected


@pytest.mark.parametrize("active", [True, False])
def test_the_collector_is_as_it_was_afterwards(active):
    was = gc.isenabled()
    try:
        (gc.enable if active else gc.disable)()
        with uncollected():
            assert not gc.isenabled()
            with uncollected():
                assert not gc.isenabled()
            assert not gc.isenabled()
        assert gc.isenabled() == active
        with pytest.raises(ZeroDivisionError), uncollected():
            _ = 1 / 0
        assert gc.isenabled() == active
    finally:
        (gc.enable if was else gc.disable)()
