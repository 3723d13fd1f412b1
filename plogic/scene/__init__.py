"""A situation as program text and as a factor graph: worlds, queries, explanations."""
