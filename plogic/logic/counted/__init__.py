"""Probabilities of queries without a circuit: by sums over tables, or by decision diagrams, where that is cheaper."""
