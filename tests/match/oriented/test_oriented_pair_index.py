"""The index of pairs of neighbours: all pairs one by one are the oracle."""

from collections import Counter
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oriented_scenes import clouds

from plogic.match.gamma.grid import wrapped
from plogic.match.oriented.pair_index import BINS, FINE, NEIGHBOURS, SHORTEST, STEP, pair_index, said

SMALL = {"count": 3, "features": 40, "looks": 6, "seed": 4}
"""So many features that a cell shows more than eight, and so few looks that pairs of equal ones are common."""


ANY = np.pi
"""Tolerance that leaves it to the parts of the circle."""


def part(angle, parts=BINS):
    return int(np.floor((angle % (2.0 * np.pi)) / (2.0 * np.pi) * parts)) % parts


def told(kind, cell, ends, diameter):
    """Type, cell, direction, length and the first's place, in the index's steps."""
    (x, y), (dx, dy) = ends[0] / diameter, ends[1] - ends[0]
    length = np.log(np.hypot(dx, dy) / diameter / SHORTEST) / STEP
    return kind, cell, part(np.arctan2(dy, dx), FINE), round(float(length)), round(127.0 * x), round(127.0 * y)


@cache
def all_pairs():
    """(looks, parts of the angles, what is said, the angles) of all neighbours in all cells.

    Equal looks both ways round.
    """
    sights, found = clouds(**SMALL).shared.sights, []
    for kind, cell in np.ndindex(*sights.looks.shape[:2]):
        some = np.flatnonzero(sights.looks[kind, cell] >= 0)
        xy, looks, angle = (
            rows[kind, cell] for rows in (sights.xy.astype(float), sights.looks, sights.angle.astype(float))
        )
        near = {
            i: sorted((j for j in some if j != i), key=lambda j, i=i: np.hypot(*(xy[j] - xy[i])))[:NEIGHBOURS]
            for i in some
        }
        for i in some:
            for j in some:
                if i == j or (j not in near[i] and i not in near[j]) or looks[i] > looks[j]:
                    continue
                dx, dy = xy[j] - xy[i]
                line = np.arctan2(dy, dx)
                key = (int(looks[i]), int(looks[j])), (part(angle[i] - line), part(angle[j] - line))
                says = told(kind, cell, (xy[i], xy[j]), sights.diameter[kind])
                found.append((*key, says, (angle[i] - line, angle[j] - line)))
    return found


def beside(one, other):
    return (one - other + 2) % BINS <= 4


def asked(looks, angles):
    """What the oracle finds."""
    parts = [part(angle) for angle in angles]
    return sorted(
        row
        for pair, own, row, _ in all_pairs()
        if pair == looks and all(beside(a, b) for a, b in zip(own, parts, strict=True))
    )


def found(index, looks, angles):
    """What the index finds for one query, as the oracle tells it."""
    query, entry, _ = index.found(tuple(np.array([x]) for x in looks), tuple(np.array([x], float) for x in angles), ANY)
    assert (query == 0).all()
    return rows_of(entry)


def rows_of(entry):
    """What is said, in the index's steps."""
    says = said(entry)
    steps = (
        np.floor(says.line / (2.0 * np.pi) * FINE),
        np.rint(np.log(says.length / SHORTEST) / STEP),
        *np.rint(127.0 * says.place.T),
    )
    return sorted(tuple(map(int, row)) for row in zip(says.kind, says.cell, *steps, strict=True))


LOOKS = st.tuples(st.integers(0, 5), st.integers(0, 5)).map(lambda pair: tuple(sorted(pair)))
TURN = st.floats(-7.0, 7.0).filter(lambda a: abs(a * BINS / (2 * np.pi) - round(a * BINS / (2 * np.pi))) > 1e-6)
"""Any angle but on the very border of two parts."""


@settings(max_examples=60, deadline=None, derandomize=True)
@given(LOOKS, st.tuples(TURN, TURN))
def test_exactly_the_neighbours_that_look_alike_are_found(looks, angles):
    got, expected = found(clouds(**SMALL).shared, looks, angles), asked(looks, angles)
    wrong = sorted(set(got) ^ set(expected))[:3]  # pytest takes minutes over the difference of long lists
    assert wrong == []
    assert len(got) == len(expected)


