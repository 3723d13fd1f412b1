"""Programs come from strangers: the syntax tree is held to an allow-list, and ProbLog runs with guarded built-ins."""
