"""Programs come from strangers: two layers between them and the machine (issue 2).

``allowlist`` names what may be called; ``check`` holds the syntax tree to it, with file, line and column; ``engine``
is ProbLog's engine with every other built-in overridden, in case the first layer missed something. ``child`` runs
both in a process with limits.
"""
