"""Any ICL/ProbLog program: compiled once to a circuit, then answered, conditioned and ranked from it."""