def test_every_pair_is_found_by_its_own_looks_and_angles():
    index, some = clouds(**SMALL).shared, all_pairs()[:: max(1, len(all_pairs()) // 300)]
    looks = tuple(np.array([row[0][side] for row in some]) for side in (0, 1))
    angles = tuple(np.array([row[3][side] for row in some]) for side in (0, 1))
    query, entry, _ = index.found(looks, angles, ANY)
    told = {(int(q), row) for q, e in zip(query, entry, strict=True) for row in rows_of(np.array([e]))}
    assert all((n, row[2]) in told for n, row in enumerate(some))
    assert len(some) >= 300


def test_some_cells_show_more_than_the_neighbours_of_one_and_looks_repeat():
    """Else the test against all pairs would say little."""
    index = clouds(**SMALL).shared
    assert ((index.sights.looks >= 0).sum(axis=2) > NEIGHBOURS + 4).mean() > 0.5
    assert sum(pair[0] == pair[1] for pair, *_ in all_pairs()) > 1000


def test_pairs_of_equal_looks_come_both_ways_round():
    """Turned round, the line points the other way: both angles are half a turn more, and they change places."""
    index = clouds(**SMALL).shared
    same = [row for row in all_pairs() if row[0][0] == row[0][1]][::200]
    assert len(same) > 5
    for looks, _, row, (one, other) in same:
        kind, cell, line, length, *_ = row
        back = {(k, c, way, far) for k, c, way, far, *_ in found(index, looks, (other + np.pi, one + np.pi))}
        assert row in found(index, looks, (one, other))
        assert (kind, cell, (line + FINE // 2) % FINE, length) in back


@settings(max_examples=20, deadline=None, derandomize=True)
@given(LOOKS, st.tuples(TURN, TURN), st.sampled_from([5.0, 10.0, 20.0]))
def test_what_is_further_off_than_the_tolerance_is_not_found(looks, angles, degrees):
    """To the fineness with which an entry tells its angles."""
    index, step = clouds(**SMALL).shared, 2.0 * np.pi / FINE
    query = tuple(np.array([x]) for x in looks), tuple(np.array([x]) for x in angles)
    _, entry, far = index.found(*query, np.radians(degrees))
    got = Counter(rows_of(entry))
    assert (far * step <= np.radians(degrees)).all()
    off = [
        (row, max(abs(wrapped(np.array(a) - b)) for a, b in zip(own, angles, strict=True)))
        for pair, _, row, own in all_pairs()
        if pair == looks
    ]
    assert got <= Counter(row for row, far in off if far <= np.radians(degrees) + step)
    assert got >= Counter(row for row, far in off if far <= np.radians(degrees) - step)


def test_many_queries_are_as_many_single_ones():
    index, rng = clouds(**SMALL).shared, np.random.default_rng(3)
    looks = np.sort(rng.integers(0, 6, (40, 2)), axis=1)
    angles = rng.uniform(-np.pi, np.pi, (40, 2))
    query, entry, _ = index.found(tuple(looks.T), tuple(angles.T), ANY)
    for q in range(40):
        assert rows_of(entry[query == q]) == found(index, looks[q], angles[q])
    assert len(entry) > 100


def test_where_too_much_is_found_the_commonest_are_left_out():
    """Each query is answered wholly or not at all, and none that is left out finds less than one that is not."""
    index, rng = clouds(**SMALL).shared, np.random.default_rng(5)
    looks, angles = tuple(np.sort(rng.integers(0, 6, (60, 2)), axis=1).T), tuple(rng.uniform(-np.pi, np.pi, (2, 60)))
    whole = np.bincount(index.found(looks, angles, ANY)[0], minlength=60)
    most = int(whole.sum()) // 3
    some = np.bincount(index.found(looks, angles, ANY, most)[0], minlength=60)
    kept = some > 0
    assert np.array_equal(some[kept], whole[kept])
    assert 0 < some.sum() <= most
    left_out = ~kept & (whole > 0)
    assert whole[left_out].min() >= whole[kept].max()


def test_asked_nothing_it_finds_nothing():
    nobody, nothing = np.zeros(0, np.intp), np.zeros(0)
    query, entry, off = clouds(**SMALL).shared.found((nobody, nobody), (nothing, nothing), ANY)
    assert query.shape == entry.shape == (0,)
    assert off.shape == (0, 2)


def test_made_again_it_is_the_same():
    index, again = clouds(**SMALL).shared, pair_index(clouds(**SMALL).rows)
    assert index.looks == again.looks
    for looks, angles in (((0, 1), (0.3, 2.0)), ((2, 2), (-1.0, 0.5)), ((3, 5), (3.0, -3.0))):
        assert found(index, looks, angles) == found(again, looks, angles) != []


def test_types_in_another_order_have_the_same_pairs_under_other_numbers():
    ready = clouds(**SMALL)
    other = pair_index(ready.rows[::-1])
    assert other.looks == ready.shared.looks
    for looks, angles in (((0, 1), (0.3, 2.0)), ((2, 2), (-1.0, 0.5))):
        assert sorted((2 - kind, *rest) for kind, *rest in found(other, looks, angles)) == found(
            ready.shared, looks, angles
        )


@pytest.mark.parametrize("features", [1, 2])
def test_types_of_one_or_two_features(features):
    index = clouds(count=2, features=features, looks=3, seed=9).shared
    looks = [(a, b) for a in range(3) for b in range(a, 3)]
    rows = [
        row for pair in looks for turn in np.arange(0.1, 6.3, 0.3) for row in found(index, pair, (turn, turn + 1.0))
    ]
    assert features == 2 or not rows


def test_its_tables_are_the_types_own():
    ready = clouds(**SMALL)
    assert len(ready.rows) > 1
    for kind, index in enumerate(ready.rows):
        count = len(index.points)
        assert np.array_equal(ready.shared.points[kind, :count], index.points)
        assert np.array_equal(ready.shared.turns[kind, :count], [f.rotation[:, 0] for f in index.object_type.features])
        assert np.array_equal(ready.shared.centres[kind], index.cells.centre)
