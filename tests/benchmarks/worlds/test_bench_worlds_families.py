"""The families: as many hypotheses and appearances as asked, conflicts as promised, deterministic, and sound."""

import networkx as nx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.families.bench import CANDIDATES, clusters, grid
from plogic.facts.dependence import Scene
from plogic.facts.sanity import check

READINGS = st.sampled_from(["posterior", "score"])


def conflicts(situation):
    """Who bears on whom: groups, A4, exclusion, appearances that both claim, and who hides whom."""
    scene = Scene(situation)
    graph = nx.Graph()
    graph.add_nodes_from(h.id for h in situation.hypotheses)
    graph.add_edges_from(situation.overlaps | situation.exclusive)
    graph.add_edges_from(
        (x.id, y.id) for x in situation.hypotheses for y in situation.hypotheses if x.group == y.group and x.id < y.id
    )
    for claimants in scene.claimants.values():
        graph.add_edges_from((claimants[0][0].id, h.id) for h, _ in claimants[1:])
    graph.add_edges_from((h.id, g) for h in situation.hypotheses for f in h.features for g in scene.hiders(h, f))
    return graph


def kinds(situation):
    scene = Scene(situation)
    groups = [h.group for h in situation.hypotheses]
    return {
        "A4": bool(situation.overlaps),
        "rivals for one instance": len(set(groups)) < len(groups),
        "shared appearances": any(len({h.id for h, _ in claimants}) > 1 for claimants in scene.claimants.values()),
        "hiding": any(scene.hiders(h, f) for h in situation.hypotheses for f in h.features),
    }


@settings(derandomize=True, deadline=None, max_examples=25)
@given(st.integers(3, 60), st.integers(0, 1000), READINGS)
def test_clusters_have_what_was_asked_for(number, seed, reading):
    situation = clusters(number, seed, reading)
    check(situation)
    assert len(situation.hypotheses) == number
    assert len(situation.appearances) == 2 * number
    assert {sum(h.expects(f) for f in h.features) for h in situation.hypotheses} == {CANDIDATES}
    assert all(any(f.match is None for f in h.features if h.expects(f)) for h in situation.hypotheses)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(st.integers(3, 60), st.integers(0, 1000), READINGS)
def test_nothing_larger_than_six_hangs_together(number, seed, reading):
    graph = conflicts(clusters(number, seed, reading))
    assert max(len(piece) for piece in nx.connected_components(graph)) <= 6


def test_clusters_conflict_in_every_way():
    assert kinds(clusters(40, 0)) == dict.fromkeys(kinds(clusters(40, 0)), True)


def test_who_hides_stands_before():
    """No cycles of occlusion: each hides only what comes after it."""
    situation = clusters(60, 3)
    place = {h.id: i for i, h in enumerate(situation.hypotheses)}
    hiding = [(g, h.id) for h in situation.hypotheses for f in h.features for g in f.hidden_by]
    assert hiding
    assert nx.is_directed_acyclic_graph(nx.DiGraph(hiding))
    assert set(place) >= {g for pair in hiding for g in pair}


@pytest.mark.parametrize("make", [lambda seed: clusters(20, seed), lambda seed: grid(20, 4, seed)])
def test_the_seed_decides_everything(make):
    assert make(7) == make(7)
    assert make(7) != make(8)


@pytest.mark.parametrize(("number", "columns"), [(5, 2), (12, 3), (20, 4), (361, 19), (3, 1)])
def test_a_grid_conflicts_with_its_neighbours_and_nobody_else(number, columns):
    situation = grid(number, columns, 0)
    check(situation)
    wanted = nx.Graph()
    wanted.add_nodes_from(f"h{i}" for i in range(1, number + 1))
    wanted.add_edges_from((f"h{i}", f"h{i + 1}") for i in range(1, number) if i % columns)
    wanted.add_edges_from((f"h{i}", f"h{i + columns}") for i in range(1, number - columns + 1))
    assert nx.utils.graphs_equal(conflicts(situation), wanted)
    assert len(situation.appearances) == 2 * number


def test_rates_are_those_of_the_shipped_towers():
    """Feature types, hit rates, dv, σ, tolerance and clutter are computed from `towers`, not made up."""
    from benchmarks.families.bench import CLUTTER, KINDS, SIGMA, TOLERANCE
    from plogic.measures.distinctiveness import distinctiveness, instance_counts
    from plogic.run.sources import kb_of

    kb = kb_of("towers")
    dv = distinctiveness(instance_counts(kb.types))
    assert {kind: hit for kind, hit, _ in KINDS} == kb.rates.hit
    assert {kind: d for kind, _, d in KINDS} == pytest.approx(dv, abs=0.005)
    assert (kb.rates.sigma, kb.rates.match_tolerance) == (SIGMA, TOLERANCE)
    assert pytest.approx(kb.rates.clutter["l_junction"] / (640 * 480)) == CLUTTER
