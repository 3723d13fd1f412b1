"""The stopwatch: which stage runs, and how far it has come."""

from plogic.base.clock import Stopwatch


def test_a_stage_within_another_has_its_own_part_and_gives_the_outer_ones_back():
    clock = Stopwatch()
    assert clock.here == ""
    with clock.stage("search"):
        clock.at("3 of 8 types")
        assert clock.here == "search, 3 of 8 types"
        with clock.stage("facts"):
            assert clock.here == "facts"
        assert clock.here == "search, 3 of 8 types"
    assert clock.here == ""
    assert list(clock.seconds) == ["facts", "search"]


def test_what_is_one_of_several_has_stages_of_its_own_behind_its_name():
    clock = Stopwatch()
    clock.inner = one = Stopwatch()
    with clock.stage("view 2 of 5"), one.stage("search"):
        one.at("3 of 8 types")
        assert clock.here == "view 2 of 5, search, 3 of 8 types"
    assert clock.here == ""
    assert (list(clock.seconds), list(one.seconds)) == (["view 2 of 5"], ["search"])
