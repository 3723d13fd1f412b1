"""Factor graphs by their definition."""

from __future__ import annotations


def log_weight(graph, states):
    """The log weight of one joint state, one state a variable: the sum of the tables' entries."""
    return graph.constant + sum(float(f.table[tuple(states[v] for v in f.scope)]) for f in graph.factors)
